// Charts that are computed on request: basins of attraction, and regimes over two parameters.

import { button, element, menu } from "./dom.js";
import { categoryFigure, cellText, drawFigure, regimeCategory } from "./heat.js";
import { keyEntry, showKey } from "./card.js";
import { jobCard } from "./job_card.js";
import { extent, numberText } from "./numbers.js";
import { symbolText } from "./symbols.js";
import { onTheme } from "./theme.js";
import { unitText } from "./units.js";

const COUNTS = [["16", "16 × 16"], ["32", "32 × 32"], ["64", "64 × 64"]];

/**
 * The view of basins of attraction.
 * @param {Object} app
 * @returns {Object}
 */
export function basinsView(app) {
  return mapView(app, {
    id: "basins", title: "Basins of attraction", job: "basins", 
    empty: "Where motions from many starts end. Click in the chart to start there.",
    grid: gridOfStates,
    here: (result, scene) => ({ x: stateOf(scene, result.x.name), y: stateOf(scene, result.y.name) }),
    cell: basinCell,
    further: sharesText,
    pick: (result, x, y) => {
      const { description, initial } = app.store.get();
      const start = Array.from(initial);
      [[result.x.name, x], [result.y.name, y]].forEach(([name, value]) => {
        start[description.state.findIndex((one) => one.name === name)] = value;
      });
      app.startAt(start);
    },
  });
}

/**
 * The chart of regimes over frequency and load.
 * @param {Object} app
 * @returns {Object}
 */
export function regimeChartView(app) {
  return mapView(app, {
    id: "regime_chart", title: "Chart of regimes", job: "regime_chart", 
    empty: "Periodic, quasi-periodic or chaotic, over the frequency and the strength of the load. Click a point to see its motion.",
    grid: gridOfParameters,
    here: (result, scene) => ({ x: scene.values[result.x.name], y: scene.values[result.y.name] }),
    cell: (one, j, i) => regimeCategory(one.regime.values[j][i], one.period?.values[j][i]),
    pick: (result, x, y) => {
      app.move(result.x.name, x);
      app.move(result.y.name, y);
      app.commit(result.x.name);
    },
  });
}

function mapView(app, { id, title, job, empty, grid, here, cell, pick, further = () => "" }) {
  const view = jobCard(app, { id, title, job, save: () => app.save(id), again: () => ask() });
  const count = menu(COUNTS.map(([value, text]) => ({ value, text })), "32", () => {}, { "aria-label": `cells of the chart: ${title}` });
  const seen = { result: null, scene: null, figure: null };
  const ask = async () => {
    const result = await view.run(app.currentSpec(), { grid: grid(seen.scene), count: Number(count.value) });
    if (result) {
      show(result);
    }
  };
  const compute = button("Compute", ask, { "aria-label": `compute: ${title}` });
  const intro = element("div", { class: "card-empty" }, element("p", { text: empty }));
  const host = element("div", { class: "plotly-host", hidden: true });
  view.body.append(intro, host);
  if (!app.saved) {
    view.tools.prepend(count, compute);
  }
  const paint = () => {
    const { result, scene } = seen;
    if (!result?.series.length || !scene) {
      return;
    }
    const chart = chartOf(result, cell);
    seen.figure = categoryFigure({ ...chart, here: here(result, scene) });
    showKey(view.key, [...seen.figure.key, keyEntry("you are here", "var(--ink)", { symbol: "ring" })]);
    drawFigure(host, seen.figure, (i, j) => pick(result, chart.x.values[i], chart.y.values[j]), app.say);
  };
  const show = (result, prefix = "") => {
    seen.result = result;
    const has = result.series.length > 0;
    intro.hidden = has;
    host.hidden = !has;
    view.say([prefix + noteOf(result), has ? further(result) : ""].filter(Boolean).join(" "), !has);
    paint();
  };
  onTheme(paint);
  let moving = null;
  return {
    node: view.node, view,
    cancel: view.cancel,
    draw: (scene) => {
      seen.scene = scene;
      view.node.hidden = app.saved ? !seen.result : !scene.description.drive.periodic || grid(scene) === null;
      clearTimeout(moving);
      moving = setTimeout(paint, 200);
    },
    outdate: (structureChanged) => {
      if (seen.result && structureChanged) {
        seen.result = null;
        host.hidden = true;
        intro.hidden = false;
        showKey(view.key, []);
      }
      if (structureChanged) {
        view.say("");
      } else if (seen.result) {
        view.say(`For parameters before the last change. ${noteOf(seen.result)}`);
      }
    },
    showSaved: (results) => {
      seen.result = null;
      if (results[job]) {
        show(results[job], "As computed when this page was saved. ");
      }
      view.node.hidden = !seen.result;
    },
    figure: () => ({ plotly: seen.figure, name: id, title }),
  };
}

