/** Steps of equal length through the pieces of a load, without anything made anew in between. */

import { NODES, STAGES, step } from "./step.js";

/** Beyond this size a state has left whatever a model describes. */
const LARGEST = 1e8;

/** The numbers of a run that its parameters decide.
 *
 * @param {object} field module with the equations
 * @param {object} parameters values by name
 * @returns {Float64Array} what the field keeps of them
 */
export function constantsOf(field, parameters) {
  const q = new Float64Array(field.constant_count);
  field.constants(parameters, q);
  return q;
}

/** What time decides at all places of the steps through one piece.
 *
 * @param {object} field module with the equations
 * @param {Float64Array} q what parameters decide
 * @param {{phase: number, share: number, piece: number}} segment where it begins in its piece, and
 *   what share of the piece it is
 * @param {number} steps how many
 * @returns {Float64Array} a row of driven_count numbers for each place of each step
 */
function drivenTable(field, q, segment, steps) {
  const width = field.driven_count;
  const places = NODES.length;
  const w = new Float64Array(steps * places * width);
  for (let row = 0; row < steps; row += 1) {
    for (let k = 0; k < places; k += 1) {
      const phase = segment.phase + segment.share * ((row + NODES[k]) / steps);
      field.driven(phase, segment.piece, q, w, (row * places + k) * width);
    }
  }
  return w;
}

/** Follows a motion from the start and keeps its states.
 *
 * @param {object} field module with the equations
 * @param {Float64Array} q what parameters decide
 * @param {Float64Array} initial the state at the start
 * @param {object[]} segments pieces of time, each {length, phase, share, piece, steps, repeats}
 * @param {number} divisor 1 for the steps of the segments, 2 for steps twice as long
 * @param {number} stride a state is kept after so many of the steps of the segments
 * @param {Float64Array} kept where states go, one row after the other, that at the start first
 * @returns {number} how many states of the run are sound: finite and within the model's limits
 */
export function follow(field, q, initial, segments, divisor, stride, kept) {
  const n = initial.length;
  const y = Float64Array.from(initial);
  const tried = new Float64Array(n);
  const rates = new Float64Array(STAGES * n);
  const width = field.driven_count;
  const motion = field.motion;
  kept.set(y, 0);
  // Where a stride is odd, longer steps meet only every second kept state.
  const every = stride % divisor === 0 ? 1 : divisor;
  const stepsAState = (stride * every) / divisor;
  let row = 0;
  let counted = 0;
  for (const segment of segments) {
    const steps = segment.steps / divisor;
    const h = segment.length / steps;
    const w = drivenTable(field, q, segment, steps);
    for (let repeat = 0; repeat < segment.repeats; repeat += 1) {
      for (let k = 0; k < steps; k += 1) {
        step(motion, y, n, h, q, w, k * NODES.length * width, width, tried, rates);
        counted += 1;
        if (counted === stepsAState) {
          counted = 0;
          if (!isSound(field, y, q)) {
            return row + 1;
          }
          row += every;
          for (let c = 0; c < n; c += 1) {
            kept[row * n + c] = y[c];
          }
        }
      }
    }
  }
  return row + 1;
}

/** Whether a state is one that the model describes. */
function isSound(field, y, q) {
  for (let c = 0; c < y.length; c += 1) {
    if (!(Math.abs(y[c]) < LARGEST)) {
      return false;
    }
  }
  return field.inside(y, 0, q);
}
