// The address of the page says what it shows, so that it can be shared and goes back and forward.

import { restOf } from "./spec.js";

const VIEW_KEYS = { span: "start", units: "dimensionless" };

/**
 * What the part of the address after # says.
 * @param {string} hash
 * @returns {{preset: ?string, spec: ?Object, point: ?number[], values: Object<string, number>,
 *   initial: Object<string, number>, view: Object, broken: boolean}}
 *   broken: something in it could not be read
 */
export function readAddress(hash) {
  const table = () => Object.create(null);
  const said = { preset: null, spec: null, values: table(), initial: table(), view: table(), broken: false };
  for (const [key, text] of new URLSearchParams(hash.replace(/^#/, ""))) {
    const number = Number(text);
    if (key === "preset") {
      said.preset = text;
    } else if (key === "spec") {
      said.spec = parsed(text);
      said.broken ||= said.spec === null;
    } else if (key === "periods" || key === "duration") {
      said.view[key] = number;
    } else if (Object.hasOwn(VIEW_KEYS, key)) {
      said.view[key] = text;
    } else if (key.startsWith("p.") || key.startsWith("y.")) {
      const numbers = key[0] === "p" ? said.values : said.initial;
      said.broken ||= text === "" || !Number.isFinite(number);
      if (text !== "" && Number.isFinite(number)) {
        numbers[key.slice(2)] = number;
      }
    } else {
      said.broken = true;
    }
  }
  return said;
}

function parsed(text) {
  try {
    const value = JSON.parse(text);
    return value && typeof value === "object" ? value : null;
  } catch {
    return null;
  }
}

/**
 * The part of the address after # for a state of the page.
 * @param {Object} state of the store
 * @returns {string}
 */
export function writeAddress(state) {
  const { description, values, initial } = state;
  const words = new URLSearchParams();
  if (state.preset) {
    words.set("preset", state.preset);
  } else if (!state.isStart) {
    words.set("spec", JSON.stringify(description.spec));
  }
  for (const { name, value } of description.parameters) {
    if (values[name] !== value) {
      words.set(`p.${name}`, String(values[name]));
    }
  }
  description.state.forEach((one, k) => {
    if (initial[k] !== startOf(description, k, values)) {
      words.set(`y.${one.name}`, String(initial[k]));
    }
  });
  const run = description.drive.periodic ? "periods" : "duration";
  if (state[run] !== state.defaults[run]) {
    words.set(run, String(state[run]));
  }
  for (const [key, usual] of Object.entries(VIEW_KEYS)) {
    if (state[key] !== usual) {
      words.set(key, state[key]);
    }
  }
  return `#${words.toString()}`;
}

/**
 * The value of a state variable at the start where nothing else is said.
 * @param {Object} description
 * @param {number} k
 * @param {Object<string, number>} values
 * @returns {number}
 */
export function startOf(description, k, values) {
  const variable = description.state[k];
  const given = description.spec.initial?.[variable.name];
  return given ?? restOf(variable, values);
}
