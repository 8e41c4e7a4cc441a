/** The potential along the coordinate of a system, and where nothing moves in it. */

import { constantsOf } from "./stepper.js";

/** Places of the curve. */
const PLACES = 400;
/** Instants at which extremes of the load are looked for: in a period, among pieces, in each. */
const PHASES = 256;
const INSTANTS = 4096;
const LEAST_PHASES = 8;
/** How long a piece without an end is looked through. */
const LONG_TIME = 200;
/** Halvings of an interval in which a force changes its sign. */
const HALVINGS = 60;
/** Half of the distance over which a slope is taken. */
const SLOPE_STEP = 1e-5;

/**
 * The potential at one load.
 *
 * @typedef {object} Landscape
 * @property {number} load
 * @property {Float64Array} energy at each place of the coordinate
 * @property {{x: number, observable: number, energy: number, stable: boolean}[]} equilibria
 */

/** The potential without a load, at the least load and at the largest.
 *
 * Internal variables are relaxed, temperatures are those of the start, and rates are 0.
 *
 * @param {object} field module with the equations
 * @param {object} options
 * @param {object} options.description of the model, for the roles of the state variables
 * @param {object} [options.parameters] values by name
 * @param {number[]} options.initial the state at time 0
 * @param {number} [options.low] where the coordinate begins
 * @param {number} [options.high] and where it ends
 * @returns {{x: Float64Array, observable: Float64Array, coordinate: string,
 *   curves: Landscape[]}|null} null where there is no energy, not one coordinate, or no finite load
 */
export function potential(field, options) {
  const layout = layoutOf(field, options.description);
  if (layout === null) {
    return null;
  }
  const q = constantsOf(field, options.parameters ?? field.parameters);
  const body = { field, q, layout, initial: Float64Array.from(options.initial) };
  const { low, high } = intervalOf(options, layout);
  const x = Float64Array.from({ length: PLACES + 1 }, (_, k) => low + ((high - low) * k) / PLACES);
  const [least, largest] = extremesOfLoad(body);
  if (!Number.isFinite(least.load) || !Number.isFinite(largest.load)) {
    return null;
  }
  // Where the temperature is a state, the stored energy is that inside, whose slope is no force.
  const warms = options.description.state.some((one) => one.role === "temperature");
  const loaded = [least, largest].filter(
    ({ load }, k) => (load !== 0 || warms) && (k === 0 || load !== least.load));
  return {
    x,
    observable: x.map((place) => observedAt(body, least.w, place)[layout.watched]),
    coordinate: layout.name,
    curves: [
      ...(warms ? [] : [unloadedLandscape(body, least.w, x)]),
      ...loaded.map((one) => landscape(body, one, x)),
    ],
  };
}

/** Where in the state and among the observables things are; null where there is no potential. */
function layoutOf(field, description) {
  const energy = field.observable_names.indexOf("energy");
  const coordinates = description.state.filter((one) => one.role === "coordinate");
  const rateCount = description.state.filter((one) => one.role === "rate").length;
  if (energy < 0 || coordinates.length !== 1 || rateCount !== 1) {
    return null;
  }
  const name = coordinates[0].name;
  const place = (one) => description.state.indexOf(one);
  return {
    name,
    energy,
    stored: field.observable_names.indexOf("stored_energy"),
    positive: coordinates[0].positive,
    watched: field.observable_names.indexOf(description.watched),
    load: field.observable_names.indexOf(description.drive.loads[0]),
    coordinate: place(coordinates[0]),
    rates: description.state.filter((one) => one.role === "rate").map(place),
    internal: description.state.filter((one) => one.role === "internal").map(place),
  };
}

function intervalOf(options, layout) {
  const start = options.initial[layout.coordinate];
  const usual = layout.positive ? [0.4, 3] : [Math.min(-2, start - 2), Math.max(2, start + 2)];
  const low = options.low ?? usual[0];
  const high = options.high ?? usual[1];
  return { low: layout.positive ? Math.max(low, 1e-3) : low, high };
}

