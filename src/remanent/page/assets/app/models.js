// Other models: presets, kinds of parts, one's own systems, and what an address says.

import { remember } from "./actions.js";
import { readAddress } from "./address.js";
import { Refused, ServerGone, onConnection, send } from "./api.js";
import { byId } from "./dom.js";
import { initialState, viewOf, withAddress } from "./state.js";

/**
 * Add to the page what shows another model: `chooseSpec`, `trySpec`, `chooseToml`, `choosePreset`;
 * `trySpec` leaves it to the one who calls to tell what is wrong with a spec.
 * @param {Object} app
 */
export function addModels(app) {
  app.trySpec = (spec) => {
    const { periods, duration, defaults } = app.store.get();
    return adopt(app, { spec }, { periods, duration, defaults });
  };
  app.chooseSpec = (spec) => told(app, () => app.trySpec(spec));
  app.chooseToml = (toml) => adopt(app, { toml }, {});
  app.choosePreset = (id) => told(app, async () => {
    const preset = presetOf(app, id);
    await adopt(app, { spec: preset.spec }, { preset: id, ...viewOf(preset) });
    app.say(preset.title);
  });
  addEventListener("popstate", () => followAddress(app));
  onConnection((isThere) => {
    if (isThere && byId("banner").textContent === new ServerGone().message) {
      showBanner("");
    }
  });
}

function presetOf(app, id) {
  return app.presets.find((one) => one.id === id);
}

/** Do something; put what went wrong beside its field, or in the banner. */
async function told(app, action) {
  try {
    await action();
  } catch (error) {
    app.panel.build();
    app.bar.build();
    tellFaults(app, error);
  }
}

function tellFaults(app, error) {
  const faults = error instanceof Refused ? error.faults : [];
  const unplaced = faults.filter((fault) => !app.panel.fault(fault)).map(({ message }) => message);
  const words = faults.length ? unplaced.join(" ") : error.message;
  showBanner(words);
  if (words) {
    app.say(words);
  }
}

function showBanner(words) {
  byId("banner").hidden = !words;
  byId("banner").textContent = words;
}

let lastQuestion = 0;

/** A model that was asked for: of the server, or of the file itself where the page was saved. */
async function modelFor(app, question) {
  if (!app.saved) {
    return send("/api/model", question);
  }
  const found = savedModels(app).find(({ model }) => isEqual(model.spec, question.spec));
  if (!found) {
    throw new Error("This page was saved with other equations. Open the address with “remanent explore”.");
  }
  return found;
}

/** Every model that a saved page holds: what it was saved with, and its presets. */
function savedModels({ start, presets }) {
  return [start, ...presets];
}

function isEqual(one, other) {
  return JSON.stringify(one) === JSON.stringify(other);
}

/**
 * What a saved page holds of the model that it shows: `results`, `reproduction`, `exports`.
 * @param {Object} app
 * @returns {Object}
 */
export function heldOf(app) {
  const { id, spec } = app.store.get().description;
  const same = savedModels(app).filter(({ model }) => model.id === id);
  return same.find(({ model }) => isEqual(model.spec, spec)) ?? same[0] ?? {};
}

/** Ask for a model and show it, unless something else was asked for meanwhile. */
async function adopt(app, question, given) {
  const mine = (lastQuestion += 1);
  const { model, field } = await modelFor(app, question);
  const module = await import(field);
  if (mine !== lastQuestion) {
    return;
  }
  const { si, units, span } = app.store.get();
  const keep = Boolean(model.si) && si;
  present(app, initialState(model, module, { span, si: keep, units: keep ? units : "dimensionless", ...given }));
  remember(app);
}

const BROKEN = "A part of the address could not be read; the rest is shown.";

/** Show a state of another model, and words about it. */
function present(app, state, words = []) {
  const isOther = app.store.get().description.id !== state.description.id;
  app.store.update(state);
  app.panel.build();
  app.bar.build();
  app.resetZooms();
  if (isOther) {
    app.views.maps.forEach((view) => view.outdate(true));
    app.background?.forget();
    app.tellRegime("");
  }
  if (app.saved) {
    showSavedResults(app);
  }
  app.changed();
  showBanner([...words, ...state.description.warnings].join(" "));
}

const SAVED = "A saved page: curves follow the sliders; frequency response, regime, basins and chart are as they were computed when it was saved.";
const SAVED_ELSEWHERE = "A saved page: curves follow the sliders; frequency response, regime, basins and chart are of the system that it was saved with.";

/** What the server would compute, as it was when the page was saved. */
function showSavedResults(app) {
  const { response, regime, maps } = app.views;
  app.drawNow();
  const { results } = heldOf(app);
  app.hasResults = results !== undefined;
  byId("saved").textContent = app.hasResults ? SAVED : SAVED_ELSEWHERE;
  [response, regime, ...maps].forEach((view) => view.showSaved(results ?? {}));
  app.relabel();
}

/** Show what the address says. */
async function followAddress(app) {
  const said = readAddress(location.hash);
  const preset = said.preset === null ? undefined : presetOf(app, said.preset);
  const mine = (lastQuestion += 1);
  const { state, refusal } = await stateOfAddress(app, said, preset);
  if (mine === lastQuestion) {
    const isUnknown = said.preset !== null && !preset;
    const shown = withAddress(state, refusal ? { values: {}, initial: {}, view: said.view } : said);
    const words = said.broken || isUnknown || (shown.isBroken && !refusal) ? [BROKEN] : [];
    present(app, shown.state, [...words, ...(refusal ? [refusal] : [])]);
    if (refusal) {
      app.say(refusal);
    }
  }
}

/** The state before the numbers of an address, and why it is not that of its system. */
async function stateOfAddress(app, said, preset) {
  const { start, store } = app;
  let refusal = "";
  const before = store.get();
  if (preset && before.preset === said.preset) {
    return { state: initialState(before.description, before.field, { preset: preset.id, ...viewOf(preset) }) };
  }
  const spec = preset?.spec ?? said.spec;
  if (spec) {
    try {
      const { model, field } = await modelFor(app, { spec });
      return { state: initialState(model, await import(field), { preset: preset?.id ?? null, ...viewOf(preset) }) };
    } catch (error) {
      refusal = `The system of the address cannot be shown. ${error.message}`;
    }
  }
  const named = presetOf(app, app.startPreset);
  const given = named ? { preset: named.id, ...viewOf(named) } : { isStart: !app.saved };
  return { state: initialState(start.model, await import(start.field), given), refusal };
}

/**
 * Show what the page begins with: what its address says, or what the server was asked for.
 * @param {Object} app
 */
export async function showFirst(app) {
  if (location.hash.length > 1) {
    await followAddress(app);
  } else {
    present(app, app.store.get());
    nameStart(app);
  }
  app.drawNow();
}

/** Where the page shows its first preset since nothing else was asked for, say which. */
async function nameStart(app) {
  const [first] = app.presets;
  if (!first || app.start.store) {
    return;
  }
  try {
    const { model } = await modelFor(app, { spec: first.spec });
    const { preset, description } = app.store.get();
    if (description === app.start.model && preset === null && isEqual(model.spec, description.spec)) {
      app.startPreset = first.id;
      app.store.update({ preset: first.id, isStart: false, defaults: viewOf(first).defaults });
      app.bar.build();
    }
  } catch (error) {
    console.debug(error.message);
  }
}
