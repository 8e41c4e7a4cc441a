// The history: the observed quantity, the energy, and the error of both, against time.

import { messageOf } from "../engine/messages.js";
import { card, keyEntry, putText, segments, showKey } from "./card.js";
import { determinedCount, firstAfter, observableError, refined } from "./curves.js";
import { errorText, numberText } from "./numbers.js";
import { createPlot } from "./plot.js";
import { VISIBLE_ERROR } from "./scene.js";
import { symbolText } from "./symbols.js";
import { colours } from "./theme.js";
import { placeTip } from "./tip.js";
import { TIME, conversion, converted, timeText, titleOf } from "./units.js";

/** Time that is shown at first, in units of tau. */
const SHOWN_TIME = 100;

/**
 * The view of the history.
 * @param {Object} app
 * @returns {{node: HTMLElement, draw: function(Object): void, mark: function(Object): void, figure: function(): Object}}
 */
export function historyView(app) {
  const spans = segments("part of the run", [
    { value: "start", text: "Begin" }, { value: "end", text: "End" }, { value: "all", text: "All" },
  ], () => app.store.get().span, (span) => app.changeView({ span }));
  const view = card({ id: "history", title: "History", tools: [spans.node], save: () => app.save("history") });
  let seen = null;
  const plot = createPlot(view.body, {
    label: "History of the motion. Arrow keys move along it, plus and minus zoom, 0 shows all.",
    panels: [{ id: "y", share: 0.56 }, { id: "energy", share: 0.24 }, { id: "error", share: 0.2, logarithmic: true }],
    hover: (place) => tell(plot, seen, place),
    speak: (place) => app.say(words(seen, place)),
    refresh: () => seen && draw(seen),
  });
  let shownSpan = null;
  const draw = (scene) => {
    const span = app.store.get().span;
    if (span !== shownSpan) {
      shownSpan = span;
      plot.zoom = {};
    }
    spans.show();
    seen = { ...scene, span, ...layersOf(scene, span, plot.zoom.x) };
    plot.show(seen.content);
    showKey(view.key, seen.key);
    putText(view.note, messageOf(scene.motion, (t) => timeText(t, scene.factors)));
  };
  return {
    node: view.node, plot, draw,
    mark: (instant) => plot.moveMarks(instant ? marksOf(seen, instant) : []),
    figure: () => ({ plot, name: "history", title: "History" }),
  };
}

function windowOf(motion, span, period) {
  const last = motion.t[motion.t.length - 1] || 1;
  const width = Math.min(last, Math.max(SHOWN_TIME, 8 * (period || 0)));
  return { start: [0, width], end: [last - width, last], all: [0, last] }[span];
}

