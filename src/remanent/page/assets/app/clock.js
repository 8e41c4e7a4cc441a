// The clock of the animation: one unit of tau in a second, times a speed.

import { firstAfter } from "./curves.js";
import { prefersStill } from "./theme.js";

/** Milliseconds between two pictures of the animation, at least: it must not slow a slider. */
const MIN_PICTURE_MS = 24;

/**
 * A clock that plays the part of a motion that is shown.
 * @param {{instant: function(Object): void, state: function(boolean): void}} listeners
 *   instant: called with `{t, y, observables}`; state: with whether it plays
 * @returns {{show: function(Object): void, toggle: function(): void, setSpeed: function(number): void}}
 */
export function createClock({ instant, state }) {
  let scene = null;
  let speed = 1;
  let time = 0;
  let before = null;
  let on = !prefersStill();
  const tick = (now) => {
    if (!on) {
      before = null;
      return;
    }
    requestAnimationFrame(tick);
    const passed = before === null ? 0 : now - before;
    if (before !== null && passed < MIN_PICTURE_MS) {
      return;
    }
    before = now;
    if (scene && !document.hidden) {
      time += (Math.min(passed, 100) / 1000) * speed;
      tell();
    }
  };
  const tell = () => {
    const [low, high] = scene.played;
    if (!(time >= low && time <= high)) {
      time = low;
    }
    instant(instantAt(scene, time));
  };
  if (on) {
    requestAnimationFrame(tick);
  }
  return {
    show: (next) => {
      scene = next;
      if (scene.motion.t.length > 1) {
        tell();
      }
    },
    toggle: () => {
      on = !on;
      state(on);
      if (on) {
        requestAnimationFrame(tick);
      }
    },
    setSpeed: (factor) => {
      speed = factor;
    },
    isOn: () => on,
  };
}

/** The state at a time, by a cubic piece between two samples. */
function instantAt({ motion, field, values }, time) {
  const i = Math.min(Math.max(firstAfter(motion.t, time) - 1, 0), motion.t.length - 2);
  const size = motion.y.length;
  const [a, b, slopeA, slopeB, y] = Array.from({ length: 5 }, () => new Float64Array(size));
  motion.y.forEach((column, j) => {
    a[j] = column[i];
    b[j] = column[i + 1];
  });
  field.rates(motion.t[i], a, values, slopeA);
  field.rates(motion.t[i + 1], b, values, slopeB);
  const h = motion.t[i + 1] - motion.t[i];
  const s = Math.min(1, Math.max(0, (time - motion.t[i]) / h));
  for (let j = 0; j < size; j += 1) {
    y[j] = (1 + 2 * s) * (1 - s) ** 2 * a[j] + s * s * (3 - 2 * s) * b[j]
      + h * (s * (1 - s) ** 2 * slopeA[j] + s * s * (s - 1) * slopeB[j]);
  }
  const observables = new Float64Array(field.observable_names.length);
  field.observables(time, y, values, observables);
  return { t: time, y, observables };
}
