// One's own system: the text of a study file, pasted or from a file.

import { button, byId, element, refill } from "./dom.js";
import { head } from "./take_away.js";

const EXAMPLE = `[system]
kind = "LagrangianSystem"
coordinates = ["x"]
kinetic = "x_rate**2/2"
potential = "-x**2/2 + x**4/4 - load*x"
dissipation = "delta*x_rate**2/2"
parameters = { delta = 0.15 }
observable = "x"
rest = { x = 1.0 }

[drive]
kind = "Sine"
m = 0.3
omega = 1.0
`;

/**
 * The dialog that takes the text of a study file.
 * @param {Object} app with `chooseToml`
 * @returns {{open: function(): void}}
 */
export function ownSystemDialog(app) {
  const dialog = byId("own-system");
  const text = element("textarea", { id: "study-text", rows: 16, spellcheck: "false", "aria-describedby": "study-fault" });
  const fault = element("p", { class: "fault", id: "study-fault", role: "alert" });
  const file = element("input", { type: "file", accept: ".toml,text/plain", "aria-label": "a study file" });
  file.addEventListener("change", async () => {
    if (file.files[0]) {
      text.value = await file.files[0].text();
    }
  });
  const load = async () => {
    fault.textContent = "";
    try {
      await app.chooseToml(text.value);
      dialog.close();
    } catch (error) {
      fault.textContent = error.faults?.length ? error.faults.map(lineOf).join("\n") : error.message;
      text.focus();
    }
  };
  const open = () => {
    text.value ||= EXAMPLE;
    refill(dialog, head(dialog, "One’s own system"),
      element("p", { class: "quiet-words", text: "Paste a study file, or open one: tables [actuator] or [system], and [drive]. Other tables are not needed." }),
      element("label", { for: "study-text", text: "study file" }), text, fault,
      element("div", { class: "row" }, file, button("Load", load, { class: "primary", id: "load-study" })));
    dialog.showModal();
  };
  return { open };
}

function lineOf({ table, key, message }) {
  const place = [table, key].filter(Boolean).join(" ");
  return place && !message.includes(key) ? `${place}: ${message}` : message;
}