function chartOf(result, cell) {
  const [one] = result.series;
  const rows = result.y.values.map((_, j) => result.x.values.map((__, i) => [j, i]));
  return {
    x: { values: result.x.values, title: titleFrom(result.x) },
    y: { values: result.y.values, title: titleFrom(result.y) },
    cells: rows.map((row) => row.map(([j, i]) => cell(one, j, i, result))),
    texts: rows.map((row) => row.map(([j, i]) => cellText([
      [symbolText(result.x.symbol), result.x.values[i]], [symbolText(result.y.symbol), result.y.values[j]],
      ["regime", cell(one, j, i, result).name], ["status", one.status[j][i]],
      ...(one.margin ? [["margin", one.margin.values[j][i]]] : []),
    ]))),
  };
}

function titleFrom(quantity) {
  return { text: quantity.text, symbol: quantity.symbol, unit: unitText(quantity, null) };
}

/** A basin has the colour of its regime, and later ones a letter more. */
function basinCell(one, j, i, result) {
  const category = regimeCategory(one.regime.values[j][i], one.period?.values[j][i]);
  const basin = one.basin?.values[j][i];
  const several = (result.attractors?.attractor_regime?.values.length ?? 0) > 1;
  if (!several || typeof basin !== "number" || basin < 0) {
    return category;
  }
  const palette = ["#f6f3ea", "#4269d1", "#d8c78c", "#8a4462", "#5fa779", "#2b1b8d", "#c6a6f6"];
  return { ...category, name: `${String.fromCharCode(65 + basin)}, ${category.name}`, colour: palette[basin % palette.length], order: basin };
}

/** The share of the chart that each attractor takes. */
function sharesText({ attractors }) {
  const shares = attractors?.fraction?.values ?? [];
  return shares.map((share, k) => {
    const error = attractors.fraction_error?.values[k];
    return `${String.fromCharCode(65 + k)} ${(100 * share).toFixed(1)}${typeof error === "number" ? ` ± ${(100 * error).toFixed(1)}` : ""} %`;
  }).join(", ");
}

function stateOf(scene, name) {
  return scene.initial[scene.description.state.findIndex((one) => one.name === name)];
}

/** The first coordinate and its rate, around what the motion covers. */
function gridOfStates({ motion, description }) {
  const first = description.state.findIndex((one) => one.role === "coordinate");
  const rate = description.state.findIndex((one) => one.role === "rate");
  const [i, j] = first >= 0 && rate >= 0 ? [first, rate] : description.state.length > 1 ? [0, 1] : [-1, -1];
  if (i < 0) {
    return null;
  }
  return Object.fromEntries([i, j].map((k) => [description.state[k].name, wide(extent(motion.y[k]), description.state[k].positive)]));
}

function wide([low, high], positive) {
  const margin = 0.5 * (high - low || 1);
  const start = positive ? Math.max(low - margin, 0.3 * low) : low - margin;
  return [start, high + margin].map((x) => Number(x.toPrecision(3)));
}

/** Frequency and strength of the load, around their values. */
function gridOfParameters({ values, description }) {
  const own = description.parameters.filter((one) => one.group === "drive").map((one) => one.name);
  const strength = ["b", "m"].find((name) => own.includes(name));
  if (!own.includes("omega") || !strength || !(values[strength] !== 0)) {
    return null;
  }
  const around = (x) => [0.5 * x, 1.6 * x].sort((a, b) => a - b).map((y) => Number(y.toPrecision(3)));
  return { omega: around(values.omega), [strength]: around(values[strength]) };
}

function noteOf(result) {
  if (!result.series.length) {
    return result.reason || "There is no result.";
  }
  const words = result.series[0].regime.values.flat();
  const undecided = words.filter((one) => one === "undecided").length;
  const lost = result.series[0].status.flat().filter((one) => one !== "ok").length;
  const parts = [`${words.length} motions of ${numberText(result.settings?.periods ?? NaN, 4)} drive periods`];
  if (undecided) {
    parts.push(`${undecided} undecided`);
  }
  if (lost) {
    parts.push(`${lost} with another status than ok`);
  }
  return `${parts.join(", ")}.${result.reason ? ` ${result.reason}` : ""}`;
}
