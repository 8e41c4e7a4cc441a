/**
 * The motion of a system in the page: two runs of a Runge-Kutta method, one with steps twice as
 * long, and the error that their difference shows.
 */

import { courseOf, placesOfRows, segmentsOf, stepCount } from "./course.js";
import {
  UNDETERMINED, differenceFor, largestDifferences, scalesOf, shareLeft, statedError,
} from "./errors.js";
import { ORDER } from "./step.js";
import { constantsOf, follow } from "./stepper.js";

/** States that curves are drawn with: at most in all; at least and at most in a period. */
const MOST_STATES = 20000;
const LEAST_A_UNIT = 16;
const MOST_A_UNIT = 96;
/** Steps of a first try in a unit of time, and of the last. */
const FIRST_STEPS = 16;
const LAST_STEPS = 2 ** 15;
/** Units of time by which the resolution is chosen. */
const PILOT_UNITS = 8;
/** Errors of a motion that is not chaotic grow with the time to this power. */
const GROWTH = 1.5;
/** A run is not repeated for errors up to so many times the target, unless it is refined. */
const TOLERATED = 10;
/** A difference of two short runs above this share says nothing of the order. */
const ROUGH = 1e-2;
/** The share of a difference that half the step may leave, and longer steps where it does not. */
const WANTED_SHARE = 1 / 8;
const SHORTER = 1.3;
const TRIES = 4;
/** Times at which two runs leave may differ by this share. */
const LEAVING = 0.02;
/** What differs later than at this share of such a run says nothing of the steps. */
const BEFORE_LEAVING = 0.9;
/** Most steps of one run of a system with two state variables: usually, and to refine it. */
const MOST_STEPS = 120000;
const MOST_REFINED_STEPS = 480000;
/** Runs that are repeated with shorter steps at most. */
const ATTEMPTS = 3;

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
 * @property {string} message what the status means here; empty where all is well
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

/** The run whose stated error meets the target, or the last that was affordable. */
function bestRun(problem) {
  const { course, target } = problem;
  const allowed = problem.refine ? MOST_REFINED_STEPS : MOST_STEPS;
  const most = Math.floor((2 * allowed) / Math.max(2, problem.initial.length));
  let { steps, share } = resolutionByPilot(problem);
  let best;
  for (let attempt = 0; attempt < ATTEMPTS; attempt += 1) {
    const units = Math.min(course.units, Math.max(1, Math.floor(most / steps)));
    const run = { ...runBoth(problem, units, steps), share };
    const better = !best || run.units >= best.units;
    best = better ? run : best;
    const worth = isWorthRepeating(problem, run);
    if (!better || !worth) {
      break;
    }
    const more = finerSteps(steps, run.difference, differenceFor(target, share));
    if (more * course.units > most) {
      break;
    }
    steps = more;
  }
  return best;
}

/** Whether shorter steps would make a run better. */
function isWorthRepeating(problem, run) {
  const target = problem.refine ? problem.target : TOLERATED * problem.target;
  if (run.difference <= differenceFor(target, run.share)) {
    return false;
  }
  const goesApart = !(run.difference < ROUGH) && run.early < ROUGH;
  return problem.refine || !(hasLeft(run) || goesApart);
}

/** Whether both runs end early, and nearly at the same time: the motion itself leaves. */
function hasLeft({ rows, coarseRows, asked, every }) {
  const apart = Math.abs(rows - coarseRows);
  const bothEnd = rows < asked && coarseRows < asked;
  return bothEnd && rows * LEAVING >= every && apart <= LEAVING * rows;
}

