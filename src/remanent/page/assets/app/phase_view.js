// The phase plane, with the Poincare section on top of it.

import { card, keyEntry, putText, showKey } from "./card.js";
import { determinedCount, refined, stateAt } from "./curves.js";
import { numberText } from "./numbers.js";
import { createPlot } from "./plot.js";
import { symbolText } from "./symbols.js";
import { colours } from "./theme.js";
import { placeTip } from "./tip.js";
import { conversion, converted, titleOf } from "./units.js";

/** Points of the curve that are drawn at most; of a longer run its begin and its end are shown. */
const MOST_POINTS = 6000;
/** Points in a period, at least, for a curve that looks smooth. */
const LEAST_POINTS_A_PERIOD = 48;
/** Share of the points that the begin takes. */
const BEGIN_SHARE = 0.25;

/**
 * The view of the phase plane.
 * @param {Object} app
 * @returns {Object} with `node`, `draw`, `mark`, `figure`
 */
export function phaseView(app) {
  const view = card({ id: "phase", title: "Phase plane and Poincaré section", save: () => app.save("phase") });
  let seen = null;
  const back = (x, y) => {
    const [a, b] = seen.axes.map((k) => conversion(seen.description.observables[k].name, seen.factors));
    return [a.back(x), b.back(y)];
  };
  const plot = createPlot(view.body, {
    label: "Phase plane with the Poincaré section. Click to start an orbit there; or move the cross with the arrow keys and press Enter.",
    panels: [{ id: "y", share: 1 }],
    pick: (x, y) => startAt(app, seen, back(x, y)),
    hover: (place) => placeTip(plot, place ? words(seen, place) : "", place),
    speak: (place) => app.say(words(seen, place)),
    refresh: () => seen && draw(seen),
  });
  const draw = (scene) => {
    seen = { ...scene, ...layersOf(scene) };
    plot.show(seen.content);
    showKey(view.key, seen.key);
    putText(view.note, seen.note);
  };
  return {
    node: view.node, plot, draw,
    mark: (instant) => plot.moveMarks(instant && seen ? [markOf(seen, instant)] : []),
    figure: () => ({ plot, name: "phase_plane", title: "Phase plane and Poincaré section" }),
  };
}

function layersOf(scene) {
  const { motion, field, values, description, factors, colour, axes } = scene;
  const theme = colours();
  const [a, b] = axes;
  const names = axes.map((k) => description.observables[k].name);
  const end = determinedCount(motion);
  const pieces = piecesOf(motion, end);
  const turns = pieces.reduce((sum, { from, to }) => sum + (motion.t[to] - motion.t[from]) / (scene.period || 6), 0) || 1;
  const section = motion.section.observables;
  const time = motion.section.t;
  const inside = Array.from(time, (t) => !(t > motion.determinedUntil));
  const pick = (k, wanted) => converted(section[k].filter((_, i) => inside[i] === wanted), description.observables[k].name, factors);
  const dots = { kind: "points", x: pick(a, true), y: pick(b, true), colour: theme.ink, size: dotSize(time.length), name: "Poincaré section" };
  const lost = { ...dots, x: pick(a, false), y: pick(b, false), colour: theme.missing, symbol: "ring", size: 1.6, width: 0.8, name: "section, not determined" };
  const lines = pieces.map((span) => {
    const { observables } = span.parts > 1 ? refined(field, motion, values, span) : raw(motion, span);
    const [x, y] = axes.map((k, i) => converted(observables[k], names[i], factors));
    const faint = Math.max(0.35, Math.min(1, 14 / turns));
    return { kind: "line", colour, name: span.name, x, y, width: turns > 60 ? 0.7 : 1.1, alpha: faint };
  });
  const start = {
    kind: "points", symbol: "cross", colour: scene.here, size: 4, width: 1.6, name: "start", ...startOf(scene, names),
  };
  const lostCount = lost.x.length;
  return {
    content: {
      x: { title: titleOf(description.observables[a], factors) },
      panels: [{ title: titleOf(description.observables[b], factors), layers: [...lines, ...(lostCount ? [lost] : []), dots, start] }],
    },
    key: [
      keyEntry("orbit", colour), ...(time.length ? [keyEntry("section", theme.ink, { symbol: "dot" })] : []),
      ...(lostCount ? [keyEntry("not determined", theme.missing, { symbol: "ring" })] : []),
      keyEntry("start", scene.here, { symbol: "cross" }),
    ],
    note: time.length ? noteOf(dots.x.length, lostCount, pieces.length > 1) : "The load has no period, so there is no section at its phase.",
  };
}

/** Pieces of each step; without a period as many as there is room for. */
function partsOf({ period, statesPerPeriod }, last) {
  if (!(period > 0)) {
    return Math.min(6, Math.max(1, Math.floor(MOST_POINTS / Math.max(1, last))));
  }
  return Math.max(1, Math.ceil(LEAST_POINTS_A_PERIOD / statesPerPeriod));
}

/** Spans of samples that are drawn, each with the pieces that its steps are cut into. */
function piecesOf(motion, end) {
  const last = Math.max(0, end - 1);
  const parts = partsOf(motion, last);
  const most = Math.floor(MOST_POINTS / parts);
  if (last <= most) {
    return [{ from: 0, to: last, parts, name: "orbit" }];
  }
  const begin = Math.floor(BEGIN_SHARE * most);
  return [{ from: 0, to: begin, parts, name: "orbit, begin" }, { from: last - most + begin, to: last, parts, name: "orbit, end" }];
}

function raw(motion, { from, to }) {
  return { observables: motion.observables.map((column) => column.subarray(from, to + 1)) };
}

function startOf({ motion, field, values, factors, axes }, names) {
  const out = new Float64Array(field.observable_names.length);
  field.observables(0, Float64Array.from(motion.y, (column) => column[0]), values, out);
  const [x, y] = axes.map((k, i) => [conversion(names[i], factors).to(out[k])]);
  return { x, y };
}

function dotSize(count) {
  return count > 400 ? 1.5 : count > 150 ? 1.8 : 2.3;
}

function noteOf(known, lost, cut) {
  const parts = [`Section at phase 0: ${known} points`];
  if (lost) {
    parts.push(`${lost} more are not determined`);
  }
  if (cut) {
    parts.push("of the orbit the begin and the end are drawn");
  }
  return `${parts.join("; ")}. Click to start an orbit there.`;
}

function words(seen, place) {
  if (!seen || !place) {
    return "";
  }
  const [a, b] = seen.axes.map((k) => seen.description.observables[k]);
  return `${symbolText(a.symbol)} = ${numberText(place.x, 4)}, ${symbolText(b.symbol)} = ${numberText(place.y, 4)}`;
}

function startAt(app, seen, wanted) {
  const { field, description, values, axes } = seen;
  const state = stateAt(field, description, values, app.store.get().initial, wanted, axes);
  if (state) {
    app.startAt(Array.from(state, (x) => Number(x.toPrecision(6))));
  } else {
    app.say("No orbit starts there: the state is beyond the limits of the model.", true);
  }
}

function markOf(seen, instant) {
  const [x, y] = seen.axes.map((k) => conversion(seen.description.observables[k].name, seen.factors).to(instant.observables[k]));
  return { kind: "dot", panel: 0, x, y, colour: seen.colour };
}
