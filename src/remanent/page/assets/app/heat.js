// Charts over two quantities, drawn by plotly.js: categories or numbers in cells.

import { keyEntry } from "./card.js";
import { plotly } from "./charts_library.js";
import { numberText } from "./numbers.js";
import { REGIME_COLOURS, colours } from "./theme.js";
import { FONT_FAMILY, harmless, titleForPlotly } from "./titles.js";

const PERIODS = REGIME_COLOURS.periods;
const BLACKISH = "#101018";

/**
 * What a cell of regimes is called, and its colour.
 * @param {?string} regime
 * @param {?number} period
 * @returns {{name: string, colour: string, hatched: boolean, order: number}}
 */
export function regimeCategory(regime, period) {
  if (regime === "periodic" && period > 0) {
    const k = Math.min(period, PERIODS.length);
    const name = k < PERIODS.length ? `period ${k}` : `period ≥ ${PERIODS.length}`;
    return { name, colour: PERIODS[k - 1], hatched: false, order: k };
  }
  if (regime === "quasi-periodic" || regime === "chaotic") {
    return { name: regime, colour: REGIME_COLOURS[regime], hatched: false, order: regime === "chaotic" ? 21 : 20 };
  }
  if (regime === "escaped") {
    return { name: "escaped", colour: BLACKISH, hatched: false, order: 30 };
  }
  const name = regime === "undecided" ? "undecided" : regime === "periodic" ? "periodic" : "no result";
  return { name, colour: regime === "periodic" ? PERIODS[0] : REGIME_COLOURS.undecided, hatched: regime !== "periodic", order: 40 };
}

/**
 * A figure of categories.
 * @param {{x: Object, y: Object, cells: Array<Array<Object>>, texts: Array<Array<string>>,
 *   here: ?{x: number, y: number}}} chart
 *   x, y: `values` and `title`; cells: categories, a row for each y
 * @returns {{data: Array<Object>, layout: Object, key: Array<HTMLElement>}}
 */
export function categoryFigure({ x, y, cells, texts, here }) {
  const known = new Map();
  cells.flat().forEach((cell) => known.set(cell.name, cell));
  const list = [...known.values()].sort((a, b) => a.order - b.order);
  const index = new Map(list.map((cell, k) => [cell.name, k]));
  const count = list.length;
  const scale = list.flatMap(({ colour }, k) => [[k / count, colour], [(k + 1) / count, colour]]);
  const heat = {
    type: "heatmap", x: x.values, y: y.values, z: cells.map((row) => row.map((cell) => index.get(cell.name))),
    zmin: -0.5, zmax: count - 0.5, colorscale: scale, showscale: false, text: texts, hoverinfo: "text", xgap: 0, ygap: 0,
  };
  return {
    data: [heat, ...hatching(x, y, cells), ...placeHere(here)],
    layout: chartLayout(x, y),
    key: list.map(({ name, colour, hatched }) => keyEntry(name, colour, { symbol: hatched ? "hatch" : "patch" })),
  };
}

/** The layout of a chart, whose axes end where its cells end. */
function chartLayout(x, y) {
  const layout = layoutOf(x, y);
  layout.xaxis.range = endsOf(x.values);
  layout.yaxis.range = endsOf(y.values);
  return layout;
}

function endsOf(values) {
  if (values.length < 2) {
    return [values[0] - 0.5, values[0] + 0.5];
  }
  const last = values.length - 1;
  return [values[0] - (values[1] - values[0]) / 2, values[last] + (values[last] - values[last - 1]) / 2];
}

/** Strokes over the cells that say nothing, so that grey is not the only sign. */
function hatching(x, y, cells) {
  const [px, py] = [[], []];
  cells.forEach((row, j) => row.forEach((cell, i) => {
    if (cell.hatched) {
      px.push(x.values[i]);
      py.push(y.values[j]);
    }
  }));
  return px.length ? [{
    type: "scatter", mode: "markers", x: px, y: py, hoverinfo: "skip", showlegend: false, name: "undecided",
    marker: { symbol: "line-ne-open", size: 5, color: "#4d4d4d", line: { width: 1, color: "#4d4d4d" } },
  }] : [];
}

/** A black ring in a white one, which can be seen on every colour. */
function placeHere(here) {
  const ring = (color, width) => ({
    type: "scatter", mode: "markers", x: [here.x], y: [here.y], hoverinfo: "skip", showlegend: false, name: "you are here",
    marker: { symbol: "circle-open", size: 13, color, line: { width } },
  });
  return here && Number.isFinite(here.x + here.y) ? [ring("#ffffff", 5), ring("#000000", 2)] : [];
}

/**
 * A figure of numbers.
 * @param {{x: Object, y: Object, z: Array<Array<?number>>, title: Object, texts: Array<Array<string>>, here: ?Object}} chart
 * @returns {{data: Array<Object>, layout: Object, key: Array<HTMLElement>}}
 */
export function numberFigure({ x, y, z, title, texts, here }) {
  const theme = colours();
  const stops = theme.numbers.map((colour, k, all) => [k / (all.length - 1), colour]);
  const missing = z.flat().some((value) => value === null);
  const heat = {
    type: "heatmap", x: x.values, y: y.values, z, colorscale: stops, text: texts, hoverinfo: "text",
    colorbar: { title: { text: titleForPlotly(title), side: "right" }, thickness: 12, outlinewidth: 0, tickfont: { color: theme.ink } },
  };
  const cells = z.map((row) => row.map((value) => ({ hatched: value === null })));
  return {
    data: [heat, ...hatching(x, y, cells), ...placeHere(here)],
    layout: chartLayout(x, y),
    key: missing ? [keyEntry("no result", theme.missing, { symbol: "hatch" })] : [],
  };
}