/** Steps in a unit by a few units of time, and what half the step then leaves of a difference. */
function resolutionByPilot(problem) {
  const { course, target } = problem;
  const units = Math.min(course.units, PILOT_UNITS);
  const growth = Math.max(1, course.units / units) ** GROWTH;
  let steps = FIRST_STEPS;
  let run = runBoth(problem, units, steps);
  while (!(run.difference < ROUGH) && steps < LAST_STEPS) {
    steps *= 2;
    run = runBoth(problem, units, steps);
  }
  // How long steps may be for both runs to end together is known for these only.
  steps = finerSteps(steps, run.difference, differenceFor(target) / growth, !hasLeft(run));
  let share = 1;
  for (let k = 0; k < TRIES && steps < LAST_STEPS; k += 1) {
    const { difference } = runBoth(problem, units, steps);
    share = shareLeft(difference, runBoth(problem, units, 2 * steps).difference);
    if (share <= WANTED_SHARE || difference < target * 1e-3) {
      break;
    }
    steps = 2 * Math.ceil((SHORTER * steps) / 2);
  }
  return { steps: Math.min(steps, LAST_STEPS), share };
}

/** Even number of steps by which a difference becomes what is wanted. */
function finerSteps(steps, difference, wanted, mayBeFewer = false) {
  if (!(difference < Infinity)) {
    return 2 * steps;
  }
  const ratio = (difference / wanted) ** (1 / ORDER);
  const factor = Math.min(4, Math.max(mayBeFewer ? 0 : 1.2, 1.1 * ratio));
  return 2 * Math.ceil(Math.max(LEAST_A_UNIT, steps * factor) / 2);
}

/** A run and one with steps twice as long, with their difference. */
function runBoth({ field, q, initial, course }, units, wantedSteps) {
  const { steps, stride } = stepsAndStride(wantedSteps, units);
  const segments = segmentsOf(field, course, units, steps);
  const n = initial.length;
  const asked = Math.floor(stepCount(segments) / stride) + 1;
  const fine = new Float64Array(asked * n);
  const coarse = new Float64Array(asked * n);
  const rows = follow(field, q, initial, segments, 1, stride, fine);
  const coarseRows = follow(field, q, initial, segments, 2, stride, coarse);
  const scales = scalesOf(fine, n, rows);
  const every = stride % 2 === 0 ? 1 : 2;
  const differences = largestDifferences(fine, coarse, n, rows, coarseRows, every, scales);
  const early = differences[Math.min(rows - 1, Math.ceil((rows * PILOT_UNITS) / units))];
  const run = {
    segments, units, steps, stride, every, asked, rows, coarseRows, fine, n, scales, differences,
    early,
  };
  return { ...run, difference: lastDifference(run) };
}

/** The difference at the end; of a motion that leaves, shortly before that. */
function lastDifference(run) {
  const { rows, coarseRows, asked, differences } = run;
  if (hasLeft(run)) {
    return differences[Math.floor(BEFORE_LEAVING * (Math.min(rows, coarseRows) - 1))];
  }
  return rows < asked ? Infinity : differences[rows - 1];
}

/** Steps in a unit, and from one kept state to the next, for curves of moderate length. */
function stepsAndStride(wanted, units) {
  const most = Math.min(MOST_A_UNIT, Math.max(LEAST_A_UNIT, Math.floor(MOST_STATES / units)));
  if (wanted <= most) {
    return { steps: 2 * Math.ceil(Math.max(wanted, Math.min(most, 24)) / 2), stride: 1 };
  }
  const stride = 2 * Math.ceil(wanted / most / 2);
  return { steps: stride * 2 * Math.ceil(wanted / stride / 2), stride };
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
  const at = (t) => Number(t.toPrecision(4));
  if (hasLeft(run)) {
    return {
      status: "left", determinedUntil,
      message: `The motion leaves the limits of the model near τ = ${at(end)}.`,
    };
  }
  if (run.rows < run.asked) {
    return {
      status: "undetermined", determinedUntil,
      message: `The motion is not followed beyond τ = ${at(end)}: it needs shorter steps.`,
    };
  }
  if (lost >= 0) {
    return {
      status: "undetermined", determinedUntil,
      message: `After τ = ${at(determinedUntil)} the smallest differences have grown so much that `
        + "the curve is one of many possible ones.",
    };
  }
  if (run.units < course.units - 1e-9) {
    return {
      status: "ok", determinedUntil,
      message: `The motion needs ${run.steps} steps in a period; it is shown up to `
        + `τ = ${at(end)}.`,
    };
  }
  return { status: "ok", determinedUntil, message: "" };
}
