// The state of the page: a model with its numbers, and how it is looked at.

import { startOf } from "./address.js";

/** Lengths of runs where nothing else is said. */
const LENGTHS = { periods: 500, duration: 100 };

/**
 * The state of the page for a model.
 * @param {Object} description
 * @param {Object} field the module with its equations
 * @param {Object} [given] entries of the state that are known: `preset`, `isStart`, `span` ...
 * @returns {Object}
 */
export function initialState(description, field, given = {}) {
  const values = Object.fromEntries(description.parameters.map(({ name, value }) => [name, value]));
  return {
    description, field, values, initial: [...description.initial], preset: null, isStart: false,
    defaults: LENGTHS, ...LENGTHS, span: "start", si: false, units: "dimensionless", ...given,
  };
}

/**
 * How a preset is looked at: the length of its run.
 * @param {?Object} preset
 * @returns {Object} entries of the state
 */
export function viewOf(preset) {
  const lengths = { ...LENGTHS };
  for (const name of Object.keys(LENGTHS)) {
    lengths[name] = preset?.view?.[name] ?? lengths[name];
  }
  return { ...lengths, defaults: lengths };
}

/**
 * A state with what an address says.
 * @param {Object} state
 * @param {Object} said of `readAddress`
 * @returns {Object}
 */
export function withAddress(state, said) {
  const { description } = state;
  const known = Object.entries(said.values).filter(([name]) => name in state.values);
  const values = { ...state.values, ...Object.fromEntries(known) };
  const initial = description.state.map((one, k) => said.initial[one.name] ?? startOf(description, k, values));
  const view = Object.fromEntries(Object.entries(said.view).filter(([, value]) => value !== undefined));
  const si = view.units === "SI" && Boolean(description.si);
  return { ...state, values, initial, ...view, si, units: si ? "SI" : "dimensionless" };
}
