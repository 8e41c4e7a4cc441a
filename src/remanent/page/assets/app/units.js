// Units: from the dimensionless numbers of the model to SI and back.

import { numberText } from "./numbers.js";

const SAME = { unit: null, to: (x) => x, back: (x) => x };
const KINDS = [
  [/(^|\.)(omega|start|stop)$/, "frequency"],
  [/(^|\.)b$/, "rootLoad"],
  [/(^|\.)(m|mean)$|(^|\.)loads(\.\d+)?$|^load$/, "load"],
  [/^prestress(_\d)?$|\.modulus$/, "stress"],
  [/\.eta$/, "viscosity"],
  [/(^|\.)(relaxation_time|duration)$|(^|\.)times(\.\d+)?$|^(time|drive_period|horizon)$/, "time"],
  [/_rate$|^exponent(_error)?$/, "rate"],
  [/^(energy|stored_energy|potential)$/, "energy"],
];

const kindOf = (name) => KINDS.find(([pattern]) => pattern.test(name))?.[1];

/**
 * How a quantity turns to SI.
 * @param {string} name of a parameter, a state variable or an observable
 * @param {?Object} factors the description's `si`; null where nothing has a physical size
 * @returns {{unit: ?string, to: function(number): number, back: function(number): number}}
 *   unit: null where the quantity keeps its own
 */
export function conversion(name, factors) {
  const kind = factors && kindOf(name);
  return kind ? makers[kind](factors) : SAME;
}

const linear = (unit, factor) =>
  factor ? { unit, to: (x) => x * factor, back: (x) => x / factor } : SAME;

const makers = {
  frequency: ({ frequency }) => linear("Hz", frequency / (2 * Math.PI)),
  load: ({ load }) => linear("mT", load && 1e3 * load),
  rootLoad: ({ load }) =>
    load
      ? { unit: "mT", to: (b) => 1e3 * load * b * Math.abs(b), back: (x) => Math.sign(x) * Math.sqrt(Math.abs(x) / (1e3 * load)) }
      : SAME,
  stress: ({ stress }) => linear("kPa", stress / 1e3),
  viscosity: ({ viscosity }) => linear("Pa s", viscosity),
  time: ({ time }) => linear("ms", 1e3 * time),
  rate: ({ time }) => linear("1/s", 1 / time),
  energy: ({ stress }) => linear("kJ/m³", stress / 1e3),
};

const SHOWN = { 1: "", "K-1": "1/K", "rad": "rad" };

/**
 * The unit of a quantity as it is written; empty where it has none.
 * @param {{name: string, unit: string}} quantity
 * @param {?Object} factors
 * @returns {string}
 */
export function unitText(quantity, factors) {
  const { unit } = conversion(quantity.name, factors);
  const own = kindOf(quantity.name) === "frequency" ? "rad/τ" : (SHOWN[quantity.unit] ?? quantity.unit);
  return unit ?? own;
}

/**
 * What a quantity is called in SI: each has a symbol made of its own, so that no two are equal.
 * A load m is a flux density B, and a time τ is t.
 */
const SI_NAMES = {
  frequency: ({ symbol, text }) => ({ symbol: `${symbol}/2\\pi`, text }),
  load: ({ symbol, text }) => ({ symbol: symbol.replace(/\bm\b|m(?=_)/, "B"), text: text.replace(/magnetic load/, "flux density") }),
  rootLoad: () => ({ symbol: "\\hat{B}", text: "peak flux density" }),
  time: ({ symbol, text }) => ({ symbol: symbol.replace("\\tau", "t"), text }),
};

/**
 * A quantity with the symbol and the name that it has in the units in force.
 * @param {{name: string, symbol: string, text: string}} quantity
 * @param {?Object} factors
 * @returns {Object}
 */
export function named(quantity, factors) {
  const kind = conversion(quantity.name, factors).unit !== null && kindOf(quantity.name);
  return { ...quantity, ...SI_NAMES[kind]?.(quantity) };
}

/**
 * The title of an axis for a quantity of the description.
 * @param {{name: string, unit: string, text: string, symbol: string}} quantity
 * @param {?Object} factors
 * @returns {{text: string, symbol: string, unit: string}}
 */
export function titleOf(quantity, factors) {
  const { text, symbol } = named(quantity, factors);
  return { text, symbol, unit: unitText(quantity, factors) };
}

/**
 * A time with its symbol and unit.
 * @param {number} time in units of tau
 * @param {?Object} factors
 * @param {number} [digits]
 * @returns {string} "τ = 12.5", or "t = 35.1 ms"
 */
export function timeText(time, factors, digits = 4) {
  const { unit, to } = conversion(TIME.name, factors);
  return unit ? `t = ${numberText(to(time), digits)} ${unit}` : `τ = ${numberText(time, digits)}`;
}

/**
 * A frequency with its symbol and unit.
 * @param {number} omega radians in a unit of tau
 * @param {?Object} factors
 * @param {number} digits
 * @returns {string} "ω = 1.25", or "ω/2π = 347 Hz"
 */
export function frequencyText(omega, factors, digits) {
  const { unit, to } = conversion("omega", factors);
  return unit ? `ω/2π = ${numberText(to(omega), digits)} ${unit}` : `ω = ${numberText(omega, digits)}`;
}

/** Time as a quantity. */
export const TIME = { name: "time", unit: "1", text: "time", symbol: "\\tau" };

/**
 * All of an array in SI.
 * @param {ArrayLike<number>} values
 * @param {string} name
 * @param {?Object} factors
 * @returns {ArrayLike<number>} the same array where nothing changes
 */
export function converted(values, name, factors) {
  const { unit, to } = conversion(name, factors);
  return unit === null ? values : Float64Array.from(values, to);
}
