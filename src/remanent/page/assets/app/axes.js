// Axes: ranges, ticks, and the way from numbers to pixels.

import { numberText, powerOfTen } from "./numbers.js";

/** Share of an axis that stays free beyond the data at each end. */
const MARGIN = 0.05;
/** Labels along an axis, at most, about. */
const MOST_TICKS = 10;
/** An axis is kept while the data fill at least this share of it. */
const MIN_FILLED_SHARE = 0.55;

/**
 * A range for data: the one before where it still fits, so that axes do not tremble.
 * @param {[number, number]} data smallest and largest number; NaN where there is none
 * @param {?[number, number]} before
 * @param {{logarithmic?: boolean, tight?: boolean, floor?: number}} [options] tight: end where the data end; floor: a value below which the axis does not go
 * @returns {[number, number]}
 */
export function fittedRange(data, before, { logarithmic = false, tight = false, floor = -Infinity } = {}) {
  let [low, high] = logarithmic ? data.map((x) => Math.log10(Math.max(x, 1e-300))) : data;
  if (!(low <= high)) {
    return before ?? (logarithmic ? [1e-12, 1] : [0, 1]);
  }
  if (tight) {
    return low < high ? data : [low - 0.5, high + 0.5];
  }
  const least = 0.02 * Math.max(Math.abs(high), Math.abs(low), 1e-6);
  const spread = Math.max(high - low, logarithmic ? 1 : least);
  const old = before && (logarithmic ? before.map(Math.log10) : before);
  if (old && old[0] <= low - 0.01 * spread && high + 0.01 * spread <= old[1]) {
    if (spread >= MIN_FILLED_SHARE * (old[1] - old[0])) {
      return before;
    }
  }
  const step = logarithmic ? 1 : niceStep(spread, 12);
  const middle = (low + high) / 2;
  [low, high] = [Math.min(low, middle - spread / 2), Math.max(high, middle + spread / 2)];
  low = Math.max(Math.floor((low - MARGIN * spread) / step) * step, logarithmic ? -Infinity : floor);
  high = Math.ceil((high + MARGIN * spread) / step) * step;
  const room = logarithmic ? 0.14 * (high - low) : 0;
  return logarithmic ? [10 ** (low - room), 10 ** (high + room)] : [low, high];
}

function niceStep(spread, count) {
  const raw = spread / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const ratio = raw / power;
  return power * (ratio <= 1 ? 1 : ratio <= 2 ? 2 : ratio <= 5 ? 5 : 10);
}

/** Like the above, but the nearest of these steps in place of the next larger. */
function nearStep(spread, count) {
  const raw = spread / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const ratio = raw / power;
  return power * (ratio < 1.5 ? 1 : ratio < 3.2 ? 2 : ratio < 7.2 ? 5 : 10);
}

/**
 * Ticks of an axis.
 * @param {[number, number]} range
 * @param {number} length in pixels
 * @param {{logarithmic?: boolean, spacing?: number}} [options] spacing: least pixels between labels
 * @returns {Array<{value: number, text: string}>}
 */
export function ticks(range, length, { logarithmic = false, spacing = 70 } = {}) {
  const count = Math.min(MOST_TICKS, Math.max(2, Math.floor(length / spacing)));
  return logarithmic ? decadeTicks(range, count) : evenTicks(range, count);
}

function evenTicks([low, high], count) {
  const step = nearStep(high - low, count);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  const places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const plain = places <= 5 && Math.max(Math.abs(low), Math.abs(high)) < 1e6;
  const result = [];
  for (let k = first; k <= last; k += 1) {
    const value = k * step;
    const text = plain ? value.toFixed(places).replace("-", "−") : numberText(value, 3);
    result.push({ value, text: k === 0 ? "0" : text });
  }
  return result;
}

function decadeTicks([low, high], count) {
  const first = Math.ceil(Math.log10(low) - 1e-9);
  const last = Math.floor(Math.log10(high) + 1e-9);
  const stride = Math.max(1, Math.ceil((last - first + 1) / count));
  const result = [];
  const inward = Math.floor(((last - first) % stride) / 2);
  for (let k = last - inward; k >= first; k -= stride) {
    result.push({ value: 10 ** k, text: powerOfTen(k) });
  }
  return result;
}

/**
 * The map of an axis to pixels.
 * @param {[number, number]} range
 * @param {number} start pixel of the lower end
 * @param {number} end pixel of the upper end
 * @param {boolean} [logarithmic]
 * @returns {{pixel: function(number): number, value: function(number): number, range, start, end}}
 */
export function axisMap(range, start, end, logarithmic = false) {
  const [low, high] = logarithmic ? range.map(Math.log10) : range;
  const slope = (end - start) / (high - low);
  const pixel = logarithmic
    ? (value) => start + (Math.log10(Math.max(value, 1e-300)) - low) * slope
    : (value) => start + (value - low) * slope;
  const value = logarithmic
    ? (place) => 10 ** (low + (place - start) / slope)
    : (place) => low + (place - start) / slope;
  return { pixel, value, range, start, end, logarithmic };
}
