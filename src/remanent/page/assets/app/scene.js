// What the views draw of a state of the page: its motion, and what names and colours it has.

import { integrate } from "../engine/motion.js";
import { determinedCount } from "./curves.js";
import { extent } from "./numbers.js";
import { colours, temperatureColour } from "./theme.js";

/** Share of a variable from which an error can be seen beside the curve. */
export const VISIBLE_ERROR = 1e-3;

/**
 * Compute the motion of a state of the page.
 * @param {Object} state of the store
 * @param {{refine?: boolean}} [options] refine: spend more steps, for a smaller error
 * @returns {Object} the scene: the motion, and what views need to draw it
 */
export function sceneOf(state, { refine = false } = {}) {
  const { description, field, values, initial, si } = state;
  const run = description.drive.periodic ? { periods: state.periods } : { duration: state.duration };
  const motion = integrate(field, { parameters: values, initial, refine, ...run });
  return { ...labelsOf(state), motion, field, values, description, factors: si ? description.si : null, ...measures(motion, description, field, values) };
}

/**
 * Whether more steps may show more of a motion: it ends early, or its error can be seen.
 * @param {Object} motion
 * @returns {boolean}
 */
export function isWorthRefining({ cause, error }) {
  return !["", "left"].includes(cause) || (cause === "" && error[error.length - 1] > VISIBLE_ERROR);
}

/**
 * Whether one motion is known further than another, or better.
 * @param {Object} one
 * @param {Object} other
 * @returns {boolean}
 */
export function isKnownBetter(one, other) {
  return one.determinedUntil > other.determinedUntil
    || (one.determinedUntil === other.determinedUntil && one.error[one.error.length - 1] < other.error[other.error.length - 1]);
}

/**
 * The same scene with the colours and units in force.
 * @param {Object} scene
 * @param {Object} state of the store
 * @returns {Object}
 */
export function relabelled(scene, state) {
  return { ...scene, ...labelsOf(state), factors: state.si ? state.description.si : null };
}

function labelsOf({ description, values, initial }) {
  const names = description.observables.map((one) => one.name);
  const watched = Math.max(0, names.indexOf(description.watched));
  const rate = names.indexOf(`${description.watched}_rate`);
  const kelvin = values.temperature;
  return {
    isActuator: description.kind === "Actuator",
    watched,
    axes: [watched, rate >= 0 ? rate : (watched + 1) % names.length],
    energy: names.indexOf("energy"),
    colour: kelvin === undefined ? colours().blue : temperatureColour(kelvin),
    here: kelvin === undefined ? colours().vermillion : colours().here,
    initial,
  };
}

function measures(motion, description, field, values) {
  const load = description.observables.findIndex((one) => one.name === "load");
  const [low, high] = load >= 0 && motion.t.length ? extent(motion.observables[load]) : [0, 0];
  const last = motion.t[Math.max(0, determinedCount(motion) - 1)] ?? 0;
  return {
    period: field.period(values),
    largestHalf: largestHalf(motion, description, values),
    largestLoad: Math.max(Math.abs(low), Math.abs(high)) || 0,
    played: [0, last],
  };
}

/** The largest half edge of the block along the motion; 0 where there is no block. */
function largestHalf(motion, description, values) {
  if (description.kind !== "Actuator" || !motion.t.length) {
    return 0;
  }
  const watched = description.observables.findIndex((one) => one.name === description.watched);
  const edges = description.state.filter((one) => one.role === "coordinate")
    .map((one) => extent(motion.y[description.state.indexOf(one)])[1]);
  return Math.max(...edges, Math.sqrt(values.c) * extent(motion.observables[watched])[1]);
}
