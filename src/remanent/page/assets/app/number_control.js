// One number: a slider, a field to type in, its unit, and words where it breaks its rule.

import { element } from "./dom.js";
import { fieldText, isWithin, numberText, typedNumber } from "./numbers.js";
import { symbolElement, symbolText } from "./symbols.js";
import { conversion, named, unitText } from "./units.js";

const LOG_STEPS = 1000;
let count = 0;

/**
 * A control of a number.
 * @param {Object} given a parameter of the description: `name`, `symbol`, `text`, `unit`, `min`, `max`,
 *   `scale`, `rule`, `limits`, `fixed`, and `bounds`, beyond which numbers are hardly meant
 * @param {{value: number, usual: number, factors: ?Object, move: function(string, number): void,
 *   commit: function(string): void, slider?: boolean}} options
 *   move: called with the name and a value that keeps the rule, also while a slider moves;
 *   commit: called when it has come to rest; usual: the value that a double click brings back
 * @returns {{node: HTMLElement, show: function(number): void, fault: function(string): void}}
 */
export function numberControl(given, options) {
  const parameter = named(given, options.factors);
  count += 1;
  const id = `number-${count}`;
  const { unit, to, back } = conversion(parameter.name, options.factors);
  const shownUnit = unitText(parameter, options.factors);
  const digits = unit === null ? fieldText : (x) => fieldText(Number(x.toPrecision(5)));
  const fault = element("p", { class: "fault", id: `${id}-fault`, role: "alert" });
  const field = element("input", {
    type: "text", inputmode: "decimal", class: "number", id, autocomplete: "off", spellcheck: "false",
    "aria-describedby": `${id}-fault`,
  });
  const slider = makeSlider(parameter, id);
  const label = element(
    "label", { for: id, title: parameter.help || parameter.text },
    symbolElement(parameter.symbol), element("span", { class: "meaning", text: parameter.text }),
  );
  const control = element(
    "div", { class: "control", "data-name": parameter.name },
    label,
    element("span", { class: "entry" }, field, element("span", { class: "unit", text: shownUnit })),
    options.slider === false ? null : slider.node,
    fault,
  );
  const say = (words) => {
    fault.textContent = words;
    control.classList.toggle("faulty", Boolean(words));
    field.setAttribute("aria-invalid", words ? "true" : "false");
  };
  const show = (value) => {
    if (document.activeElement !== field || !field.classList.contains("typing")) {
      field.value = digits(to(value));
    }
    slider.put(value);
    slider.node.setAttribute("aria-valuetext", `${numberText(to(value), 4)} ${shownUnit}`.trim());
  };
  const accept = (value, committed) => {
    say("");
    options.move(parameter.name, value);
    if (committed) {
      options.commit(parameter.name);
    }
  };
  slider.node.setAttribute("aria-label", `${parameter.text} ${symbolText(parameter.symbol)}, slider`);
  slider.node.addEventListener("input", () => accept(slider.value(), false));
  slider.node.addEventListener("change", () => accept(slider.value(), true));
  label.addEventListener("dblclick", () => accept(options.usual, true));
  field.addEventListener("input", () => field.classList.add("typing"));
  field.addEventListener("change", () => {
    field.classList.remove("typing");
    const typed = typedNumber(field.value);
    const value = back(typed);
    const words = brokenRule(parameter, field.value, value, { to, unit: shownUnit });
    if (words) {
      say(words);
    } else {
      accept(value, true);
    }
  });
  field.addEventListener("keydown", (event) => stepField(event, field, slider, accept));
  if (parameter.fixed) {
    field.disabled = slider.node.disabled = true;
    control.title = parameter.fixed;
    fault.textContent = parameter.fixed;
    control.classList.add("fixed");
  }
  show(options.value);
  return { node: control, show, fault: say };
}

/** Arrow keys in the field move the number as the slider does. */
function stepField(event, field, slider, accept) {
  const steps = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
  if (steps) {
    event.preventDefault();
    field.classList.remove("typing");
    accept(slider.stepped(steps), true);
  }
}

/** Why a typed value is refused; empty where it is not. */
function brokenRule({ text, rule, limits, bounds }, typed, value, { to, unit }) {
  if (!Number.isFinite(value)) {
    return typed.trim() === ""
      ? `Type a number. The curves keep the last value of the ${text}.`
      : `“${typed.trim().slice(0, 30)}” is not a number. Write for example 1.25 or 3e-2.`;
  }
  const isAllowed = isWithin(limits, value);
  if (isAllowed && isWithin(bounds, value)) {
    return "";
  }
  const got = `${numberText(to(value), 5)} ${unit}`.trim();
  const broken = isAllowed ? boundsText(bounds, { to, unit }) : rule;
  return `Got ${got}. ${(broken ?? "It is out of range.").replace("Pass ", "Enter ").replace("pass ", "enter ")}`;
}

/** The bounds of a number in the units in force. */
function boundsText({ least, most, rule }, { to, unit }) {
  const ends = [least, most].map((end) => numberText(to(end), 4)).join(" and ");
  return rule.replace(/between \S+ and \S+/, `between ${ends}${unit ? ` ${unit}` : ""}`);
}

function makeSlider({ min, max, scale }, id) {
  const logarithmic = scale === "log" && min > 0;
  const step = logarithmic ? 1 : roundStep((max - min) / 250);
  const node = element("input", {
    type: "range", id: `${id}-slider`,
    min: logarithmic ? 0 : min, max: logarithmic ? LOG_STEPS : max, step: logarithmic ? 1 : "any",
  });
  const growth = logarithmic ? Math.log(max / min) / LOG_STEPS : 0;
  const fromPlace = (place) => {
    if (logarithmic) {
      return Number((min * Math.exp(growth * place)).toPrecision(3));
    }
    return rounded(Math.min(Math.max(place, min), max), step);
  };
  let current = min;
  const place = (value) => (logarithmic ? Math.log(value / min) / growth : value);
  const stepped = (steps) => {
    const next = logarithmic ? fromPlace(Math.round(place(current)) + 4 * steps) : rounded(current + steps * step, step);
    return Math.min(Math.max(next, min), max);
  };
  node.addEventListener("keydown", (event) => {
    const steps = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (steps) {
      event.preventDefault();
      current = stepped(steps);
      node.value = place(current);
      node.dispatchEvent(new Event("input"));
      node.dispatchEvent(new Event("change"));
    }
  });
  return {
    node,
    stepped,
    value: () => fromPlace(Number(node.value)),
    put: (value) => {
      current = value;
      node.value = place(value);
      const share = (place(value) - Number(node.min)) / (Number(node.max) - Number(node.min));
      node.style.setProperty("--filled", `${100 * Math.min(Math.max(share, 0), 1)}%`);
    },
  };
}

function roundStep(raw) {
  const power = 10 ** Math.floor(Math.log10(raw));
  const ratio = raw / power;
  return power * (ratio < 1.5 ? 1 : ratio < 3.5 ? 2 : ratio < 7.5 ? 5 : 10);
}

function rounded(value, step) {
  const places = Math.max(0, Math.ceil(-Math.log10(step)) + 1);
  return Number((Math.round(value / step) * step).toFixed(places));
}
