// What the server computes by itself when the page comes to rest: the response and the regime.

import { specWith } from "./spec.js";

/** Milliseconds without a change after which the server is asked. */
const REST_MS = 350;

/**
 * Ask for the response and the regime when nothing has changed for a moment.
 * @param {Object} app
 * @param {{response: Object, regime: Object}} views
 * @returns {{changed: function(): void, forget: function(): void, again: function(): void}}
 */
export function backgroundWork(app, { response, regime }) {
  let timer = null;
  let turn = 0;
  const done = { response: null, regime: null };

  const start = async () => {
    const mine = (turn += 1);
    const scene = app.scene();
    const spec = app.currentSpec();
    const keys = keysOf(app.store.get(), spec);
    if (!regime.isWanted(scene)) {
      regime.unavailable("Regimes are told of motions under a load with a period.");
    }
    if (response.isWanted(scene)) {
      const isKnown = done.response === keys.response && response.covers();
      if (!isKnown && (await response.request(spec)) && mine === turn) {
        done.response = keys.response;
      }
    } else {
      response.say("A frequency response needs a load with a frequency.");
    }
    if (mine === turn && regime.isWanted(scene) && done.regime !== keys.regime && (await regime.request(spec))) {
      done.regime = keys.regime;
    }
  };

  return {
    changed: () => {
      clearTimeout(timer);
      const keys = keysOf(app.store.get(), app.currentSpec());
      if (done.response !== null && done.response !== keys.response) {
        response.outdate();
        done.response = null;
      }
      if (done.regime !== keys.regime) {
        regime.outdate();
        app.showRegime(true);
      }
      timer = setTimeout(start, REST_MS);
    },
    forget: () => {
      done.response = done.regime = null;
      response.forget();
      regime.forget();
    },
    again: () => {
      done.response = done.regime = null;
      clearTimeout(timer);
      start();
    },
  };
}

/** What each result depends on: the response on all but the frequency. */
function keysOf({ description, values, initial, periods }, spec) {
  const still = { ...values };
  const omega = description.parameters.find((one) => one.name === "omega");
  if (omega) {
    still.omega = omega.value;
  }
  return { response: JSON.stringify(specWith(description, still, initial)), regime: JSON.stringify([spec, periods]) };
}
