// The chart of a store: a quantity over two dimensions of its grid, or a curve over one.

import { ask, onConnection, send } from "./api.js";
import { card, showKey } from "./card.js";
import { element, menu } from "./dom.js";
import { categoryFigure, cellText, drawFigure, layoutOf, numberFigure, regimeCategory } from "./heat.js";
import { numberText } from "./numbers.js";
import { symbolText } from "./symbols.js";
import { colours, onTheme } from "./theme.js";
import { unitText } from "./units.js";

/**
 * The view of a store.
 * @param {Object} app
 * @param {{title: string}} store
 * @returns {{node: HTMLElement, load: function(): Promise<void>, figure: function(): Object}}
 */
export function storeView(app, store) {
  const view = card({ id: "store", title: `Study: ${store.title}`, save: () => app.save("store") });
  const host = element("div", { class: "plotly-host" });
  view.body.append(host);
  const seen = { chart: null, variable: null, axes: null, places: {}, figure: null, index: null };
  const paint = () => {
    if (seen.chart) {
      seen.figure = figureOf(seen);
      showKey(view.key, seen.figure.key);
      drawFigure(host, seen.figure, pick, app.say);
    }
  };
  const pick = async (i, j) => {
    const { dims } = seen.chart;
    const index = dims.map(({ name }) => (name === seen.axes[0] ? i : name === seen.axes[1] ? j : (seen.places[name] ?? 0)));
    try {
      const { spec } = await send("/api/store/point", { index });
      seen.index = index;
      paint();
      await app.chooseSpec(spec);
      tell(noteOf(seen.chart));
      app.say(`Motion of the point ${pointText(seen.chart, index)}.`);
    } catch (error) {
      tell(error.message, true);
    }
  };
  const tell = (words, isBad = false) => {
    view.note.textContent = words;
    view.note.classList.toggle("bad", isBad);
  };
  const load = async () => {
    try {
      seen.chart = await ask("/api/store");
    } catch (error) {
      tell(error.message, true);
      return;
    }
    const { chart } = seen;
    seen.axes = axesOf(chart);
    [seen.variable] = orderedVariables(chart);
    view.tools.prepend(...tools(seen, paint));
    tell(noteOf(chart));
    paint();
  };
  onTheme(paint);
  onConnection((isThere) => {
    if (isThere && seen.chart) {
      tell(noteOf(seen.chart));
    } else if (isThere) {
      load();
    }
  });
  return { node: view.node, load, figure: () => ({ plotly: seen.figure, name: "study", title: store.title }) };
}

function axesOf({ dims }) {
  const names = dims.filter(({ size }) => size > 1).map(({ name }) => name);
  const all = names.length ? names : dims.map(({ name }) => name);
  const x = all.includes("omega") ? "omega" : all[all.length - 1];
  return [x, all.find((name) => name !== x) ?? null];
}

/** What a reader wants to see first; what says how well something is known comes last. */
const LIKED = ["regime", "amplitude", "resonance", "exponent", "stability", "thickness_stretch", "stretch"];
const LATER = /_error$|^(period|margin|horizon|tolerance|local_error|defect|digits|rotation_digits|reason)$/;

function rankOf(name) {
  const place = LIKED.indexOf(name);
  return place >= 0 ? place : LIKED.length + (LATER.test(name) ? 1 : 0);
}

/** The names of the variables, what is liked best before the rest. */
function orderedVariables({ variables }) {
  return Object.keys(variables).sort((a, b) => rankOf(a) - rankOf(b));
}

function tools(seen, paint) {
  const { chart } = seen;
  const names = orderedVariables(chart).map((value) => ({ value, text: chart.variables[value].text || value }));
  const items = [menu(names, seen.variable, (name) => { seen.variable = name; paint(); }, { "aria-label": "quantity of the chart" })];
  for (const { name, size } of chart.dims) {
    if (size > 1 && !seen.axes.includes(name)) {
      const values = chart.coords[name].values;
      const label = symbolText(chart.coords[name].symbol || name);
      const choices = values.map((value, k) => ({ value: String(k), text: `${label} = ${typeof value === "number" ? numberText(value, 4) : value}` }));
      items.push(menu(choices, "0", (k) => { seen.places[name] = Number(k); paint(); }, { "aria-label": `value of ${name}` }));
    }
  }
  return items;
}