function layersOf(scene, span, zoom) {
  const { motion, field, values, description, factors, colour, watched, energy } = scene;
  const theme = colours();
  const time = conversion("time", factors);
  const [low, high] = windowOf(motion, span, scene.period);
  const range = zoom ? zoom.map(time.back) : [low, high];
  const from = Math.max(0, firstAfter(motion.t, range[0]) - 1);
  const to = Math.min(motion.t.length - 1, firstAfter(motion.t, range[1]));
  const parts = Math.max(1, Math.min(8, Math.floor(2400 / Math.max(1, to - from))));
  const curve = motion.t.length ? refined(field, motion, values, { from, to, parts }) : { t: [], observables: [] };
  const t = converted(curve.t, "time", factors);
  const end = determinedCount(motion);
  const split = end >= motion.t.length ? t.length : firstAfter(curve.t, motion.determinedUntil);
  const quantity = (k) => converted(curve.observables[k] ?? [], description.observables[k].name, factors);
  const line = (y, look) => ({ kind: "line", monotonic: true, x: t, y, ...look });
  const parted = (y, look) => split >= t.length ? [line(y, look)] : [
    { ...line(y, look), x: t.slice(0, split), y: y.slice(0, split) },
    { ...line(y, look), x: t.slice(split), y: y.slice(split), colour: theme.missing, dash: "dotted", name: "not determined" },
  ];
  const unknown = split < t.length
    ? [{ kind: "region", from: t[Math.min(split, t.length - 1)], to: Infinity, name: "not determined" }] : [];
  const y = quantity(watched);
  const errors = motion.error.subarray(from, to + 1);
  const errorT = converted(motion.t.subarray(from, to + 1), "time", factors);
  const known = errors.map((x) => (x > 0 ? x : NaN));
  const bandError = curve.t.length ? bandOf(scene, Float64Array.from(y), from, parts) : null;
  return {
    curve, t, y,
    content: {
      x: { title: titleOf(TIME, factors), range: [time.to(low), time.to(high)] },
      panels: [
        { title: titleOf(description.observables[watched], factors), layers: [
          ...unknown,
          ...(bandError ? [{ kind: "band", fit: false, x: t, low: bandError.low, high: bandError.high, colour: theme.veil }] : []),
          ...parted(y, { colour, width: 1.4, name: description.observables[watched].text }),
        ] },
        { title: { text: "energy", symbol: energy >= 0 ? description.observables[energy].symbol : "", unit: titleOf({ name: "energy", unit: "1", text: "", symbol: "" }, factors).unit },
          layers: energy >= 0 ? [...unknown.map(bare), ...parted(quantity(energy), { colour: theme.green, width: 1.2, name: "energy" })]
            : [{ kind: "note", text: "no energy is defined for this system" }] },
        { title: { text: "error", symbol: "", unit: "" }, layers: [
          ...unknown.map(bare),
          { kind: "line", monotonic: true, x: errorT, y: known, colour: theme.faint, width: 1.2, name: "stated error" },
        ] },
      ],
    },
    key: [
      ...(split < t.length ? [keyEntry("not determined", theme.missing, { dash: "dotted" })] : []),
      keyEntry(symbolText(description.observables[watched].symbol), colour),
      ...(energy >= 0 ? [keyEntry("energy", theme.green)] : []),
      keyEntry("error", theme.faint),
    ],
  };
}

function bare(layer) {
  return { ...layer, name: "" };
}

/** The error around the curve, where it is large enough to be seen. */
function bandOf(scene, y, from, parts) {
  const { motion, watched, description, factors } = scene;
  const rows = Math.ceil((y.length - 1) / parts);
  if (!(motion.error[from + rows] > VISIBLE_ERROR)) {
    return null;
  }
  const { to } = conversion(description.observables[watched].name, factors);
  const unit = Math.abs(to(1) - to(0));
  const errors = Float64Array.from({ length: rows + 1 }, (_, k) => unit * observableError(scene, from + k, watched));
  const at = (i) => errors[Math.min(rows, Math.ceil(i / parts))];
  return { low: y.map((value, i) => value - at(i)), high: y.map((value, i) => value + at(i)) };
}

function nearest(seen, time) {
  const { t } = seen;
  const k = Math.min(t.length - 1, Math.max(0, firstAfter(t, time)));
  return k > 0 && time - t[k - 1] < t[k] - time ? k - 1 : k;
}

function words(seen, place) {
  if (!seen || !place || !seen.t.length) {
    return "";
  }
  const k = nearest(seen, place.x);
  const { description, watched, motion, factors } = seen;
  const row = Math.min(motion.t.length - 1, firstAfter(motion.t, seen.curve.t[k]));
  const { to } = conversion(description.observables[watched].name, factors);
  const error = Math.abs(to(observableError(seen, row, watched)) - to(0));
  const symbol = symbolText(description.observables[watched].symbol);
  return `${timeText(seen.curve.t[k], factors, 5)}, ${symbol} = ${numberText(seen.y[k], 6)} ± ${errorText(error)}`;
}

function tell(plot, seen, place) {
  const text = words(seen, place);
  placeTip(plot, text, place);
}

/** The instant of the animation in the history. */
function marksOf(seen, instant) {
  if (!seen?.t.length) {
    return [];
  }
  const time = conversion("time", seen.factors).to(instant.t);
  const { watched, description, factors, colour } = seen;
  const value = conversion(description.observables[watched].name, factors).to(instant.observables[watched]);
  return [
    { kind: "vertical", x: time, colour: colours().faint },
    { kind: "dot", panel: 0, x: time, y: value, colour },
  ];
}
