// The page: what it starts with, what it shows, and what each control does.

import { Refused, ask, isServerThere, onConnection, send } from "./api.js";
import { readAddress, startOf, writeAddress } from "./address.js";
import { actuatorView } from "./actuator_view.js";
import { backgroundWork } from "./background.js";
import { createClock } from "./clock.js";
import { controlPanel } from "./controls.js";
import { byId, refill } from "./dom.js";
import { drawSoon } from "./frames.js";
import { historyView } from "./history_view.js";
import { basinsView, regimeChartView } from "./map_views.js";
import { ownSystemDialog } from "./own_system.js";
import { phaseView } from "./phase_view.js";
import { potentialView } from "./potential_view.js";
import { regimeView } from "./regime_view.js";
import { responseView } from "./response_view.js";
import { relabelled, sceneOf } from "./scene.js";
import { specWith } from "./spec.js";
import { statusBar } from "./status_bar.js";
import { createStore } from "./store.js";
import { storeView } from "./store_view.js";
import { takeAwayDialog } from "./take_away.js";
import { onTheme, startTheme } from "./theme.js";
import { foldingPanel, toolBar } from "./tool_bar.js";

const DEFAULTS = { periods: 500, duration: 100 };

/** What the page starts with: from the file itself where it was saved, else from the server. */
async function startingData() {
  const embedded = byId("start");
  return embedded ? { ...JSON.parse(embedded.textContent), saved: true } : ask("/api/start");
}

/** The state of the page for a model. */
function stateOf(model, field, given = {}) {
  const values = Object.fromEntries(model.parameters.map(({ name, value }) => [name, value]));
  return {
    description: model, field, values, initial: [...model.initial], preset: null, isStart: false,
    defaults: DEFAULTS, ...DEFAULTS, span: "start", si: false, units: "dimensionless", ...given,
  };
}

/** The presets that can be shown: in a saved page those that are of its equations. */
function presetsOf(start) {
  return start.saved ? [] : (start.presets ?? []);
}

