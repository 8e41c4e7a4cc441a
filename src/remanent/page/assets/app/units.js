// Units: from the dimensionless numbers of the model to SI and back.

const SAME = { unit: null, to: (x) => x, back: (x) => x };
const KINDS = [
  [/(^|\.)omega$/, "frequency"],
  [/(^|\.)b$/, "rootLoad"],
  [/(^|\.)(m|mean)$|(^|\.)loads\.\d+$|^load$/, "load"],
  [/^prestress(_\d)?$|\.modulus$/, "stress"],
  [/\.eta$/, "viscosity"],
  [/(^|\.)(relaxation_time|start|stop|duration)$|(^|\.)times\.\d+$|^time$/, "time"],
  [/_rate$/, "rate"],
  [/^(energy|stored_energy|potential)$/, "energy"],
];

/**
 * How a quantity turns to SI.
 * @param {string} name of a parameter, a state variable or an observable
 * @param {?Object} factors the description's `si`; null where nothing has a physical size
 * @returns {{unit: ?string, to: function(number): number, back: function(number): number}}
 *   unit: null where the quantity keeps its own
 */
export function conversion(name, factors) {
  const kind = factors && KINDS.find(([pattern]) => pattern.test(name))?.[1];
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
  const own = /(^|\.)omega$/.test(quantity.name) ? "rad/τ" : (SHOWN[quantity.unit] ?? quantity.unit);
  return unit ?? own;
}

/** Quantities that have another symbol, and perhaps another name, in SI. */
const SI_NAMES = {
  frequency: { symbol: "f" },
  load: { symbol: "B", text: "flux density" },
  rootLoad: { symbol: "B", text: "peak flux density" },
};

/**
 * A quantity with the symbol and the name that it has in the units in force.
 * @param {{name: string, symbol: string, text: string}} quantity
 * @param {?Object} factors
 * @returns {Object}
 */
export function named(quantity, factors) {
  const kind = conversion(quantity.name, factors).unit !== null && KINDS.find(([pattern]) => pattern.test(quantity.name))?.[1];
  return { ...quantity, ...(SI_NAMES[kind] ?? {}) };
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

/** Time as a quantity. */
export const TIME = { name: "time", unit: "1", text: "time", symbol: "\\tau" };
/** Time in SI has another letter. */
export const SI_TIME = { ...TIME, symbol: "t" };

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
