// Tables and formulas of a part: times and loads, coefficients, a strain energy.  They are in the
// equations themselves, so the server writes these anew.

import { button, element } from "./dom.js";
import { typedNumber } from "./numbers.js";
import { conversion } from "./units.js";

const WORDS = { times: "time", loads: "load", multiples: "multiple of the frequency", phases: "phase", moduli: "modulus", exponents: "exponent" };
/** Groups whose editor is open; they stay so when the panel is built anew. */
const opened = new Set();
/** Rows of the largest field before it scrolls. */
const MOST_ROWS = 10;

/**
 * The editor of the tables and formulas of a part; null where it has none.
 * @param {Object} app with `currentSpec`, `trySpec`, `saved`
 * @param {string} group "drive" or "material"
 * @param {?Object} factors of SI
 * @returns {?HTMLElement}
 */
export function partTable(app, group, factors) {
  const entries = () => entriesOf(partOf(app.currentSpec(), group) ?? {}, factors);
  const given = entries();
  if (!given.length) {
    return null;
  }
  const fault = element("p", { class: "fault", role: "alert" });
  const fields = given.map(({ label, rows, put }) => ({
    put,
    label,
    node: element("textarea", { rows, spellcheck: "false", "aria-label": label, readonly: app.saved }),
  }));
  const fill = () => {
    fault.textContent = "";
    entries().forEach(({ text }, k) => { fields[k].node.value = text; });
  };
  const apply = async () => {
    fault.textContent = "";
    try {
      const changes = fields.map(({ put, node }) => put(node.value));
      const spec = app.currentSpec();
      await app.trySpec(withPart(spec, group, { ...partOf(spec, group), ...Object.assign({}, ...changes) }));
    } catch (error) {
      fault.textContent = error.faults?.length ? error.faults.map(({ message }) => message).join("\n") : error.message;
    }
  };
  const node = element(
    "details", { class: "part-table", "data-table": group, open: opened.has(group) },
    element("summary", { text: given.length > 1 ? "formula and constants" : given[0].label }),
    ...fields.flatMap(({ label, node: field }) => (fields.length > 1 ? [element("p", { class: "quiet-words", text: label }), field] : [field])),
    app.saved
      ? element("p", { class: "quiet-words", text: "They are in the equations of this page: remanent explore changes them." })
      : button("Apply", apply, { class: "quiet", "data-apply": group }),
    fault,
  );
  // The event of opening comes when something may be typed already: only closing forgets it.
  node.addEventListener("toggle", () => {
    opened[node.open ? "add" : "delete"](group);
    if (!node.open) {
      fill();
    }
  });
  fill();
  return node;
}

function partOf(spec, group) {
  return group === "drive" ? spec.drive : spec.actuator?.[group];
}

function withPart(spec, group, part) {
  return group === "drive" ? { ...spec, drive: part } : { ...spec, actuator: { ...spec.actuator, [group]: part } };
}

/** What of a part is a table or a formula: its text, and how a text becomes it again. */
function entriesOf(part, factors) {
  const isList = (value) => Array.isArray(value) && value.every((one) => typeof one === "number");
  const columns = Object.keys(part).filter((key) => isList(part[key]));
  const formulas = Object.keys(part).filter((key) => key === "expression");
  const mappings = Object.keys(part).filter((key) => key === "constants");
  return [
    ...formulas.map((key) => formulaEntry(key, part)),
    ...mappings.map((key) => mappingEntry(key, part)),
    ...(columns.length ? [columnsEntry(columns, part, factors)] : []),
  ];
}

function formulaEntry(key, part) {
  return { label: "formula of the strain energy", text: part[key], rows: 3, put: (text) => ({ [key]: text.trim() }) };
}

function mappingEntry(key, part) {
  const lines = Object.entries(part[key]).map(([name, value]) => `${name} = ${tidy(value)}`);
  const read = (line) => {
    const [name, value, ...more] = line.split("=").map((one) => one.trim());
    if (!name || more.length || !Number.isFinite(typedNumber(value ?? ""))) {
      throw new Error(`“${line.trim().slice(0, 40)}” is no constant. Write for example a = 0.5, one on a line.`);
    }
    return [name, typedNumber(value)];
  };
  return {
    label: "constants of the formula", text: lines.join("\n"), rows: rowsFor(lines.length),
    put: (text) => ({ [key]: Object.fromEntries(linesOf(text).map(read)) }),
  };
}

function columnsEntry(keys, part, factors) {
  const units = keys.map((key) => conversion(key, factors));
  const count = Math.max(...keys.map((key) => part[key].length));
  const show = (key, k, i) => (i < part[key].length ? tidy(units[k].to(part[key][i])) : "");
  const lines = Array.from({ length: count }, (_, i) => keys.map((key, k) => show(key, k, i)).join("  "));
  const names = keys.map((key, k) => `${WORDS[key] ?? key.replace(/_/g, " ")}${units[k].unit ? ` (${units[k].unit})` : ""}`);
  const read = (line) => {
    const numbers = line.trim().split(/[\s;]+/).map(typedNumber);
    if (numbers.length !== keys.length || !numbers.every(Number.isFinite)) {
      throw new Error(`“${line.trim().slice(0, 40)}” is no row. Write on each line ${keys.length} numbers: ${names.join(", ")}.`);
    }
    return numbers.map((x, k) => tidy(units[k].back(x)));
  };
  return {
    label: `table: ${names.join(", ")}`, text: lines.join("\n"), rows: rowsFor(count),
    put: (text) => {
      const rows = linesOf(text).map(read);
      return Object.fromEntries(keys.map((key, k) => [key, rows.map((row) => row[k])]));
    },
  };
}

/** A number without what rounding left in its last digits when its units were changed. */
function tidy(x) {
  return Number(x.toPrecision(12));
}

function rowsFor(count) {
  return Math.min(MOST_ROWS, count + 1);
}

function linesOf(text) {
  return text.split("\n").filter((line) => line.trim());
}
