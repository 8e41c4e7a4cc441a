// The panel of controls: presets, numbers, kinds of parts, the start and the length of the run.

import { button, element, menu, refill } from "./dom.js";
import { numberControl } from "./number_control.js";
import { partTable } from "./part_table.js";
import { LENGTH_LIMITS, startLimits } from "./state.js";
import { kindMenus } from "./structure.js";
import { conversion } from "./units.js";

const GROUPS = [
  { id: "actuator", title: "Actuator" },
  { id: "system", title: "System" },
  { id: "drive", title: "Magnetic load" },
  { id: "material", title: "Material" },
  { id: "dissipation", title: "Damping" },
  { id: "heat", title: "Heat" },
  { id: "magnet", title: "Magnet" },
];
const FIRST = ["temperature", "reference_temperature", "prestress", "prestress_1", "prestress_2", "c", "b", "m", "omega"];
const RUNS = {
  periods: { name: "periods", symbol: "N", text: "drive periods", unit: "1", min: 10, max: 2000, scale: "log",
    rule: "It must be a whole number from 1 to 5000.", limits: LENGTH_LIMITS.periods },
  duration: { name: "duration", symbol: "\\tau_{\\mathrm{end}}", text: "duration", unit: "1", min: 5, max: 2000, scale: "log",
    rule: "It must be greater than 0 and at most 20 000.", limits: LENGTH_LIMITS.duration },
};

/**
 * Build the panel for a model, and keep its numbers up to date.
 * @param {HTMLElement} host
 * @param {Object} app with `store`, `kinds`, `saved` and the actions `move`, `commit`,
 *   `moveInitial`, `moveRun`, `chooseSpec`, `resetAll`
 * @returns {{build: function(): void, show: function(): void, fault: function(Object): boolean}}
 */
export function controlPanel(host, app) {
  let shown = new Map();
  const build = () => {
    shown = new Map();
    const { description, si } = app.store.get();
    const factors = si ? description.si : null;
    const sections = GROUPS.map((group) => section(app, group, factors, shown)).filter(Boolean);
    refill(host, ...sections, startSection(app, factors, shown), runSection(app, factors, shown));
    show();
  };
  const show = () => {
    const { values, initial } = app.store.get();
    for (const { control, read } of shown.values()) {
      control.show(read({ values, initial, state: app.store.get() }));
    }
  };
  const fault = ({ key, message }) => {
    const entry = shown.get(key) ?? [...shown].find(([name]) => name.endsWith(`.${key}`))?.[1];
    entry?.control.fault(message);
    return Boolean(entry);
  };
  return { build, show, fault };
}

function section(app, group, factors, shown) {
  const { description, values } = app.store.get();
  const parameters = description.parameters
    .filter((one) => one.group === group.id)
    .sort((a, b) => rank(a.name) - rank(b.name));
  const menus = kindMenus(app, group.id);
  const table = ["drive", "material"].includes(group.id) ? partTable(app, group.id, factors) : null;
  if (!parameters.length && !menus && !table) {
    return null;
  }
  const controls = parameters.map((parameter) => {
    const control = numberControl(parameter, {
      value: values[parameter.name], usual: parameter.value, factors, move: app.move, commit: app.commit,
    });
    shown.set(parameter.name, { control, read: (now) => now.values[parameter.name] });
    return control.node;
  });
  const title = group.id === "drive" && description.kind !== "Actuator" ? "Load" : group.title;
  return element(
    "fieldset", { class: "group", "data-group": group.id },
    element("legend", { text: title }), menus, ...controls, table,
  );
}

function rank(name) {
  const place = FIRST.indexOf(name);
  return place < 0 ? FIRST.length : place;
}

function startSection(app, factors, shown) {
  const { description, initial } = app.store.get();
  const controls = description.state.map((one, k) => {
    const span = rangeOfStart(one, initial[k]);
    const parameter = {
      ...one, ...span, symbol: `${one.symbol}(0)`, scale: "linear", limits: startLimits(one),
      rule: one.positive ? "It must be a finite number greater than 0." : "It must be a finite number.",
    };
    const control = numberControl(parameter, {
      value: initial[k], usual: app.startOf(k), factors,
      move: (_, value) => app.moveInitial(k, value), commit: app.commit,
    });
    shown.set(`initial.${one.name}`, { control, read: (now) => now.initial[k] });
    return control.node;
  });
  return element(
    "fieldset", { class: "group", "data-group": "initial" },
    element("legend", { text: "Start" }), ...controls,
    button("Start at rest", app.startAtRest, { class: "quiet" }),
  );
}

function rangeOfStart(one, value) {
  const [low, high] = one.role === "temperature" ? [200, 450]
    : one.positive ? [0.3, 2.5] : one.role === "rate" ? [-2, 2] : [-3, 3];
  return { min: Math.min(low, value), max: Math.max(high, value) };
}

function runSection(app, factors, shown) {
  const { description } = app.store.get();
  const name = description.drive.periodic ? "periods" : "duration";
  const control = numberControl(RUNS[name], {
    value: app.store.get()[name], usual: app.store.get().defaults[name], factors,
    move: (_, value) => app.moveRun(name, name === "periods" ? Math.max(1, Math.round(value)) : value),
    commit: app.commit,
  });
  shown.set(name, { control, read: (now) => now.state[name] });
  return element("fieldset", { class: "group", "data-group": "run" }, element("legend", { text: "Run" }), control.node);
}

/**
 * The menu of presets.
 * @param {Object} app with `presets`, `store`, `choosePreset`
 * @returns {HTMLElement}
 */
export function presetMenu(app) {
  const chosen = app.store.get().preset ?? "";
  const choices = app.presets.map(({ id, title, text }) => ({ value: id, text: title, title: text }));
  const first = chosen ? [] : [{ value: "", text: "own parameters" }];
  return menu([...first, ...choices], chosen, (id) => id && app.choosePreset(id), {
    id: "preset", "aria-label": "preset",
  });
}

/** Whether anything of a model can be shown in SI. */
export function hasUnits(description) {
  return Boolean(description.si) && conversion("time", description.si).unit !== null;
}
