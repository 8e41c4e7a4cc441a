// The regime of the motion, with the evidence for it.

import { jobCard } from "./job_card.js";
import { button, element, refill } from "./dom.js";
import { errorText, numberText } from "./numbers.js";
import { symbolElement } from "./symbols.js";
import { conversion, named, unitText } from "./units.js";

/** Fewest and most drive periods that are looked at. */
const [LEAST, MOST] = [100, 2000];
/** How many times more are looked at where these do not suffice, and at most. */
const [FURTHER, LONGEST] = [4, 10000];
const PAIRS = { exponent: "exponent_error", rotation_number: "rotation_number_error" };
const WORDS = {
  periodic: "repeats after a whole number of drive periods",
  "quasi-periodic": "has two frequencies without a common multiple",
  chaotic: "neighbouring motions part exponentially",
  undecided: "the evidence does not suffice",
  escaped: "leaves every bound",
};

/**
 * The view of the regime.
 * @param {Object} app
 * @returns {Object} with `node`, `request`, `showSaved`, `outdate`
 */
export function regimeView(app) {
  const view = jobCard(app, { id: "regime", title: "Regime", job: "classify" });
  let factors = null;
  let table = null;
  const show = (result, prefix = "") => {
    const [one] = result.series;
    table = () => evidence(one, factors);
    refill(view.body, heading(one), longer(one, result.settings?.periods), table());
    view.body.classList.remove("stale");
    view.say(prefix + noteOf(result));
    app.tellRegime(sentence(one));
  };
  const look = async (spec, periods) => {
    view.body.classList.add("stale");
    const result = await view.run(spec, { periods });
    if (result) {
      show(result);
    }
    return result;
  };
  /** Where the evidence does not suffice, a longer run may have more of it. */
  const longer = (one, periods) => {
    const more = Math.min(LONGEST, FURTHER * periods);
    return !app.saved && valueOf(one, "regime") === "undecided" && more > periods
      ? button(`Look at ${more} periods`, () => look(app.currentSpec(), more), { class: "quiet", id: "look-longer" })
      : null;
  };
  return {
    node: view.node,
    cancel: view.cancel,
    draw: (scene) => {
      view.node.hidden = app.saved ? !app.hasResults : !scene.description.drive.periodic;
      if (scene.factors !== factors) {
        factors = scene.factors;
        view.body.querySelector(".evidence")?.replaceWith(table());
      }
    },
    isWanted: (scene) => scene.description.drive.periodic,
    request: (spec) => look(spec, Math.min(MOST, Math.max(LEAST, app.store.get().periods))),
    forget: () => {
      refill(view.body);
      view.say("");
    },
    outdate: () => view.body.classList.add("stale"),
    showSaved: (results) => {
      if (results.classify?.series.length) {
        show(results.classify, "As computed when this page was saved. ");
      } else {
        refill(view.body);
        view.say(results.classify?.reason || "The page was saved without a regime.");
        app.tellRegime("");
      }
    },
    unavailable: (text) => {
      refill(view.body);
      view.say(text);
      app.tellRegime("");
    },
  };
}

function valueOf(one, name) {
  return [one[name]?.values].flat()[0] ?? null;
}

function sentence(one) {
  const regime = valueOf(one, "regime");
  const period = valueOf(one, "period");
  return regime === "periodic" && period ? `periodic, ${period} drive ${period === 1 ? "period" : "periods"}` : String(regime ?? "not determined");
}

function heading(one) {
  const regime = valueOf(one, "regime");
  return element("div", { class: "regime-head" },
    element("strong", { class: `regime regime-${regime}`, text: sentence(one) }),
    element("span", { text: WORDS[regime] ?? "" }));
}

function evidence(one, factors) {
  const names = Object.keys(one).filter((name) =>
    one[name]?.values !== undefined && !["regime", "period"].includes(name) && !Object.values(PAIRS).includes(name));
  const rows = names.map((name) => {
    const { text, symbol } = named(one[name], factors);
    const { to } = conversion(name, factors);
    const unit = unitText(one[name], factors);
    const value = valueOf(one, name);
    const error = PAIRS[name] && valueOf(one, PAIRS[name]);
    const shown = typeof value === "number" ? numberText(to(value), 4) : String(value ?? "not determined");
    return element("tr", {},
      element("th", { scope: "row" }, text, " ", symbolElement(symbol)),
      element("td", { text: `${shown}${typeof error === "number" ? ` ± ${errorText(to(error))}` : ""}${unit ? ` ${unit}` : ""}` }));
  });
  return element("table", { class: "evidence" }, element("caption", { class: "hidden-words", text: "evidence for the regime" }), element("tbody", {}, ...rows));
}

function noteOf({ settings, series, reason, statuses }) {
  const status = [series[0].status].flat()[0];
  const words = status && status !== "ok" ? ` ${statuses?.[status] ?? status}` : "";
  return `Over ${settings?.periods ?? "some"} drive periods, by the engine.${words}${reason ? ` ${reason}.` : ""}`;
}
