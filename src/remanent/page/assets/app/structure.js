// Menus of the kinds of parts: another kind is other equations, which the server writes.

import { button, element, menu } from "./dom.js";

const NONE = { value: "", text: "none" };

/**
 * The menus of a group; null where it has none.
 * @param {Object} app with `kinds`, `store`, `saved`, `chooseSpec`
 * @param {string} group "drive", "material", "dissipation", "heat" or "magnet"
 * @returns {?HTMLElement}
 */
export function kindMenus(app, group) {
  const kinds = app.kinds?.[group];
  const { description } = app.store.get();
  if (app.saved || !kinds || (group !== "drive" && !description.spec.actuator)) {
    return null;
  }
  return (group === "dissipation" ? dissipationMenus : singleMenu)(app, group, kinds);
}

function choicesOf(kinds) {
  return kinds.map(({ name, text }) => ({ value: name, text: readable(name), title: text }));
}

/** "ArrudaBoyce" as "Arruda–Boyce", "SineSquared" as "sine squared". */
function readable(name) {
  const people = { ArrudaBoyce: "Arruda–Boyce", KelvinVoigt: "Kelvin–Voigt", MooneyRivlin: "Mooney–Rivlin", NeoHookean: "neo-Hookean", StrainEnergy: "a formula of one's own" };
  return people[name] ?? name.replace(/([a-z])([A-Z])/g, (_, a, b) => `${a} ${b.toLowerCase()}`);
}

function singleMenu(app, group, kinds) {
  const spec = app.currentSpec();
  const table = group === "drive" ? spec.drive : spec.actuator[group];
  if (group === "drive" && !table.kind) {
    return null;
  }
  if (group === "magnet") {
    return magnetLaws(app, spec);
  }
  const optional = group === "heat";
  const choices = [...(optional ? [NONE] : []), ...choicesOf(kinds)];
  const chosen = table?.kind ?? "";
  return labelled("kind", menu(choices, chosen, (name) => {
    const next = name ? tableOf(kinds, name, table ?? {}) : undefined;
    if (group === "drive") {
      app.chooseSpec({ ...spec, drive: next });
    } else {
      const actuator = { ...spec.actuator };
      delete actuator[group];
      app.chooseSpec({ ...spec, actuator: next ? { ...actuator, [group]: next } : actuator });
    }
  }, { "data-kind": group, "aria-label": `kind of ${group === "drive" ? "load" : group}` }));
}

function magnetLaws(app, spec) {
  const laws = ["deformation-gradient", "rotation"].map((value) => ({ value, text: value }));
  const magnet = spec.actuator.magnet ?? { kind: "Magnet" };
  return labelled("law", menu(laws, magnet.law ?? laws[0].value, (law) => {
    app.chooseSpec({ ...spec, actuator: { ...spec.actuator, magnet: { ...magnet, law } } });
  }, { "data-kind": "magnet", "aria-label": "law of magnetisation" }));
}

function dissipationMenus(app, group, kinds) {
  const spec = app.currentSpec();
  const given = spec.actuator.dissipation ?? [];
  const elements = Array.isArray(given) ? given : [given];
  const choose = (dissipation) => app.chooseSpec({ ...spec, actuator: { ...spec.actuator, dissipation } });
  const rows = elements.map((one, k) =>
    element("div", { class: "element-row" },
      element("span", { text: `${readable(one.kind)} (${k})` }),
      button("remove", () => choose(elements.filter((_, other) => other !== k)), {
        class: "quiet", "aria-label": `remove ${readable(one.kind)} ${k}`,
      })),
  );
  const adding = menu([{ value: "", text: elements.length ? "add another …" : "none" }, ...choicesOf(kinds)], "",
    (name) => name && choose([...elements, tableOf(kinds, name, {})]),
    { "data-kind": group, "aria-label": "add a dissipative element" });
  return element("div", { class: "elements" }, ...rows, labelled(elements.length ? "" : "element", adding));
}

/** The table of a kind: its usual values, and those that the one before shares with it. */
function tableOf(kinds, name, before) {
  const kind = kinds.find((one) => one.name === name);
  const usual = kind.table;
  const shared = Object.entries(before).filter(([key]) => key !== "kind" && key in usual);
  return { kind: name, ...structuredClone(usual), ...Object.fromEntries(shared) };
}

function labelled(text, node) {
  return element("label", { class: "kind" }, element("span", { text }), node);
}
