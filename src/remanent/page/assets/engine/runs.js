/** One motion at two resolutions, and how far they differ. */

import { segmentsOf, stepCount } from "./course.js";
import { largestDifferences, scalesOf } from "./errors.js";
import { follow } from "./stepper.js";

/** States that curves are drawn with: at most in all; at least and at most in a unit of time. */
const MOST_STATES = 20000;
const MOST_A_UNIT = 96;
export const LEAST_A_UNIT = 16;
/** States in a unit that curves have even where fewer steps would do, as long as all are few. */
const USUAL_A_UNIT = 24;
/** Times at which two runs leave may differ by this share. */
const LEAVING = 0.02;
/** What differs later than at this share of such a run says nothing of the steps. */
const BEFORE_LEAVING = 0.9;

/** A run and one with steps twice as long, with their difference.
 *
 * @param {{field: object, q: Float64Array, initial: Float64Array, course: object}} problem
 * @param {number} units of time that are followed
 * @param {number} wantedSteps in a unit, at least
 * @returns {object} states of both, row after row, and the largest differences up to each row
 */
export function runBoth({ field, q, initial, course }, units, wantedSteps) {
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
  const run = {
    segments, units, steps, stride, every, asked, rows, coarseRows, fine, n, scales, differences,
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
    return { steps: 2 * Math.ceil(Math.max(wanted, Math.min(most, USUAL_A_UNIT)) / 2), stride: 1 };
  }
  const stride = 2 * Math.ceil(wanted / most / 2);
  return { steps: stride * 2 * Math.ceil(wanted / stride / 2), stride };
}

/** Whether both runs end early, and nearly at the same time: the motion itself leaves.
 *
 * @param {object} run from {@link runBoth}
 * @returns {boolean}
 */
export function hasLeft({ rows, coarseRows, asked, every }) {
  const apart = Math.abs(rows - coarseRows);
  const bothEnd = rows < asked && coarseRows < asked;
  return bothEnd && rows * LEAVING >= every && apart <= LEAVING * rows;
}
