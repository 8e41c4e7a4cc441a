// Numbers as people read them.

const RAISED = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/**
 * A power of ten, 10⁻⁹.
 * @param {number} exponent a whole number
 * @returns {string}
 */
export function powerOfTen(exponent) {
  return "10" + [...String(exponent)].map((digit) => RAISED[digit]).join("");
}

/**
 * A number with a true minus, powers written out where it is very large or small.
 * @param {number} value
 * @param {number} [digits] significant digits
 * @returns {string}
 */
export function numberText(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return "not determined";
  }
  const size = Math.abs(value);
  if (size !== 0 && (size < 1e-3 || size >= 1e5)) {
    const exponent = Math.floor(Math.log10(size) + 1e-12);
    const mantissa = trimmed((value / 10 ** exponent).toFixed(Math.min(2, digits - 1)));
    return withMinus(mantissa === "1" ? powerOfTen(exponent) : `${mantissa} × ${powerOfTen(exponent)}`);
  }
  const places = size === 0 ? 0 : Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return withMinus(trimmed(value.toFixed(Math.min(places, 12))));
}

function trimmed(text) {
  return text.includes(".") ? text.replace(/\.?0+$/, "") : text;
}

function withMinus(text) {
  return text.replace("-", "−");
}

/**
 * An error bound: one digit, rounded up.
 * @param {number} error
 * @returns {string}
 */
export function errorText(error) {
  if (!Number.isFinite(error)) {
    return "not determined";
  }
  if (error <= 0) {
    return "0";
  }
  let exponent = Math.floor(Math.log10(error));
  let digit = Math.ceil(error / 10 ** exponent - 1e-9);
  if (digit === 10) {
    digit = 1;
    exponent += 1;
  }
  if (exponent >= -2 && exponent <= 1) {
    return trimmed((digit * 10 ** exponent).toFixed(Math.max(0, -exponent)));
  }
  return digit === 1 ? powerOfTen(exponent) : `${digit} × ${powerOfTen(exponent)}`;
}

/**
 * A number as it stands in a field: no more digits than a float of it needs.
 * @param {number} value
 * @returns {string}
 */
export function fieldText(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(7))) : "";
}

/**
 * The number that was typed; a comma may stand for the point, a true minus for a hyphen.
 * @param {string} text
 * @returns {number} NaN where it is none
 */
export function typedNumber(text) {
  const plain = text.trim().replace("−", "-").replace(/^(-?\d*),(\d+)$/, "$1.$2");
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}

/**
 * Whether a number lies within the limits of a rule.
 * @param {?Object} limits `least` and `most`, null where there is none, and whether they are allowed
 * @param {number} value
 * @returns {boolean}
 */
export function isWithin(limits, value) {
  const { least, most, least_included: least_too, most_included: most_too } = limits ?? {};
  const low = least !== null && least !== undefined && (value < least || (value === least && !least_too));
  const high = most !== null && most !== undefined && (value > most || (value === most && !most_too));
  return Number.isFinite(value) && !low && !high;
}

/**
 * Smallest and largest of the finite numbers of arrays.
 * @param {...ArrayLike<number>} arrays
 * @returns {[number, number]} NaN where there is none
 */
export function extent(...arrays) {
  let low = Infinity;
  let high = -Infinity;
  for (const values of arrays) {
    for (let i = 0; i < values.length; i += 1) {
      const value = values[i];
      if (value < low && value > -Infinity) {
        low = value;
      }
      if (value > high && value < Infinity) {
        high = value;
      }
    }
  }
  return low > high ? [NaN, NaN] : [low, high];
}
