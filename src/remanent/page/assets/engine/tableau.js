/**
 * The coefficients of an explicit Runge-Kutta method of order 8 with eleven stages.
 *
 * Source: G. J. Cooper and J. H. Verner, Some explicit Runge-Kutta methods of high order,
 * SIAM Journal on Numerical Analysis 9 (1972) 389-405.  They are closed expressions in the
 * square root of 21, and the load is needed at five places of a step only.
 */

const s = Math.sqrt(21);

/** Order of the global error. */
export const ORDER = 8;

/** Places within a step, as shares of it, at which the load is needed. */
export const NODES = [0, (7 - s) / 14, 1 / 2, (7 + s) / 14, 1];

/** For each stage the number of its place in NODES. */
export const STAGE_NODES = [0, 2, 2, 3, 3, 2, 1, 1, 2, 3, 4];

/** For each stage pairs of an earlier stage and its weight. */
export const STAGE_WEIGHTS = [
  [],
  [[0, 1 / 2]],
  [[0, 1 / 4], [1, 1 / 4]],
  [[0, 1 / 7], [1, (-7 - 3 * s) / 98], [2, (21 + 5 * s) / 49]],
  [[0, (11 + s) / 84], [2, (18 + 4 * s) / 63], [3, (21 - s) / 252]],
  [[0, (5 + s) / 48], [2, (9 + s) / 36], [3, (14 * s - 231) / 360], [4, (63 - 7 * s) / 80]],
  [
    [0, (10 - s) / 42], [2, (92 * s - 432) / 315], [3, (633 - 145 * s) / 90],
    [4, (115 * s - 504) / 70], [5, (63 - 13 * s) / 35],
  ],
  [[0, 1 / 14], [4, (14 - 3 * s) / 126], [5, (13 - 3 * s) / 63], [6, 1 / 9]],
  [
    [0, 1 / 32], [4, (91 - 21 * s) / 576], [5, 11 / 72], [6, -(385 + 75 * s) / 1152],
    [7, (63 + 13 * s) / 128],
  ],
  [
    [0, 1 / 14], [4, 1 / 9], [5, -(733 + 147 * s) / 2205], [6, (515 + 111 * s) / 504],
    [7, -(51 + 11 * s) / 56], [8, (132 + 28 * s) / 245],
  ],
  [
    [4, (7 * s - 42) / 18], [5, (28 * s - 18) / 45], [6, -(273 + 53 * s) / 72],
    [7, (301 + 53 * s) / 72], [8, (28 - 28 * s) / 45], [9, (49 - 7 * s) / 18],
  ],
];

/** Pairs of a stage and its weight in the result. */
export const FINAL_WEIGHTS = [[0, 1 / 20], [7, 49 / 180], [8, 16 / 45], [9, 49 / 180], [10, 1 / 20]];
