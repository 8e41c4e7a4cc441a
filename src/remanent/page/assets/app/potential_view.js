// The potential along the coordinate, at the loads between which it moves, with equilibria.

import { potential } from "../engine/potential.js";
import { card, keyEntry, putText, showKey } from "./card.js";
import { extent, numberText } from "./numbers.js";
import { createPlot } from "./plot.js";
import { symbolText } from "./symbols.js";
import { colours, numberColour } from "./theme.js";
import { placeTip } from "./tip.js";
import { conversion, converted, titleOf } from "./units.js";

/**
 * The view of the potential.
 * @param {Object} app
 * @returns {Object} with `node`, `draw`, `mark`, `figure`
 */
export function potentialView(app) {
  const view = card({ id: "potential", title: "Potential", save: () => app.save("potential") });
  let seen = null;
  const plot = createPlot(view.body, {
    label: "Potential energy along the stretch, with its equilibria. Click to start at rest there; or move the cross with the arrow keys and press Enter.",
    panels: [{ id: "y", share: 1 }],
    pick: (x) => startAtRest(app, seen, x),
    hover: (place) => placeTip(plot, place && seen?.landscape ? words(seen, place) : "", place),
    speak: (place) => app.say(words(seen, place)),
    refresh: () => seen && draw(seen),
  });
  const draw = (scene) => {
    const landscape = potential(scene.field, { description: scene.description, parameters: scene.values, initial: scene.initial, ...intervalOf(scene) });
    seen = { ...scene, landscape };
    view.node.hidden = landscape === null;
    if (landscape) {
      plot.show(contentOf(seen));
      showKey(view.key, keyOf(seen));
      putText(view.note, noteOf(seen));
    }
  };
  return {
    node: view.node, plot, draw,
    mark: (instant) => plot.moveMarks(instant && seen?.landscape ? [ballOf(seen, instant)] : []),
    figure: () => ({ plot, name: "potential", title: "Potential" }),
  };
}

/** Where the coordinate goes, and a good part more, in round numbers. */
function intervalOf({ motion, description }) {
  const k = description.state.findIndex((one) => one.role === "coordinate");
  if (k < 0) {
    return {};
  }
  const [low, high] = extent(motion.y[k]);
  const margin = Math.max(0.6 * (high - low), 0.25);
  const round = (x, to) => to(x * 10) / 10;
  const { positive } = description.state[k];
  return { low: positive ? Math.max(0.35 * low, round(low - margin, Math.floor), 0.05) : round(low - 2 * margin, Math.floor), high: round(high + (positive ? 1 : 2) * margin, Math.ceil) };
}

function loadName({ factors }, load) {
  const { to, unit } = conversion("load", factors);
  return `${unit ? "B" : "m"} = ${numberText(to(load), 3)}${unit ? ` ${unit}` : ""}`;
}

function look(curve, curves) {
  const loads = curves.map((one) => one.load);
  const [low, high] = extent(loads);
  return numberColour(high > low ? 0.85 * ((curve.load - low) / (high - low)) : 0.3);
}

