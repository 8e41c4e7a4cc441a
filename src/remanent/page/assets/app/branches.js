// Branches of periodic response: what is stable is solid, what is not is dashed.

import { keyEntry } from "./card.js";
import { errorText } from "./numbers.js";
import { converted } from "./units.js";

const LOOKS = {
  stable: { dash: "solid", width: 2 },
  elliptic: { dash: "double", width: 3 },
  unstable: { dash: "dashed", width: 1.3 },
  saddle: { dash: "dashed", width: 1.3 },
};
const MARKS = { fold: "ring", "period doubling": "square", "branch point": "diamond" };

/**
 * Layers of all branches of a diagram.
 * @param {?Object} diagram result of the job `response_diagram`
 * @param {?Object} factors
 * @param {Object} theme
 * @returns {Array<Object>}
 */
export function branchLayers(diagram, factors, theme) {
  if (!diagram) {
    return [];
  }
  const layers = diagram.series.flatMap((one) => pieces(one, factors, theme));
  const special = diagram.special ?? {};
  const kinds = special.special_kind?.values ?? [];
  for (const kind of new Set(kinds.filter(Boolean))) {
    const chosen = kinds.flatMap((one, k) => (one === kind ? [k] : []));
    layers.push({
      kind: "points", symbol: MARKS[kind] ?? "diamond", colour: theme.purple, size: 3.6, width: 1.4, name: kind.replace(/_/g, " "),
      x: converted(chosen.map((k) => special.special_omega.values[k] ?? NaN), "omega", factors),
      y: chosen.map((k) => special.special_amplitude?.values[k] ?? NaN),
    });
  }
  return layers;
}

/** One line for each part of a branch with the same stability; neighbours share a point. */
function pieces(branch, factors, theme) {
  const omega = converted(branch.omega.values.map((x) => x ?? NaN), "omega", factors);
  const amplitude = branch.amplitude.values.map((x) => x ?? NaN);
  const words = branch.stability.values;
  const layers = [];
  let from = 0;
  for (let k = 1; k <= words.length; k += 1) {
    if (k === words.length || words[k] !== words[from]) {
      const end = Math.min(k + 1, words.length);
      const { dash, width } = LOOKS[words[from]] ?? { dash: "dotted", width: 1 };
      const line = { kind: "line", x: omega.slice(from, end), y: amplitude.slice(from, end), colour: theme.ink, width, name: words[from] };
      layers.push({ ...line, dash: dash === "double" ? "solid" : dash });
      if (dash === "double") {
        layers.push({ ...line, colour: theme.ground, width: 1, name: "" });
      }
      from = k;
    }
  }
  return layers;
}

/**
 * The legend of a diagram: what line is stable and what is not, and its special points.
 * @param {?Object} diagram
 * @param {Object} theme
 * @returns {Array<Object>}
 */
export function branchKey(diagram, theme) {
  if (!diagram) {
    return [];
  }
  const kinds = new Set(diagram.series.flatMap((one) => one.stability.values));
  const lines = Object.entries(LOOKS).filter(([kind]) => kinds.has(kind)).map(([kind, { dash }]) => keyEntry(kind, theme.ink, { dash }));
  const special = [...new Set((diagram.special?.special_kind?.values ?? []).filter(Boolean))];
  return [...lines, ...special.map((kind) => keyEntry(kind.replace(/_/g, " "), theme.purple, { symbol: MARKS[kind] ?? "diamond" }))];
}

/**
 * What there is to say of a diagram.
 * @param {Object} diagram
 * @returns {string}
 */
export function branchNote({ series, special, reason, status }) {
  const kinds = special?.special_kind?.values?.filter(Boolean) ?? [];
  const counts = [...new Set(kinds)].map((kind) => {
    const count = kinds.filter((one) => one === kind).length;
    return `${count} ${kind.replace(/_/g, " ")}${count === 1 ? "" : "s"}`;
  });
  const errors = series.flatMap((one) => one.error.values).filter((x) => x !== null);
  const parts = [`${series.length} ${series.length === 1 ? "branch" : "branches"} of periodic response`];
  if (counts.length) {
    parts.push(counts.join(", "));
  }
  if (errors.length) {
    parts.push(`error of amplitudes ≤ ${errorText(Math.max(...errors))}`);
  }
  if (status && status !== "ok") {
    parts.push(`${[status].flat().filter((one) => one !== "ok").join(", ")}${reason ? `: ${reason}` : ""}`);
  }
  return `${parts.join("; ")}.`;
}
