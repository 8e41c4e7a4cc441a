// Elements made by hand: text goes in as text, never as markup.

const SVG = "http://www.w3.org/2000/svg";

/**
 * An HTML element.
 * @param {string} tag
 * @param {Object<string, *>} [attributes] `class`, `id`, `aria-label` ...; `text` is its text,
 *   and functions are listeners: `{click: f}`.  Undefined and false ones are left out.
 * @param {...(Node|string)} children
 * @returns {HTMLElement}
 */
export function element(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/**
 * An element of a drawing.
 * @param {string} tag
 * @param {Object<string, *>} [attributes] as for `element`
 * @param {...(Node|string)} children
 * @returns {SVGElement}
 */
export function drawing(tag, attributes = {}, ...children) {
  return filled(document.createElementNS(SVG, tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) {
      continue;
    }
    if (name === "text") {
      node.textContent = value;
    } else if (typeof value === "function") {
      node.addEventListener(name, value);
    } else {
      node.setAttribute(name, value === true ? "" : String(value));
    }
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/**
 * Put other children into a node.
 * @param {Element} node
 * @param {...(Node|string)} children
 */
export function refill(node, ...children) {
  node.replaceChildren(...children.filter((child) => child !== null && child !== undefined));
}

/**
 * The element with an id; every one that is asked for is in the page.
 * @param {string} id
 * @returns {HTMLElement}
 */
export function byId(id) {
  return document.getElementById(id);
}

/**
 * A button.
 * @param {string} text
 * @param {function(Event): void} action
 * @param {Object<string, *>} [attributes]
 * @returns {HTMLElement}
 */
export function button(text, action, attributes = {}) {
  return element("button", { type: "button", text, click: action, ...attributes });
}

/**
 * A menu of choices.
 * @param {Array<{value: string, text: string, title?: string}>} choices
 * @param {string} chosen
 * @param {function(string): void} action called with the value that was chosen
 * @param {Object<string, *>} [attributes]
 * @returns {HTMLSelectElement}
 */
export function menu(choices, chosen, action, attributes = {}) {
  const options = choices.map(({ value, text, title }) =>
    element("option", { value, text, title, selected: value === chosen }),
  );
  const select = element("select", attributes, ...options);
  select.addEventListener("change", () => action(select.value));
  return select;
}
