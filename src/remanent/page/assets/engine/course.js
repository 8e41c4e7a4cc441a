/** How a load runs in time: pieces on which it is smooth, and the steps through each. */

/** Steps that are laid out together at most: what time decides is tabulated for so many. */
const LONGEST_TABLE = 1024;

/** The time that is followed, and the unit in which steps are counted.
 *
 * @param {object} field module with the equations
 * @param {object} parameters values by name
 * @param {{periods?: number, duration?: number}} asked how long
 * @returns {{period: number, unit: number, units: number, duration: number}} the unit is the
 *   period of the load, or a share of the duration where it has none
 */
export function courseOf(field, parameters, asked) {
  const period = field.period(parameters);
  if (period > 0 && Number.isFinite(period)) {
    const units = asked.periods ?? asked.duration / period;
    return { period, unit: period, units, duration: units * period };
  }
  const duration = Math.min(asked.duration ?? 100, field.known_until);
  return { period: NaN, unit: duration / UNITS, units: UNITS, duration };
}

/** Units in the duration of a load without a period. */
const UNITS = 64;

/** Pieces of time with the steps through each.
 *
 * @param {object} field module with the equations
 * @param {object} course from {@link courseOf}
 * @param {number} units how many of its units are followed
 * @param {number} steps in one unit; an even number
 * @returns {object[]} each {start, length, phase, share, piece, steps, repeats}
 */
export function segmentsOf(field, course, units, steps) {
  return course.period > 0
    ? periodicSegments(course.period, units, steps)
    : piecewiseSegments(field, course.unit * units, course.unit / steps);
}

function periodicSegments(period, periods, steps) {
  const whole = Math.floor(periods + 1e-9);
  const rest = periods - whole;
  const segments = [];
  if (whole > 0) {
    segments.push({
      start: 0, length: period, phase: 0, share: 1, piece: 0, steps, repeats: whole,
    });
  }
  if (rest > 1e-9) {
    segments.push({
      start: whole * period, length: rest * period, phase: 0, share: rest, piece: 0,
      steps: evenSteps(rest * steps), repeats: 1,
    });
  }
  return segments;
}

function piecewiseSegments(field, duration, longest) {
  const rows = field.pieces.length > 0 ? field.pieces : [[0, 1]];
  const segments = [];
  for (let piece = 0; piece < rows.length && rows[piece][0] < duration; piece += 1) {
    const [start, extent] = rows[piece];
    const end = Math.min(duration, piece + 1 < rows.length ? rows[piece + 1][0] : Infinity);
    const steps = evenSteps((end - start) / longest);
    const tables = Math.ceil(steps / LONGEST_TABLE);
    const each = evenSteps(steps / tables);
    const share = (end - start) / extent / tables;
    for (let k = 0; k < tables; k += 1) {
      segments.push({
        start: start + ((end - start) * k) / tables, length: (end - start) / tables,
        phase: k * share, share, piece, steps: each, repeats: 1,
      });
    }
  }
  return segments;
}

/** The least even number of steps that are not longer than those asked for. */
function evenSteps(wanted) {
  return Math.max(2, 2 * Math.ceil(wanted / 2 - 1e-9));
}

/** The number of steps through all segments. */
export function stepCount(segments) {
  return segments.reduce((sum, one) => sum + one.steps * one.repeats, 0);
}

/** Where in time each kept state lies.
 *
 * @param {object[]} segments from {@link segmentsOf}
 * @param {number} stride steps from one kept state to the next
 * @param {number} rows how many states were kept
 * @returns {{time: Float64Array, phase: Float64Array, piece: Int32Array}} the time, the place
 *   within the piece, and the number of the piece; at a jump, of the piece after it
 */
export function placesOfRows(segments, stride, rows) {
  const time = new Float64Array(rows);
  const phase = new Float64Array(rows);
  const piece = new Int32Array(rows);
  phase[0] = segments[0].phase;
  piece[0] = segments[0].piece;
  let row = 1;
  let counted = 0;
  segments.forEach((segment, number) => {
    const next = segments[number + 1] ?? { ...segment, phase: segment.phase + segment.share };
    for (let repeat = 0; repeat < segment.repeats && row < rows; repeat += 1) {
      const start = segment.start + repeat * segment.length;
      const after = repeat + 1 < segment.repeats ? segment : next;
      for (let step = stride - counted; step <= segment.steps && row < rows; step += stride) {
        const inner = step < segment.steps;
        const share = step / segment.steps;
        time[row] = inner ? start + segment.length * share
          : segment.start + (repeat + 1) * segment.length;
        phase[row] = inner ? segment.phase + segment.share * share : after.phase;
        piece[row] = inner ? segment.piece : after.piece;
        row += 1;
      }
      counted = (counted + segment.steps) % stride;
    }
  });
  return { time, phase, piece };
}