async function run() {
  startTheme();
  foldingPanel();
  const start = await startingData();
  const field = await import(start.field);
  const saved = Boolean(start.saved);
  const store = createStore(stateOf(start.model, field, { isStart: true }));
  const app = { start, saved, store, kinds: start.kinds, presets: presetsOf(start) };
  let scene = null;
  app.scene = () => scene;
  app.currentSpec = () => {
    const { description, values, initial } = store.get();
    return specWith(description, values, initial);
  };
  app.isChanged = () => {
    const { description, values } = store.get();
    return description.parameters.some(({ name, value }) => values[name] !== value);
  };
  app.startOf = (k) => startOf(store.get().description, k, store.get().values);

  const views = makeViews(app, start);
  const status = statusBar(app);
  const panel = controlPanel(byId("panel"), app);
  app.clock = createClock({
    instant: (now) => views.live.forEach((view) => view.mark?.(now)),
    state: (on) => views.actuator.playing(on),
  });
  views.actuator.playing(app.clock.isOn());
  app.say = status.say;
  let regime = "";
  app.tellRegime = (text) => {
    regime = text;
    status.regime(regime, false);
  };
  app.outdateRegime = () => status.regime(regime, true);
  const background = saved ? null : backgroundWork(app, views);
  const bar = toolBar(app);

  const draw = () => {
    scene = sceneOf(store.get());
    const integrated = performance.now();
    views.live.forEach((view) => view.draw(scene));
    app.clock.show(scene);
    status.draw(scene);
    panel.show();
    bar.show();
    return integrated;
  };
  const redraw = drawSoon(draw);
  const relabel = () => {
    scene = relabelled(scene, store.get());
    views.live.forEach((view) => view.draw(scene));
    app.clock.show(scene);
    status.draw(scene);
  };
  onTheme(() => scene && relabel());

  const changed = () => {
    redraw();
    background?.changed();
    if (!saved) {
      views.maps.forEach((view) => view.outdate(false));
    } else {
      status.regime(regime, app.isChanged());
    }
  };
  const remember = (how = "pushState") => {
    const address = writeAddress(store.get());
    if (address !== location.hash && !(address === "#" && location.hash === "")) {
      history[how](null, "", address === "#" ? location.pathname + location.search : address);
    }
  };

  app.move = (name, value) => {
    const { values, initial, description } = store.get();
    const followed = description.state.map((one, k) => (one.rest === name && initial[k] === values[name] ? value : initial[k]));
    store.update({ values: { ...values, [name]: value }, initial: followed });
    changed();
  };
  app.moveInitial = (k, value) => {
    const initial = [...store.get().initial];
    initial[k] = value;
    store.update({ initial });
    changed();
  };
  app.moveRun = (name, value) => {
    store.update({ [name]: value });
    changed();
  };
  app.commit = () => remember();
  app.startAt = (initial) => {
    store.update({ initial });
    changed();
    remember();
    app.say("The motion starts there now.");
  };
  app.startAtRest = () => app.startAt(store.get().description.state.map((_, k) => app.startOf(k)));
  app.changeView = (change) => {
    store.update(change);
    relabel();
    remember();
  };
  app.changeUnits = (si) => {
    store.update({ si, units: si ? "SI" : "dimensionless" });
    panel.build();
    resetZooms(views);
    relabel();
    remember();
    bar.show();
  };
  app.retry = async () => {
    if (await isServerThere()) {
      background?.again();
    }
  };
  app.reset = () => {
    const { description } = store.get();
    store.update(stateOf(description, store.get().field, { preset: store.get().preset, isStart: store.get().isStart, si: store.get().si, units: store.get().units }));
    changed();
    remember();
  };

  /** Show another model. */
  const adopt = async (answer, given) => {
    const module = await import(answer.field);
    const { si, units, span } = store.get();
    const keep = Boolean(answer.model.si) && si;
    store.update(stateOf(answer.model, module, { span, si: keep, units: keep ? units : "dimensionless", ...given }));
    panel.build();
    bar.build();
    resetZooms(views);
    views.maps.forEach((view) => view.outdate(true));
    changed();
    showWarnings(answer.model);
  };
  app.chooseSpec = async (spec) => {
    try {
      await adopt(await send("/api/model", { spec }), { periods: store.get().periods });
      remember();
    } catch (error) {
      panel.build();
      tellFaults(error, panel, status);
    }
  };
  app.chooseToml = async (toml) => {
    await adopt(await send("/api/model", { toml }));
    remember();
  };
  const presetSpec = (id) => app.presets.find((one) => one.id === id);
  app.choosePreset = async (id) => {
    const preset = presetSpec(id);
    try {
      await adopt(await send("/api/model", { spec: preset.spec }), { preset: id, ...viewOf(preset) });
      remember();
      app.say(preset.title);
    } catch (error) {
      bar.build();
      tellFaults(error, panel, status);
    }
  };

  /** Show what the address says. */
  const follow = async () => {
    const said = readAddress(location.hash);
    const { preset, description } = store.get();
    const known = said.preset !== null && presetSpec(said.preset) !== undefined;
    let given = { isStart: !known && !said.spec };
    let answer = start;
    try {
      if (known) {
        given = { preset: said.preset, ...viewOf(presetSpec(said.preset)) };
        answer = preset === said.preset ? { model: description, module: store.get().field } : await send("/api/model", { spec: presetSpec(said.preset).spec });
      } else if (said.spec && !saved) {
        answer = await send("/api/model", { spec: said.spec });
      }
    } catch (error) {
      tellFaults(error, panel, status);
    }
    const module = answer.module ?? (await import(answer.field));
    const state = stateOf(answer.model, module, given);
    store.update(withAddress(state, said));
    panel.build();
    bar.build();
    resetZooms(views);
    changed();
    showWarnings(answer.model, said.broken || (said.preset !== null && !known && !saved));
  };
  addEventListener("popstate", follow);

  onConnection((isThere) => {
    status.server(isThere);
    if (isThere) {
      background?.again();
    }
  });
  byId("loading")?.remove();
  await follow0(follow, panel, bar, changed, start);
  draw();
  if (saved) {
    [views.response, views.regime, ...views.maps].forEach((view) => view.showSaved(start.results ?? {}));
    relabel();
    byId("saved").hidden = false;
  }
  document.documentElement.dataset.ready = "true";
  if (!saved && !start.store && location.hash === "") {
    await nameStart(app, bar);
  }
}

