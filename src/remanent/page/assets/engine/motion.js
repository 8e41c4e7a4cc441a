/**
 * The motion of a system in the page: two runs of a Runge-Kutta method, one with steps twice as
 * long, and the error that their difference shows.
 */

import { courseOf, placesOfRows } from "./course.js";
import { UNDETERMINED, statedError } from "./errors.js";
import { bestRun } from "./resolution.js";
import { hasLeft } from "./runs.js";
import { constantsOf } from "./stepper.js";

/**
 * A motion, and how well it is known.
 *
 * @typedef {object} Motion
 * @property {Float64Array} t times
 * @property {Float64Array[]} y each state variable at these times
 * @property {Float64Array[]} observables each observable at these times
 * @property {Float64Array} error stated error of each state: of the variable that has the largest
 *   over its scale, as a share of that
 * @property {Float64Array} scales size of each state variable, of which `error` is a share
 * @property {{t: Float64Array, y: Float64Array[], observables: Float64Array[],
 *   error: Float64Array}} section the same, once in every period; empty where there is none
 * @property {number} period of the load; NaN where there is none
 * @property {number} stepsPerPeriod of the finer run, or in a 64th of the time
 * @property {number} statesPerPeriod rows from one state of the section to the next
 * @property {number} determinedUntil the time up to which the stated error is small
 * @property {"ok"|"left"|"undetermined"} status
 * @property {""|"left"|"needs shorter steps"|"differences have grown"|"shortened"} cause why it is
 *   not known to its end; empty where it is
 * @property {number} milliseconds that it took
 */

/** Follows the motion of a system.
 *
 * @param {object} field module with the equations
 * @param {object} options
 * @param {object} [options.parameters] values by name; those of the module by default
 * @param {number[]} options.initial the state at time 0
 * @param {number} [options.periods] periods of the load to follow
 * @param {number} [options.duration] time to follow, in place of periods or where there are none
 * @param {number} [options.target] stated error that is aimed at, as a share
 * @param {boolean} [options.refine] whether to spend more steps, for a smaller error
 * @param {number} [options.sectionPhase] phase of the section, in [0, 1)
 * @returns {Motion}
 */
export function integrate(field, options) {
  const started = performance.now();
  const parameters = options.parameters ?? field.parameters;
  const initial = Float64Array.from(options.initial);
  const target = options.target ?? (options.refine ? 1e-9 : 1e-5);
  const q = constantsOf(field, parameters);
  const course = courseOf(field, parameters, options);
  const run = bestRun({ field, q, initial, course, target, refine: Boolean(options.refine) });
  const motion = motionOf(field, q, course, run, options.sectionPhase ?? 0);
  motion.milliseconds = performance.now() - started;
  return motion;
}

/** A run as curves. */
function motionOf(field, q, course, run, sectionPhase) {
  const { rows, n, fine, stride, steps } = run;
  const { time, phase, piece } = placesOfRows(run.segments, stride, rows);
  const error = new Float64Array(rows);
  for (let row = 0; row < rows; row += 1) {
    error[row] = row === 0 ? 0 : statedError(run.differences[row], run.share, row * stride);
  }
  const motion = {
    t: time,
    y: columnsOf(fine, n, rows),
    observables: observablesOf(field, q, fine, n, rows, phase, piece),
    error,
    scales: run.scales,
    period: course.period,
    stepsPerPeriod: steps,
    statesPerPeriod: steps / stride,
  };
  motion.section = sectionOf(motion, course.period > 0 ? sectionPhase : NaN);
  return { ...motion, ...statusOf(course, run, time, error) };
}

/** Columns of a table that is kept row after row. */
function columnsOf(table, width, rows) {
  return Array.from({ length: width }, (_, c) => {
    const column = new Float64Array(rows);
    for (let row = 0; row < rows; row += 1) {
      column[row] = table[row * width + c];
    }
    return column;
  });
}

/** Every observable of every kept state. */
function observablesOf(field, q, states, n, rows, phase, piece) {
  const width = field.observable_names.length;
  const w = new Float64Array(field.driven_count);
  const table = new Float64Array(rows * width);
  for (let row = 0; row < rows; row += 1) {
    field.driven(phase[row], piece[row], q, w, 0);
    field.observed(states, row * n, q, w, 0, table, row * width);
  }
  return columnsOf(table, width, rows);
}

/** The states once in every period. */
function sectionOf(motion, sectionPhase) {
  const step = motion.statesPerPeriod;
  const first = Math.round(sectionPhase * step) % step;
  const chosen = (column) => {
    const count = first >= 0 ? Math.floor((column.length - 1 - first) / step) + 1 : 0;
    return Float64Array.from({ length: Math.max(0, count) }, (_, k) => column[first + k * step]);
  };
  return {
    t: chosen(motion.t),
    y: motion.y.map(chosen),
    observables: motion.observables.map(chosen),
    error: chosen(motion.error),
  };
}

/** How far the motion is known, and what is to be said of it. */
function statusOf(course, run, time, error) {
  const lost = error.findIndex((one) => !(one <= UNDETERMINED));
  const end = time[time.length - 1];
  const determinedUntil = lost < 0 ? end : time[Math.max(0, lost - 1)];
  const told = (status, cause) => ({ status, cause, determinedUntil });
  if (hasLeft(run)) {
    return told("left", "left");
  }
  if (run.rows < run.asked) {
    return told("undetermined", "needs shorter steps");
  }
  if (lost >= 0) {
    return told("undetermined", "differences have grown");
  }
  return told("ok", run.units < course.units - 1e-9 ? "shortened" : "");
}
