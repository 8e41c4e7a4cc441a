/** What the difference of two resolutions says of the error of the finer one. */

/** Where two runs differ by this share of a variable, or more, they have gone different ways. */
const APART = 0.05;
/**
 * While they have not, halving the step at order 8 divides the error by 255.  Steps are long,
 * and an eighth of that is counted on, or less where a few units of time show less.
 */
const LEAST_SHARE = 1 / 32;
const RESERVE = 8;
/** Rounding of a state, in units of its last digit, and its growth along a run. */
const ROUNDING = 64 * Number.EPSILON;
/** Smallest scale of a variable, over the largest of all. */
const LEAST_SCALE = 1e-3;
/** A stated error beyond this share of a variable: the motion is not determined any more. */
export const UNDETERMINED = 0.02;

/** The size of each variable along a run.
 *
 * @param {Float64Array} kept states, one row after the other
 * @param {number} n variables
 * @param {number} rows how many states
 * @returns {Float64Array} the largest size of each, or a small share of the largest of all
 */
export function scalesOf(kept, n, rows) {
  const scales = new Float64Array(n);
  for (let k = 0; k < rows * n; k += 1) {
    const size = Math.abs(kept[k]);
    if (size > scales[k % n]) {
      scales[k % n] = size;
    }
  }
  const least = LEAST_SCALE * Math.max(...scales) || 1;
  return scales.map((scale) => Math.max(scale, least));
}

/** The largest difference of two runs up to each state, over the scales of the variables.
 *
 * @param {Float64Array} fine states of the finer run
 * @param {Float64Array} coarse of the coarser run, at every so many of the rows
 * @param {number} n variables
 * @param {number} rows states of the finer run
 * @param {number} coarseRows rows up to which the coarser run is sound
 * @param {number} every rows from one state of the coarser run to the next
 * @param {Float64Array} scales of the variables
 * @returns {Float64Array} for each row; infinite where the coarser run has ended
 */
export function largestDifferences(fine, coarse, n, rows, coarseRows, every, scales) {
  const found = new Float64Array(rows);
  let largest = 0;
  for (let row = every; row < rows + every - 1; row += every) {
    if (row < coarseRows && row < rows) {
      for (let c = 0; c < n; c += 1) {
        const k = row * n + c;
        const difference = Math.abs(fine[k] - coarse[k]) / scales[c];
        if (difference > largest) {
          largest = difference;
        }
      }
    } else if (row >= coarseRows) {
      largest = Infinity;
    }
    for (let k = row - every + 1; k <= row && k < rows; k += 1) {
      found[k] = largest;
    }
  }
  return found;
}

/** The share of a difference that is left of it with steps half as long, with a reserve.
 *
 * @param {number} difference of two runs
 * @param {number} next of the finer of them and one that is finer still
 * @returns {number} from a small share to 1
 */
export function shareLeft(difference, next) {
  const share = RESERVE * (next / difference);
  return share >= LEAST_SHARE ? Math.min(1, share) : LEAST_SHARE;
}

/** The stated error for a largest difference.
 *
 * A share of it that is small while both runs go the same way, and all of it once they do not:
 * from then on the finer run is no better than the coarser.
 *
 * @param {number} difference over the scale
 * @param {number} share from {@link shareLeft}
 * @param {number} steps made so far
 * @returns {number} over the scale
 */
export function statedError(difference, share, steps) {
  const counted = Math.min(1, Math.max(share, difference / APART));
  return difference * counted + ROUNDING * Math.sqrt(1 + steps);
}

/** The largest difference for which {@link statedError} meets a target. */
export function differenceFor(target, share = LEAST_SHARE) {
  return Math.min(target / share, Math.sqrt(target * APART));
}
