// The state of the page: a model with its numbers, and how it is looked at.

import { startOf } from "./address.js";
import { isWithin } from "./numbers.js";

/** Lengths of runs where nothing else is said. */
const LENGTHS = { periods: 500, duration: 100 };
/** Between which numbers the length of a run lies. */
export const LENGTH_LIMITS = {
  periods: { least: 1, least_included: true, most: 5000, most_included: true },
  duration: { least: 0, least_included: false, most: 20000, most_included: true },
};
const SPANS = ["start", "end", "all"];

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
 * Between which numbers the start of a state variable lies.
 * @param {{positive: boolean}} variable
 * @returns {Object}
 */
export function startLimits({ positive }) {
  return positive ? { least: 0, least_included: false } : {};
}

/**
 * The length of the run as the server is asked for it.
 * @param {Object} state
 * @returns {{periods: number}|{duration: number}}
 */
export function lengthOf({ description, periods, duration }) {
  return description.drive.periodic ? { periods } : { duration };
}

/**
 * A state with what an address says, as far as the page could have written it.
 * @param {Object} state
 * @param {Object} said of `readAddress`
 * @returns {{state: Object, isBroken: boolean}} isBroken: something was left out
 */
export function withAddress(state, said) {
  const { description } = state;
  const limits = new Map(description.parameters.map((one) => [one.name, one.fixed ? null : [one.limits, one.bounds]]));
  const starts = new Map(description.state.map((one) => [one.name, [startLimits(one), one.bounds]]));
  const given = allowed(said.values, limits);
  const started = allowed(said.initial, starts);
  const values = { ...state.values, ...Object.fromEntries(given) };
  const start = new Map(started);
  const initial = description.state.map((one, k) => start.get(one.name) ?? startOf(description, k, values));
  const { span, units, ...lengths } = said.view;
  const run = allowed(lengths, new Map(Object.entries(LENGTH_LIMITS).map(([name, one]) => [name, [one]])))
    .filter(([name, value]) => name !== "periods" || Number.isInteger(value));
  const si = units === "SI" && Boolean(description.si);
  const isLookKnown = [undefined, ...SPANS].includes(span) && [undefined, "SI", "dimensionless"].includes(units);
  const asked = [said.values, said.initial, lengths].reduce((sum, table) => sum + Object.keys(table).length, 0);
  return {
    state: {
      ...state, values, initial, ...Object.fromEntries(run), span: SPANS.includes(span) ? span : state.span,
      si, units: si ? "SI" : "dimensionless",
    },
    isBroken: !isLookKnown || given.length + started.length + run.length < asked,
  };
}

/** The entries of a table of numbers whose names are known and whose values are within their limits. */
function allowed(table, limits) {
  return Object.entries(table).filter(([name, value]) => limits.get(name)?.every((one) => isWithin(one, value)));
}
