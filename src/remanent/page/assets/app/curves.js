// What the views draw of a motion: finer curves, what is determined of them, and errors.

/**
 * Index of the first sample from which on a motion is not determined; its length where all is.
 * @param {Object} motion
 * @returns {number}
 */
export function determinedCount(motion) {
  const end = motion.determinedUntil;
  return end === undefined || end === null || end >= motion.t[motion.t.length - 1]
    ? motion.t.length
    : firstAfter(motion.t, end);
}

/**
 * Index of the first sample after a time.
 * @param {ArrayLike<number>} t increasing
 * @param {number} time
 * @returns {number}
 */
export function firstAfter(t, time) {
  let low = 0;
  let high = t.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (t[middle] <= time) {
      low = middle + 1;
    } else {
      high = middle;
    }
  }
  return low;
}

/**
 * Observables between two samples, with more points: cubic pieces through the states, whose
 * slopes at the samples are the rates.
 * @param {Object} field the module with the equations
 * @param {Object} motion
 * @param {Object<string, number>} parameters
 * @param {{from: number, to: number, parts: number}} span indices of samples, and the pieces that
 *   each step is cut into
 * @returns {{t: Float64Array, observables: Float64Array[]}}
 */
export function refined(field, motion, parameters, { from, to, parts }) {
  const names = field.observable_names.length;
  const count = Math.max(0, (to - from) * parts + 1);
  const result = { t: new Float64Array(count), observables: Array.from({ length: names }, () => new Float64Array(count)) };
  if (count === 0) {
    return result;
  }
  const size = motion.y.length;
  const [a, b, here, out] = [size, size, size, names].map((n) => new Float64Array(n));
  let [slopeA, slopeB] = [new Float64Array(size), new Float64Array(size)];
  const put = (k, t, state) => {
    field.observables(t, state, parameters, out);
    result.t[k] = t;
    out.forEach((value, j) => {
      result.observables[j][k] = value;
    });
  };
  const read = (i, state, slope) => {
    motion.y.forEach((column, j) => {
      state[j] = column[i];
    });
    field.rates(motion.t[i], state, parameters, slope);
  };
  read(from, b, slopeB);
  put(0, motion.t[from], b);
  for (let i = from, k = 1; i < to; i += 1) {
    a.set(b);
    [slopeA, slopeB] = [slopeB, slopeA];
    read(i + 1, b, slopeB);
    const h = motion.t[i + 1] - motion.t[i];
    for (let part = 1; part <= parts; part += 1, k += 1) {
      const s = part / parts;
      const [h00, h10] = [(1 + 2 * s) * (1 - s) ** 2, s * (1 - s) ** 2];
      const [h01, h11] = [s * s * (3 - 2 * s), s * s * (s - 1)];
      for (let j = 0; j < size; j += 1) {
        here[j] = h00 * a[j] + h01 * b[j] + h * (h10 * slopeA[j] + h11 * slopeB[j]);
      }
      put(k, motion.t[i] + s * h, here);
    }
  }
  return result;
}

/**
 * The stated error of an observable, from that of the state: each variable's share of its size,
 * times how much the observable changes with it.
 * @param {Object} scene
 * @param {number} row of the motion
 * @param {number} index of the observable
 * @returns {number}
 */
export function observableError({ motion, field, values }, row, index) {
  const share = motion.error[row];
  const state = Float64Array.from(motion.y, (column) => column[row]);
  const out = new Float64Array(field.observable_names.length);
  const at = () => field.observables(motion.t[row], state, values, out)[index];
  const here = at();
  let error = 0;
  for (let j = 0; j < state.length; j += 1) {
    const step = 1e-5 * motion.scales[j];
    const before = state[j];
    state[j] = before + step;
    error += (Math.abs(at() - here) / step) * share * motion.scales[j];
    state[j] = before;
  }
  return error;
}

/**
 * The state with a given observed value and rate, near a state.
 *
 * Newton's method in two unknowns: the value of the observed coordinate, which both stretches of an
 * actuator share, and that of its rate.
 * @param {Object} field
 * @param {Object} description
 * @param {Object<string, number>} parameters
 * @param {ArrayLike<number>} near
 * @param {[number, number]} wanted the two observables
 * @param {[number, number]} indices of them
 * @returns {?Float64Array} null where there is none
 */
export function stateAt(field, description, parameters, near, wanted, indices) {
  const [coordinates, rates] = movedBy(description);
  const state = Float64Array.from(near);
  const out = new Float64Array(field.observable_names.length);
  const set = (u) => {
    coordinates.forEach((k) => { state[k] = u[0]; });
    rates.forEach((k) => { state[k] = u[1]; });
  };
  const misfit = (u) => {
    set(u);
    field.observables(0, state, parameters, out);
    return [out[indices[0]] - wanted[0], out[indices[1]] - wanted[1]];
  };
  let u = [state[coordinates[0]], rates.length ? state[rates[0]] : 0];
  for (let turn = 0; turn < 60; turn += 1) {
    const f = misfit(u);
    if (Math.hypot(...f) < 1e-12 * (1 + Math.hypot(...wanted))) {
      break;
    }
    const step = newtonStep(misfit, u, f);
    if (!step) {
      return null;
    }
    let share = 1;
    while (share > 1e-4 && !(Math.hypot(...misfit([u[0] + share * step[0], u[1] + share * step[1]])) < Math.hypot(...f))) {
      share /= 2;
    }
    u = [u[0] + share * step[0], u[1] + share * step[1]];
  }
  const left = Math.hypot(...misfit(u));
  return left < 1e-8 * (1 + Math.hypot(...wanted)) && field.admissible(state, parameters) ? state : null;
}

/** Indices of the variables that one value sets, and of those that one rate sets. */
function movedBy({ kind, state, watched }) {
  const all = state.flatMap((one, k) => (one.role === "coordinate" ? [k] : []));
  const named = state.findIndex((one) => one.name === watched);
  const first = named >= 0 ? named : (all[0] ?? 0);
  const coordinates = kind === "Actuator" ? all : [first];
  const names = coordinates.map((k) => state[k].name);
  const rates = state.flatMap((one, k) => (one.role === "rate" && names.includes(one.belongs_to) ? [k] : []));
  const others = state.map((_, k) => k).filter((k) => k !== first);
  return [coordinates, rates.length ? rates : others.slice(0, 1)];
}

function newtonStep(misfit, u, f) {
  const h = u.map((x) => 1e-6 * Math.max(1, Math.abs(x)));
  const [p, q] = [misfit([u[0] + h[0], u[1]]), misfit([u[0], u[1] + h[1]])];
  const [a, c] = [(p[0] - f[0]) / h[0], (p[1] - f[1]) / h[0]];
  const [b, d] = [(q[0] - f[0]) / h[1], (q[1] - f[1]) / h[1]];
  const determinant = a * d - b * c;
  return Math.abs(determinant) > 1e-14
    ? [(-f[0] * d + f[1] * b) / determinant, (f[0] * c - f[1] * a) / determinant]
    : null;
}
