/**
 * One step of an explicit Runge-Kutta method of order 8 with eleven stages.
 *
 * Source: G. J. Cooper and J. H. Verner, Some explicit Runge-Kutta methods of high order,
 * SIAM Journal on Numerical Analysis 9 (1972) 389-405.  Its coefficients are closed expressions in
 * the square root of 21, and the load is needed at five places of a step only.  The stages stand
 * here one by one, as loops over a table take twice the time.
 */

const s = Math.sqrt(21);

/** Order of the global error. */
export const ORDER = 8;
/** Stages of a step, each with rates of its own. */
export const STAGES = 11;
/** Places within a step, as shares of it, at which the load is needed. */
export const NODES = [0, (7 - s) / 14, 1 / 2, (7 + s) / 14, 1];

// The weight of the rates of stage j in the state of stage i is A_i_j; in the result it is B_j.
const A_1_0 = 1 / 2;
const A_2 = 1 / 4;
const A_3_0 = 1 / 7;
const A_3_1 = (-7 - 3 * s) / 98;
const A_3_2 = (21 + 5 * s) / 49;
const A_4_0 = (11 + s) / 84;
const A_4_2 = (18 + 4 * s) / 63;
const A_4_3 = (21 - s) / 252;
const A_5_0 = (5 + s) / 48;
const A_5_2 = (9 + s) / 36;
const A_5_3 = (14 * s - 231) / 360;
const A_5_4 = (63 - 7 * s) / 80;
const A_6_0 = (10 - s) / 42;
const A_6_2 = (92 * s - 432) / 315;
const A_6_3 = (633 - 145 * s) / 90;
const A_6_4 = (115 * s - 504) / 70;
const A_6_5 = (63 - 13 * s) / 35;
const A_7_0 = 1 / 14;
const A_7_4 = (14 - 3 * s) / 126;
const A_7_5 = (13 - 3 * s) / 63;
const A_7_6 = 1 / 9;
const A_8_0 = 1 / 32;
const A_8_4 = (91 - 21 * s) / 576;
const A_8_5 = 11 / 72;
const A_8_6 = -(385 + 75 * s) / 1152;
const A_8_7 = (63 + 13 * s) / 128;
const A_9_0 = 1 / 14;
const A_9_4 = 1 / 9;
const A_9_5 = -(733 + 147 * s) / 2205;
const A_9_6 = (515 + 111 * s) / 504;
const A_9_7 = -(51 + 11 * s) / 56;
const A_9_8 = (132 + 28 * s) / 245;
const A_10_4 = (7 * s - 42) / 18;
const A_10_5 = (28 * s - 18) / 45;
const A_10_6 = -(273 + 53 * s) / 72;
const A_10_7 = (301 + 53 * s) / 72;
const A_10_8 = (28 - 28 * s) / 45;
const A_10_9 = (49 - 7 * s) / 18;
const B_0 = 1 / 20;
const B_7 = 49 / 180;
const B_8 = 16 / 45;

/** Moves a state on by one step.
 *
 * @param {function} motion writes the rates of a state: motion(y, i, q, w, k, out, j)
 * @param {Float64Array} y the state, which is changed
 * @param {number} n its variables
 * @param {number} h length of the step
 * @param {Float64Array} q what parameters decide
 * @param {Float64Array} w what time decides, a row for each of the places
 * @param {number} place where the first of these rows begins
 * @param {number} width of a row
 * @param {Float64Array} z room for a state
 * @param {Float64Array} r room for the rates of all stages
 */
export function step(motion, y, n, h, q, w, place, width, z, r) {
  const early = place + width;
  const middle = early + width;
  const late = middle + width;
  const end = late + width;
  const k2 = 2 * n;
  const k3 = 3 * n;
  const k4 = 4 * n;
  const k5 = 5 * n;
  const k6 = 6 * n;
  const k7 = 7 * n;
  const k8 = 8 * n;
  const k9 = 9 * n;
  const k10 = 10 * n;
  let c = 0;
  motion(y, 0, q, w, place, r, 0);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * A_1_0 * r[c];
  }
  motion(z, 0, q, w, middle, r, n);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * A_2 * (r[c] + r[n + c]);
  }
  motion(z, 0, q, w, middle, r, k2);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * (A_3_0 * r[c] + A_3_1 * r[n + c] + A_3_2 * r[k2 + c]);
  }
  motion(z, 0, q, w, late, r, k3);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * (A_4_0 * r[c] + A_4_2 * r[k2 + c] + A_4_3 * r[k3 + c]);
  }
  motion(z, 0, q, w, late, r, k4);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c]
      + h * (A_5_0 * r[c] + A_5_2 * r[k2 + c] + A_5_3 * r[k3 + c] + A_5_4 * r[k4 + c]);
  }
  motion(z, 0, q, w, middle, r, k5);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * (A_6_0 * r[c] + A_6_2 * r[k2 + c] + A_6_3 * r[k3 + c] + A_6_4 * r[k4 + c]
      + A_6_5 * r[k5 + c]);
  }
  motion(z, 0, q, w, early, r, k6);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c]
      + h * (A_7_0 * r[c] + A_7_4 * r[k4 + c] + A_7_5 * r[k5 + c] + A_7_6 * r[k6 + c]);
  }
  motion(z, 0, q, w, early, r, k7);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * (A_8_0 * r[c] + A_8_4 * r[k4 + c] + A_8_5 * r[k5 + c] + A_8_6 * r[k6 + c]
      + A_8_7 * r[k7 + c]);
  }
  motion(z, 0, q, w, middle, r, k8);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * (A_9_0 * r[c] + A_9_4 * r[k4 + c] + A_9_5 * r[k5 + c] + A_9_6 * r[k6 + c]
      + A_9_7 * r[k7 + c] + A_9_8 * r[k8 + c]);
  }
  motion(z, 0, q, w, late, r, k9);
  for (c = 0; c < n; c += 1) {
    z[c] = y[c] + h * (A_10_4 * r[k4 + c] + A_10_5 * r[k5 + c] + A_10_6 * r[k6 + c]
      + A_10_7 * r[k7 + c] + A_10_8 * r[k8 + c] + A_10_9 * r[k9 + c]);
  }
  motion(z, 0, q, w, end, r, k10);
  for (c = 0; c < n; c += 1) {
    y[c] += h * (B_0 * (r[c] + r[k10 + c]) + B_7 * (r[k7 + c] + r[k9 + c]) + B_8 * r[k8 + c]);
  }
}
