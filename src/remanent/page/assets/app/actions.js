// What controls and figures do to the state of the page.

import { isServerThere } from "./api.js";
import { startOf, writeAddress } from "./address.js";
import { initialState } from "./state.js";
import { specWith } from "./spec.js";

/**
 * Add to the page what its controls call.
 * @param {Object} app
 */
export function addActions(app) {
  addQuestions(app);
  addMoves(app);
  addLooks(app);
  addRegime(app);
}

function addQuestions(app) {
  const { store } = app;
  app.currentSpec = () => {
    const { description, values, initial } = store.get();
    return specWith(description, values, initial);
  };
  app.isChanged = () => {
    const { description, values } = store.get();
    return description.parameters.some(({ name, value }) => values[name] !== value);
  };
  app.startOf = (k) => startOf(store.get().description, k, store.get().values);
}

/** Numbers that move: every curve follows at once, the server when they have come to rest. */
function addMoves(app) {
  const { store } = app;
  app.changed = () => {
    app.redraw();
    app.background?.changed();
    if (app.saved) {
      app.showRegime(app.isChanged());
    } else {
      app.views.maps.forEach((view) => view.outdate(false));
    }
  };
  app.move = (name, value) => {
    const { values, initial, description } = store.get();
    const follows = (one, k) => one.rest === name && initial[k] === values[name];
    const followed = description.state.map((one, k) => (follows(one, k) ? value : initial[k]));
    store.update({ values: { ...values, [name]: value }, initial: followed });
    app.changed();
  };
  app.moveInitial = (k, value) => {
    store.update({ initial: store.get().initial.map((old, i) => (i === k ? value : old)) });
    app.changed();
  };
  app.moveRun = (name, value) => {
    store.update({ [name]: value });
    app.changed();
  };
  app.commit = () => remember(app);
  app.startAt = (initial) => {
    store.update({ initial });
    app.changed();
    remember(app);
    app.say("The motion starts there now.");
  };
  app.startAtRest = () => app.startAt(store.get().description.state.map((_, k) => app.startOf(k)));
  app.reset = () => {
    const { description, field, preset, isStart, si, units, defaults } = store.get();
    store.update(initialState(description, field, { preset, isStart, si, units, defaults, ...defaults }));
    app.changed();
    remember(app);
  };
}

/** How it is looked at, which moves no curve. */
function addLooks(app) {
  app.changeView = (change) => {
    app.store.update(change);
    app.relabel();
    remember(app);
  };
  app.changeUnits = (si) => {
    app.store.update({ si, units: si ? "SI" : "dimensionless" });
    app.panel.build();
    app.resetZooms();
    app.relabel();
    app.bar.show();
    remember(app);
  };
  app.retry = isServerThere;
}

function addRegime(app) {
  let regime = "";
  app.tellRegime = (text) => {
    regime = text;
    app.showRegime(false);
  };
  app.showRegime = (isOld) => app.status.regime(regime, isOld);
}

/**
 * Put what is shown into the address, as a step that the browser goes back from.
 * @param {Object} app
 */
export function remember(app) {
  const address = writeAddress(app.store.get());
  if (address !== location.hash && !(address === "#" && location.hash === "")) {
    history.pushState(null, "", address === "#" ? location.pathname + location.search : address);
  }
}