/** The value of a variable at places of its dimensions. */
function valueAt(variable, places) {
  return variable.dims.reduce((values, dim) => values?.[places[dim] ?? 0], variable.values) ?? null;
}

function figureOf({ chart, variable: name, axes, places, index }) {
  const [xDim, yDim] = axes;
  const variable = chart.variables[name];
  const coordinate = (dim) => (dim && chart.coords[dim] ? chart.coords[dim] : { values: [0], text: "", symbol: "", unit: "" });
  const axis = (dim) => {
    const { values, text, symbol, unit } = coordinate(dim);
    return { values: values.every((one) => typeof one === "number") ? values : values.map((_, k) => k), title: { text: text || dim || "", symbol, unit: unitText({ name: dim ?? "", unit }, null) } };
  };
  const [x, y] = [axis(xDim), axis(yDim)];
  const at = (j, i) => ({ ...places, [xDim]: i, ...(yDim ? { [yDim]: j } : {}) });
  const rows = y.values.map((_, j) => x.values.map((__, i) => valueAt(variable, at(j, i))));
  const texts = rows.map((row, j) => row.map((value, i) => cellText([
    [xDim, coordinate(xDim).values[i]], ...(yDim ? [[yDim, coordinate(yDim).values[j]]] : []),
    [variable.text || name, value], ["status", valueAt(chart.status, at(j, i))],
  ])));
  const here = index && { x: x.values[index[chart.dims.findIndex((one) => one.name === xDim)]], y: y.values[yDim ? index[chart.dims.findIndex((one) => one.name === yDim)] : 0] };
  const title = { text: variable.text || name, symbol: variable.symbol, unit: variable.unit };
  if (!yDim) {
    return curve(x, rows[0], title, texts[0], here);
  }
  if (rows.flat().some((value) => typeof value === "string")) {
    const period = chart.variables.period;
    const cells = rows.map((row, j) => row.map((value, i) => wordCategory(name, value, period && valueAt(period, at(j, i)), rows)));
    return categoryFigure({ x, y, cells, texts, here });
  }
  return numberFigure({ x, y, z: rows.map((row) => row.map((value) => (typeof value === "boolean" ? Number(value) : value))), title, texts, here });
}

function wordCategory(name, value, period, rows) {
  if (name === "regime") {
    return regimeCategory(value, period);
  }
  const words = [...new Set(rows.flat())].sort();
  const palette = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442"];
  const k = words.indexOf(value);
  return { name: value === null || value === "" ? "no result" : value, colour: palette[k % palette.length], hatched: value === null, order: k };
}

function curve(x, y, title, texts, here) {
  const theme = colours();
  const line = { type: "scatter", mode: "lines+markers", x: x.values, y, text: texts, hoverinfo: "text", line: { color: theme.blue, width: 1.5 }, marker: { size: 5 } };
  const k = here ? x.values.indexOf(here.x) : -1;
  const place = k >= 0 ? [{ type: "scatter", mode: "markers", x: [here.x], y: [y[k]], hoverinfo: "skip", marker: { symbol: "circle-open", size: 13, color: theme.ink, line: { width: 3 } } }] : [];
  return { data: [line, ...place], layout: layoutOf(x, { title }), key: [] };
}

function pointText(chart, index) {
  return chart.dims.map(({ name }, k) => {
    const value = chart.coords[name]?.values[index[k]];
    return `${name} ${typeof value === "number" ? numberText(value, 4) : (value ?? index[k])}`;
  }).join(", ");
}

function noteOf(chart) {
  const words = [chart.status.values].flat(Infinity);
  const lost = words.filter((word) => word !== "ok");
  const counts = [...new Set(lost)].map((word) => `${lost.filter((one) => one === word).length} ${word}`);
  return `${chart.verb}, ${words.length} points${counts.length ? `, of which ${counts.join(", ")}` : ", all with status ok"}. Click a point to see its motion.`;
}