/**
 * The layout of figures by plotly.js in the house style.
 * @param {{title: Object}} x
 * @param {{title: Object}} y
 * @param {number} [size] of letters
 * @returns {Object}
 */
export function layoutOf(x, y, size = parseFloat(getComputedStyle(document.body).fontSize) * 0.8) {
  const theme = colours();
  const axis = (title) => ({
    title: { text: titleForPlotly(title), standoff: 8, font: { size: 1.05 * size } }, ticks: "inside", mirror: "ticks", showline: true,
    linecolor: theme.frame, tickcolor: theme.frame, gridcolor: theme.grid, zeroline: false, linewidth: 1, automargin: true,
    tickformat: undefined, exponentformat: "power",
  });
  return {
    font: { family: FONT_FAMILY, size, color: theme.ink },
    paper_bgcolor: theme.ground, plot_bgcolor: theme.ground,
    margin: { l: 4 * size, r: size, t: 0.8 * size, b: 3.4 * size },
    showlegend: false, xaxis: axis(x.title), yaxis: axis(y.title), hovermode: "closest", dragmode: "zoom",
    hoverlabel: { bgcolor: theme.ground, bordercolor: theme.frame, font: { color: theme.ink, family: FONT_FAMILY, size } },
    uirevision: "keep",
  };
}

/** What each host is to show, for the time until plotly.js is there. */
const newest = new WeakMap();

/**
 * Draw a figure by plotly.js in a host, with a function for clicks on its cells; arrow keys move
 * from cell to cell, and Enter is a click.
 * @param {HTMLElement} host
 * @param {{data: Array<Object>, layout: Object}} figure
 * @param {function(number, number): void} pick called with column and row
 * @param {function(string): void} say reads words out
 */
export async function drawFigure(host, figure, pick, say) {
  newest.set(host, figure);
  let library = null;
  try {
    library = await plotly();
  } catch ({ message }) {
    host.textContent = message;
    say(message);
    return;
  }
  if (newest.get(host) !== figure) {
    return;
  }
  if (!host.on) {
    host.textContent = ""; // what was said where the library was not to be had
  }
  const config = { displayModeBar: false, responsive: false, doubleClick: "reset" };
  library.react(host, figure.data, { ...figure.layout, ...sizeOf(host) }, config);
  watchSize(host);
  host.removeAllListeners?.("plotly_click");
  host.on("plotly_click", ({ points }) => {
    const [point] = points;
    if (Array.isArray(point?.pointNumber)) {
      pick(point.pointNumber[1], point.pointNumber[0]);
    } else if (point?.curveNumber === 0) {
      pick(point.pointNumber, 0);
    }
  });
  host.tabIndex = 0;
  host.setAttribute("role", "group");
  host.setAttribute("aria-label", "Chart. Arrow keys move from cell to cell, Enter shows the motion of a cell.");
  host.onkeydown = (event) => pressKey(event, host, figure, pick, say);
}

/** The size of a host; plotly.js takes another where it has none yet. */
function sizeOf({ clientWidth, clientHeight }) {
  return clientWidth > 40 && clientHeight > 40 ? { width: clientWidth, height: clientHeight } : {};
}

const watched = new WeakSet();

/** Draw a figure anew in its size when its host has another. */
function watchSize(host) {
  if (!watched.has(host)) {
    watched.add(host);
    new ResizeObserver(() => globalThis.Plotly.relayout(host, sizeOf(host))).observe(host);
  }
}

const STEPS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function pressKey(event, host, { data }, pick, say) {
  const [chart] = data;
  const columns = chart.x.length;
  const rows = chart.z ? chart.y.length : 1;
  const [column, row] = (host.dataset.cell ?? `${columns >> 1},${rows >> 1}`).split(",").map(Number);
  const step = STEPS[event.key];
  if (step) {
    const next = [Math.min(Math.max(column + step[0], 0), columns - 1), Math.min(Math.max(row + step[1], 0), rows - 1)];
    host.dataset.cell = next.join();
    say([chart.z ? chart.text[next[1]][next[0]] : chart.text[next[0]]].flat().join(", ").replaceAll("<br>", ", "));
    showCell(host, chart, next);
  } else if (event.key === "Enter" && host.dataset.cell) {
    pick(column, row);
  } else {
    return;
  }
  event.preventDefault();
}

/** Mark a cell as plotly.js marks the one below the pointer. */
function showCell(host, chart, [column, row]) {
  globalThis.Plotly.Fx.hover(host, { xval: chart.x[column], yval: chart.z ? chart.y[row] : chart.y[column] }, "xy");
}

/**
 * Words of a cell.
 * @param {Array<[string, *]>} entries names and values
 * @returns {string} lines for plotly.js, with its marks made harmless
 */
export function cellText(entries) {
  return entries
    .map(([name, value]) => `${harmless(name)}: ${harmless(typeof value === "number" ? numberText(value, 4) : String(value ?? "no result"))}`)
    .join("<br>");
}