/** The state at rest at a place, internal variables relaxed. */
function stateAt({ layout, initial }, place) {
  const y = Float64Array.from(initial);
  for (const k of layout.rates) {
    y[k] = 0;
  }
  for (const k of [layout.coordinate, ...layout.internal]) {
    y[k] = place;
  }
  return y;
}

/** All observables of the rest state at a place. */
function observedAt(body, w, place) {
  const out = new Float64Array(body.field.observable_names.length);
  body.field.observed(stateAt(body, place), 0, body.q, w, 0, out, 0);
  return out;
}

/** The force at a place, up to a positive factor: the acceleration from rest. */
function forceAt(body, w, place) {
  const out = new Float64Array(body.initial.length);
  body.field.motion(stateAt(body, place), 0, body.q, w, 0, out, 0);
  return out[body.layout.rates[0]];
}

/** The least and the largest load, each with what time decides where it acts. */
function extremesOfLoad({ field, q, layout, initial }) {
  const body = { field, q, layout, initial };
  const pieces = Math.max(1, field.pieces.length);
  let least = { load: Infinity };
  let largest = { load: -Infinity };
  for (let piece = 0; piece < pieces; piece += 1) {
    const { reach, count } = phasesOf(field, piece);
    for (let k = 0; k <= count; k += 1) {
      const w = new Float64Array(field.driven_count);
      field.driven((reach * k) / count, piece, q, w, 0);
      const load = observedAt(body, w, initial[layout.coordinate])[layout.load];
      least = load < least.load ? { load, w } : least;
      largest = load > largest.load ? { load, w } : largest;
    }
  }
  return [least, largest];
}

/** How far a piece is looked through, in its lengths, and at how many instants. */
function phasesOf({ pieces }, piece) {
  if (pieces.length === 0) {
    return { reach: 1, count: PHASES };
  }
  if (piece === pieces.length - 1) {
    // The last piece has no end.
    return { reach: Math.max(1, LONG_TIME / pieces[piece][1]), count: INSTANTS };
  }
  return { reach: 1, count: Math.max(LEAST_PHASES, Math.ceil(INSTANTS / pieces.length)) };
}

function landscape(body, { load, w }, x) {
  const energyAt = (place) => observedAt(body, w, place)[body.layout.energy];
  return {
    load,
    energy: x.map(energyAt),
    equilibria: equilibriaOf(body, w, x, energyAt, (place) => forceAt(body, w, place)),
  };
}

/** The energy that is stored, whose slope is the force without a load. */
function unloadedLandscape(body, w, x) {
  const energyAt = (place) => observedAt(body, w, place)[body.layout.stored];
  const forceAt = (place) => energyAt(place - SLOPE_STEP) - energyAt(place + SLOPE_STEP);
  return { load: 0, energy: x.map(energyAt), equilibria: equilibriaOf(body, w, x, energyAt, forceAt) };
}

/** Where the force changes its sign; stable where it pushes back. */
function equilibriaOf(body, w, x, energyAt, forceAt) {
  const force = x.map(forceAt);
  const found = [];
  for (let k = 0; k + 1 < x.length; k += 1) {
    if (force[k] > 0 !== force[k + 1] > 0 && Number.isFinite(force[k] + force[k + 1])) {
      const place = zeroOf(forceAt, x[k], x[k + 1]);
      found.push({
        x: place,
        observable: observedAt(body, w, place)[body.layout.watched],
        energy: energyAt(place),
        stable: force[k] > 0,
      });
    }
  }
  return found;
}

/** Where a function that changes its sign is 0, by halving. */
function zeroOf(value, low, high) {
  const pushes = value(low) > 0;
  let [below, above] = [low, high];
  for (let k = 0; k < HALVINGS; k += 1) {
    const middle = 0.5 * (below + above);
    if (value(middle) > 0 === pushes) {
      below = middle;
    } else {
      above = middle;
    }
  }
  return 0.5 * (below + above);
}
