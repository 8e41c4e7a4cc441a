/** How many steps a motion needs: by a few units of time, and by what the whole of it shows. */

import { differenceFor, shareLeft } from "./errors.js";
import { LEAST_A_UNIT, hasLeft, runBoth } from "./runs.js";
import { ORDER } from "./step.js";

/** Steps of a first try in a unit of time, and of the last. */
const FIRST_STEPS = 16;
const LAST_STEPS = 2 ** 15;
/** Units of time by which the resolution is chosen. */
const PILOT_UNITS = 8;
/** Errors of an undamped motion that is not chaotic grow with the time to this power. */
const GROWTH = 2;
/** A run is not repeated for errors up to so many times the target, unless it is refined. */
const TOLERATED = 10;
/** A difference of two short runs above this share says nothing of the order. */
const ROUGH = 1e-2;
/** The share of a difference that half the step may leave, and longer steps where it does not. */
const WANTED_SHARE = 1 / 8;
const SHORTER = 1.3;
const TRIES = 4;
/** A difference below this share of the target is rounding, and says nothing of the order. */
const FAR_BELOW = 1e-3;
/** Most steps of one run of a system with two state variables: usually, and to refine it. */
const MOST_STEPS = 120000;
const MOST_REFINED_STEPS = 480000;
/** Runs that are repeated with shorter steps at most. */
const ATTEMPTS = 3;

/** The run whose stated error meets the target, or the last that was affordable.
 *
 * @param {{field: object, q: Float64Array, initial: Float64Array, course: object, target: number,
 *   refine: boolean}} problem
 * @returns {object} a run from {@link runBoth}, with the `share` of its differences that is stated
 */
export function bestRun(problem) {
  const { course, target } = problem;
  const allowed = problem.refine ? MOST_REFINED_STEPS : MOST_STEPS;
  const most = Math.floor((2 * allowed) / Math.max(2, problem.initial.length));
  let { steps, share } = resolutionByPilot(problem, most);
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
  const early = Math.ceil((run.rows * PILOT_UNITS) / run.units);
  const isClose = run.differences[Math.min(run.rows - 1, early)] < ROUGH;
  const goesApart = !(run.difference < ROUGH) && isClose;
  return problem.refine || !(hasLeft(run) || goesApart);
}

/** Steps in a unit by a few units of time, and what half the step then leaves of a difference. */
function resolutionByPilot(problem, most) {
  const { course, target } = problem;
  const units = Math.min(course.units, PILOT_UNITS);
  const growth = Math.max(1, course.units / units) ** GROWTH;
  const last = Math.min(LAST_STEPS, most / units);
  let steps = FIRST_STEPS;
  let run = runBoth(problem, units, steps);
  while (!(run.difference < ROUGH) && steps < last) {
    steps *= 2;
    run = runBoth(problem, units, steps);
  }
  // How long steps may be for both runs to end together is known for these only.
  steps = finerSteps(steps, run.difference, differenceFor(target) / growth, !hasLeft(run));
  let share = 1;
  for (let k = 0; k < TRIES && steps < last; k += 1) {
    const { difference } = runBoth(problem, units, steps);
    share = shareLeft(difference, runBoth(problem, units, 2 * steps).difference);
    if (share <= WANTED_SHARE || difference < FAR_BELOW * target) {
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
