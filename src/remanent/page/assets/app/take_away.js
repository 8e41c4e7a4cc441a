// Take it away: figures, data, Python lines, the study file, the equations.

import { send, sendForFile } from "./api.js";
import { button, byId, element, menu, refill } from "./dom.js";
import { download, figureFile } from "./figure_export.js";
import { inTurn } from "./jobs.js";
import { heldOf } from "./models.js";
import { lengthOf } from "./state.js";

const LANGUAGES = [
  ["matlab", "MATLAB, Octave"], ["python", "Python (SciPy)"], ["julia", "Julia"], ["auto07p", "AUTO-07p"], ["c", "C"], ["javascript", "JavaScript"],
];

/**
 * The dialog from which everything can be taken away.
 * @param {Object} app
 * @returns {{open: function(?string): void}} open: with a view whose figure is chosen
 */
export function takeAwayDialog(app) {
  const dialog = byId("take-away");
  const open = (chosen) => {
    refill(dialog, head(dialog), figureSection(app, chosen), dataSection(app), textSection(app), equationSection(app));
    dialog.showModal();
  };
  return { open };
}

/**
 * The head of a dialog, with its button to close.
 * @param {HTMLDialogElement} dialog
 * @param {string} [title]
 * @returns {HTMLElement}
 */
export function head(dialog, title = "Take it away") {
  return element("header", { class: "dialog-head" }, element("h2", { id: `${dialog.id}-title`, text: title }), button("Close", () => dialog.close(), { class: "quiet" }));
}

function section(title, ...children) {
  return element("section", { class: "dialog-part" }, element("h3", { text: title }), ...children);
}

/** Run an action; say beside it what went wrong. */
function guarded(words, action) {
  return async () => {
    words.textContent = "";
    try {
      await action();
    } catch (error) {
      words.textContent = error.message;
    }
  };
}

function figureSection(app, chosen) {
  const figures = app.figures();
  const words = element("p", { class: "fault", role: "alert" });
  const choice = menu(figures.map(({ id, title }) => ({ value: id, text: title })), chosen ?? figures[0]?.id, () => {}, { "aria-label": "figure" });
  const save = (format) => guarded(words, async () => {
    const figure = figures.find(({ id }) => id === choice.value).figure();
    download(await figureFile(figure, format), `${figure.name}.${format}`);
  });
  return section("Figure", element("div", { class: "row" }, choice, button("SVG", save("svg"), { id: "save-svg" }), button("PNG", save("png"), { id: "save-png" })), words);
}

function dataSection(app) {
  const words = element("p", { class: "fault", role: "alert" });
  const fromServer = (format, ending) => button(format === "netcdf" ? "netCDF" : "CSV", guarded(words, async () => {
    words.textContent = "computing …";
    const asked = { spec: app.currentSpec(), ...lengthOf(app.store.get()), format };
    const file = await inTurn(() => sendForFile("/api/data", asked, `motion.${ending}`));
    words.textContent = "";
    download(file.blob, file.name);
  }), { id: `data-${format}` });
  const own = button("CSV of the curves", guarded(words, async () => {
    download(new Blob([curvesAsCsv(app.scene())], { type: "text/csv" }), "curves.csv");
  }), { id: "data-curves" });
  const text = app.saved ? "The curves of this page, with their stated error." : "The motion computed by the engine, or the curves of this page, with their errors.";
  return section("Data", element("p", { class: "quiet-words", text }), element("div", { class: "row" }, ...(app.saved ? [] : [fromServer("netcdf", "nc"), fromServer("csv", "csv")]), own), words);
}

function curvesAsCsv({ motion, description }) {
  const state = description.state.map(({ name }) => name);
  const observed = description.observables.map(({ name }) => name).filter((name) => !state.includes(name));
  const at = new Map(description.observables.map(({ name }, k) => [name, motion.observables[k]]));
  const columns = [motion.t, ...motion.y, ...observed.map((name) => at.get(name)), motion.error];
  const rows = [["time", ...state, ...observed, "error_share"].join(",")];
  for (let i = 0; i < motion.t.length; i += 1) {
    rows.push(columns.map((column) => column[i]).join(","));
  }
  return `${rows.join("\n")}\n`;
}

/** A text with buttons to copy it and to save it. */
function textBox(name, text) {
  const copied = element("span", { class: "quiet-words", role: "status" });
  const copy = button("Copy", async () => {
    try {
      await navigator.clipboard.writeText(text);
      copied.textContent = "copied";
    } catch {
      getSelection().selectAllChildren(block);
      copied.textContent = "selected; press Ctrl+C";
    }
  }, { "aria-label": `copy ${name}` });
  const save = button("Save", () => download(new Blob([text], { type: "text/plain" }), name), { class: "quiet", "aria-label": `save ${name}` });
  const block = element("pre", { tabindex: 0, "aria-label": name, text });
  return element("div", { class: "text-box" }, element("div", { class: "row" }, element("code", { text: name }), copy, save, copied), block);
}

function textSection(app) {
  const host = element("div", {}, element("p", { class: "quiet-words", text: "asking the server …" }));
  const fill = ({ python, study }) => refill(host, textBox("motion.py", python), textBox("study.toml", study));
  if (app.saved) {
    const given = heldOf(app).reproduction;
    if (given) {
      fill(given);
    } else {
      refill(host, element("p", { class: "quiet-words", text: "The saved page has them not; open it with remanent explore." }));
    }
    if (given && app.isChanged()) {
      host.prepend(element("p", { class: "quiet-words", text: "These lines make the page as it was saved, before its sliders were moved." }));
    }
  } else {
    send("/api/reproduce", { spec: app.currentSpec(), ...lengthOf(app.store.get()) }).then(fill, (error) => refill(host, element("p", { class: "fault", role: "alert", text: error.message })));
  }
  return section("The lines that make it", host);
}

function equationSection(app) {
  const host = element("div");
  const words = element("p", { class: "fault", role: "alert" });
  const files = (app.saved && heldOf(app).exports) || {};
  const show = (given) => refill(host, ...Object.entries(given).map(([name, text]) => textBox(name, text)));
  const languages = LANGUAGES.filter(([value]) => !app.saved || value in files);
  if (!languages.length) {
    return section("Equations", element("p", { class: "quiet-words", text: "Equations in other languages come from the server: remanent explore, or remanent export." }));
  }
  const choose = guarded(words, async () => {
    refill(host);
    const language = choice.value;
    const given = app.saved ? files[language] : (await send("/api/export", { spec: app.currentSpec(), language })).files;
    if (choice.value === language) {
      show(given);
    }
  });
  const choice = menu(languages.map(([value, text]) => ({ value, text })), languages[0][0], choose, { "aria-label": "language of the equations", id: "language" });
  return section("Equations", element("div", { class: "row" }, choice, button("Show", choose, { id: "show-equations" })), words, host);
}
