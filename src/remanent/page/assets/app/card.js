// A view of the page: a heading, what can be done with it, a figure, and a line of words below.

import { button, element } from "./dom.js";

/**
 * A view.
 * @param {{id: string, title: string, tools?: Array<HTMLElement>, save?: function(): void}} options
 *   save: opens what the figure can be taken away as
 * @returns {{node: HTMLElement, body: HTMLElement, note: HTMLElement, key: HTMLElement,
 *   tools: HTMLElement}}
 */
export function card({ id, title, tools = [], save }) {
  const body = element("div", { class: "card-body" });
  const key = element("div", { class: "card-key" });
  const note = element("p", { class: "card-note" });
  const all = element("div", { class: "card-tools" }, ...tools);
  if (save) {
    all.append(button("Save", save, { class: "quiet", "aria-label": `save the figure ${title}`, "data-save": id }));
  }
  const head = element("header", { class: "card-head" }, element("h2", { id: `${id}-title`, text: title }), key, all);
  const node = element("section", { class: "card", id, "aria-labelledby": `${id}-title` }, head, body, note);
  return { node, body, note, key, tools: all };
}

/**
 * A few choices of which one holds, as buttons.
 * @param {string} label what is chosen
 * @param {Array<{value: string, text: string}>} choices
 * @param {function(): string} chosen
 * @param {function(string): void} choose
 * @returns {{node: HTMLElement, show: function(): void}}
 */
export function segments(label, choices, chosen, choose) {
  const buttons = choices.map(({ value, text }) => button(text, () => choose(value), { "data-value": value }));
  const node = element("div", { class: "segments", role: "group", "aria-label": label }, ...buttons);
  const show = () =>
    buttons.forEach((one) => one.setAttribute("aria-pressed", String(one.dataset.value === chosen())));
  show();
  return { node, show };
}

/**
 * An entry of a legend.
 * @param {string} name
 * @param {string} colour
 * @param {{dash?: string, symbol?: string}} [look]
 * @returns {{name: string, colour: string, look: string}}
 */
export function keyEntry(name, colour, { dash, symbol } = {}) {
  return { name, colour, look: symbol ? `mark-${symbol}` : `line-${dash ?? "solid"}` };
}

/**
 * Show a legend, each entry a sample of the line or mark and its name; the page is touched only
 * where something changed.
 * @param {HTMLElement} host
 * @param {Array<Object>} entries of `keyEntry`
 */
export function showKey(host, entries) {
  const said = JSON.stringify(entries);
  if (host.dataset.said === said) {
    return;
  }
  host.dataset.said = said;
  host.replaceChildren(...entries.map(({ name, colour, look }) => {
    const sample = element("span", { class: `sample ${look}`, "aria-hidden": "true" });
    sample.style.setProperty("--colour", colour);
    return element("span", { class: "key-entry" }, sample, element("span", { text: name }));
  }));
}

/**
 * Put a text into a node where it is another one.
 * @param {HTMLElement} node
 * @param {string} text
 */
export function putText(node, text) {
  if (node.textContent !== text) {
    node.textContent = text;
  }
}