function contentOf(seen) {
  const { landscape, description, factors, energy, motion, watched } = seen;
  const theme = colours();
  const unit = conversion("energy", factors);
  const name = description.observables[watched].name;
  const x = converted(landscape.observable, name, factors);
  const layers = landscape.curves.map((curve) => ({
    kind: "line", x, y: Float64Array.from(curve.energy, unit.to), colour: look(curve, landscape.curves), width: 1.6, fit: false, name: loadName(seen, curve.load),
  }));
  for (const [stable, symbol, title] of [[true, "dot", "stable equilibrium"], [false, "ring", "unstable equilibrium"]]) {
    const chosen = landscape.curves.flatMap((curve) => curve.equilibria.filter((one) => one.stable === stable));
    if (chosen.length) {
      layers.push({
        kind: "points", symbol, size: 3.8, colour: theme.ink, width: 1.6, name: title, fit: false,
        x: chosen.map((one) => conversion(name, factors).to(one.observable)), y: chosen.map((one) => unit.to(one.energy)),
      });
    }
  }
  const [low, high] = extent(x);
  const [seenLow, seenHigh] = extent(converted(motion.observables[watched], name, factors));
  const margin = Math.max(0.3 * (seenHigh - seenLow), 0.1);
  const equilibria = landscape.curves.flatMap((curve) => curve.equilibria.map((one) => one.observable)).filter((one) => one > low && one < high);
  const [restLow, restHigh] = extent(equilibria);
  const range = [Math.max(low, Math.min(seenLow - margin, restLow - 0.3 * margin || Infinity)), Math.min(high, Math.max(seenHigh + margin, restHigh + 0.3 * margin || -Infinity))];
  const heights = landscape.curves.flatMap((curve) => Array.from(curve.energy).filter((_, k) => x[k] >= range[0] && x[k] <= range[1]));
  const [bottom] = extent(heights);
  const [, top] = extent(energy >= 0 ? motion.observables[energy] : heights, landscape.curves.flatMap((curve) => curve.equilibria.map((one) => one.energy)));
  const [, highest] = extent(heights);
  const ceiling = Math.min(highest, Math.max(top, bottom + 0.05) + 0.45 * (Math.max(top, bottom + 0.05) - bottom));
  const frame = [[range[0], range[1]], [bottom, ceiling].map(unit.to)];
  return {
    x: { title: titleOf(description.observables[watched], factors) },
    panels: [{ title: { text: "potential energy", symbol: "V", unit: unit.unit ?? "" }, layers: [...layers, { kind: "points", x: frame[0], y: frame[1], colour: "transparent", size: 0, name: "" }] }],
  };
}

function keyOf(seen) {
  const { curves } = seen.landscape;
  const theme = colours();
  const kinds = new Set(curves.flatMap((curve) => curve.equilibria.map((one) => one.stable)));
  return [
    ...curves.map((curve) => keyEntry(loadName(seen, curve.load), look(curve, curves))),
    ...(kinds.has(true) ? [keyEntry("stable", theme.ink, { symbol: "dot" })] : []),
    ...(kinds.has(false) ? [keyEntry("unstable", theme.ink, { symbol: "ring" })] : []),
  ];
}

function noteOf({ landscape, description, watched }) {
  const symbol = symbolText(description.observables[watched].symbol);
  const places = landscape.curves[0].equilibria.map((one) => `${symbol} = ${numberText(Math.abs(one.observable) < 1e-9 ? 0 : one.observable, 4)}${one.stable ? "" : " (unstable)"}`);
  if (!places.length) {
    return "No equilibrium in this range.";
  }
  const load = landscape.curves[0].load === 0 ? "without load" : "at the load nearest to 0";
  const warms = description.state.some((one) => one.role === "temperature");
  return `Equilibria ${load}${warms ? ", at the temperature of the start" : ""}: ${places.join(", ")}.`;
}

function words(seen, place) {
  const { description, watched } = seen;
  return `${symbolText(description.observables[watched].symbol)} = ${numberText(place.x, 4)}, V = ${numberText(place.y, 4)}`;
}

function startAtRest(app, seen, x) {
  const { landscape, description, watched, factors } = seen;
  const wanted = conversion(description.observables[watched].name, factors).back(x);
  const nearest = landscape.observable.reduce((best, value, k) => (Math.abs(value - wanted) < Math.abs(landscape.observable[best] - wanted) ? k : best), 0);
  const start = Array.from(app.store.get().initial);
  description.state.forEach(({ role, name }, k) => {
    if (name === landscape.coordinate || role === "internal") {
      start[k] = Number(landscape.x[nearest].toPrecision(4));
    } else if (role === "rate") {
      start[k] = 0;
    }
  });
  app.startAt(start);
}

/** The place of the motion on the potential at the load of the instant. */
function ballOf({ field, values, description, factors, watched, energy, colour }, { t, y }) {
  const still = Float64Array.from(y, (value, k) => (description.state[k].role === "rate" ? 0 : value));
  const out = new Float64Array(field.observable_names.length);
  field.observables(t, still, values, out);
  return { kind: "dot", panel: 0, x: conversion(description.observables[watched].name, factors).to(out[watched]), y: conversion("energy", factors).to(out[energy]), colour };
}