/** Where the server was asked for nothing, the page shows its first preset: say which. */
async function nameStart(app, bar) {
  const [first] = app.presets;
  if (!first) {
    return;
  }
  try {
    const { model } = await send("/api/model", { spec: first.spec });
    const { preset, isStart } = app.store.get();
    if (isStart && preset === null && JSON.stringify(model.spec) === JSON.stringify(app.start.model.spec)) {
      app.store.update({ preset: first.id, isStart: false });
      bar.build();
    }
  } catch (error) {
    console.debug(error.message);
  }
}

async function follow0(follow, panel, bar, changed, start) {
  if (location.hash.length > 1) {
    await follow();
  } else {
    panel.build();
    bar.build();
    changed();
    showWarnings(start.model);
  }
}

function viewOf(preset) {
  const { periods, duration, span } = preset?.view ?? {};
  return Object.fromEntries(Object.entries({ periods, duration, span }).filter(([, value]) => value !== undefined));
}

function withAddress(state, said) {
  const values = { ...state.values };
  for (const [name, value] of Object.entries(said.values)) {
    if (name in values) {
      values[name] = value;
    }
  }
  const initial = state.description.state.map((one, k) => said.initial[one.name] ?? (said.values[one.rest] !== undefined ? startOf(state.description, k, values) : state.initial[k]));
  const view = Object.fromEntries(Object.entries(said.view).filter(([, value]) => value !== undefined));
  const si = view.units === "SI" && Boolean(state.description.si);
  return { ...state, values, initial, ...view, si, units: si ? "SI" : "dimensionless" };
}

function makeViews(app, start) {
  const views = { actuator: actuatorView(app), history: historyView(app), phase: phaseView(app), potential: potentialView(app), response: responseView(app), regime: regimeView(app), basins: basinsView(app), regime_chart: regimeChartView(app) };
  const nodes = Object.values(views).map((view) => view.node);
  if (start.store) {
    views.store = storeView(app, start.store);
    nodes.splice(2, 0, views.store.node);
    views.store.load();
  }
  byId("views").append(...nodes);
  const dialog = takeAwayDialog(app);
  app.save = dialog.open;
  app.openOwnSystem = ownSystemDialog(app).open;
  app.figures = () => Object.entries(views)
    .filter(([, view]) => view.figure && !view.node.hidden)
    .map(([id, view]) => ({ id, title: view.figure().title, figure: view.figure }))
    .filter(({ figure }) => figure().plotly !== null);
  views.maps = [views.basins, views.regime_chart];
  views.live = [views.history, views.phase, views.potential, views.actuator, views.response, views.regime, ...views.maps];
  return views;
}

function resetZooms({ live }) {
  live.forEach(({ plot }) => {
    if (plot) {
      plot.zoom = {};
      plot.fitted = {};
    }
  });
}

function tellFaults(error, panel, status) {
  const faults = error instanceof Refused ? error.faults : [];
  const unplaced = faults.filter((fault) => !panel.fault(fault)).map(({ message }) => message);
  const words = faults.length ? unplaced.join(" ") : error.message;
  if (words) {
    byId("banner").hidden = false;
    byId("banner").textContent = words;
    status.say(words);
  }
}

function showWarnings({ warnings }, broken = false) {
  const words = [...(warnings ?? [])];
  if (broken) {
    words.unshift("A part of the address could not be read; the rest is shown.");
  }
  byId("banner").hidden = words.length === 0;
  byId("banner").textContent = words.join(" ");
}

run().catch((error) => {
  console.warn(error);
  const place = byId("loading") ?? byId("banner");
  place.hidden = false;
  refill(place, `The page could not start: ${error.message} `);
  const again = document.createElement("button");
  again.type = "button";
  again.textContent = "Try again";
  again.addEventListener("click", () => location.reload());
  place.append(again);
});
