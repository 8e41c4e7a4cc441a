// A figure as a file: the layers of a view drawn again by plotly.js, with titles and units.

import { plotly } from "./charts_library.js";
import { layoutOf } from "./heat.js";
import { colours } from "./theme.js";
import { titleForPlotly } from "./titles.js";

const DASHES = { solid: "solid", dashed: "dash", dotted: "dot", dashdot: "dashdot" };
const SYMBOLS = { dot: "circle", ring: "circle-open", square: "square-open", diamond: "diamond-open", cross: "x-thin-open" };
const SIZE = { width: 720, height: 460, letters: 13 };

/**
 * The figure of a view for plotly.js.
 * @param {Object} figure of a view: `plot`, or `plotly`
 * @returns {{data: Array<Object>, layout: Object}}
 */
export function plotlyFigure(figure) {
  return figure.plotly
    ? { data: figure.plotly.data, layout: { ...figure.plotly.layout, font: { ...figure.plotly.layout.font, size: SIZE.letters } } }
    : figureOfPlot(figure.plot);
}

function figureOfPlot(plot) {
  const { maps, content, options } = plot;
  const theme = colours();
  const base = layoutOf({ title: content.x.title }, { title: content.panels[0].title }, SIZE.letters);
  const layout = {
    ...base, showlegend: true, margin: { l: 70, r: 20, t: 44, b: 60 },
    legend: { orientation: "h", x: 0, y: 1.02, yanchor: "bottom", font: { size: 0.9 * SIZE.letters } },
    xaxis: { ...base.xaxis, range: maps.x.logarithmic ? maps.x.range.map(Math.log10) : maps.x.range },
    shapes: [], annotations: [],
  };
  const shares = sharesOf(options.panels);
  const data = [];
  maps.panels.forEach((panel, k) => {
    const name = k === 0 ? "" : String(k + 1);
    const range = panel.logarithmic ? panel.y.range.map(Math.log10) : panel.y.range;
    layout[`yaxis${name}`] = {
      ...base.yaxis, title: { ...base.yaxis.title, text: titleForPlotly(panel.title) }, domain: shares[k],
      range, type: panel.logarithmic ? "log" : "linear", automargin: true, anchor: "x",
      nticks: Math.max(3, Math.round(10 * (shares[k][1] - shares[k][0]))),
      ...(panel.logarithmic ? { dtick: Math.max(1, Math.ceil((range[1] - range[0]) / 3)) } : {}),
    };
    panel.layers.forEach((layer) => addLayer(layer, `y${name}`, panel.y.range, data, layout, theme));
  });
  if (maps.panels.length > 1) {
    layout.xaxis.anchor = `y${maps.panels.length}`;
    layout.xaxis.mirror = "allticks";
  }
  hideRepeated(data);
  return { data, layout };
}

/** Parts of the height, the first panel on top. */
function sharesOf(panels) {
  const whole = panels.reduce((sum, panel) => sum + panel.share, 0);
  const gap = 0.04;
  let top = 1;
  return panels.map(({ share }, k) => {
    const bottom = k === panels.length - 1 ? 0 : top - (share / whole) * (1 - gap * (panels.length - 1));
    const domain = [Math.max(0, bottom), top];
    top = bottom - gap;
    return domain;
  });
}

function addLayer(layer, yaxis, range, data, layout, theme) {
  const named = { name: layer.name ?? "", showlegend: Boolean(layer.name), yaxis, opacity: layer.alpha ?? 1 };
  if (layer.kind === "line") {
    data.push({ ...named, type: "scatter", mode: "lines", x: Array.from(layer.x), y: Array.from(layer.y),
      line: { color: layer.colour, width: layer.width ?? 1.25, dash: DASHES[layer.dash ?? "solid"], simplify: false } });
  } else if (layer.kind === "points" && layer.x.length) {
    data.push({ ...named, type: "scatter", mode: "markers", x: Array.from(layer.x), y: Array.from(layer.y),
      marker: { color: layer.colour, size: 2 * (layer.size ?? 2), symbol: SYMBOLS[layer.symbol ?? "dot"], line: { color: layer.colour, width: layer.width ?? 1 } } });
  } else if (layer.kind === "rug") {
    data.push({ ...named, type: "scatter", mode: "markers", x: Array.from(layer.x), y: Array.from(layer.x, () => range[0]), cliponaxis: false, marker: { symbol: "line-ns-open", size: 14, color: layer.colour, line: { width: 1, color: layer.colour } } });
  } else if (layer.kind === "band") {
    data.push({ type: "scatter", mode: "lines", x: [...layer.x, ...Array.from(layer.x).reverse()], y: [...layer.high, ...Array.from(layer.low).reverse()],
      fill: "toself", fillcolor: theme.veil, line: { width: 0 }, name: "error", showlegend: false, yaxis });
  } else if (layer.kind === "region") {
    layout.shapes.push({ type: "rect", xref: "x", yref: `${yaxis} domain`, x0: layer.from, x1: Number.isFinite(layer.to) ? layer.to : layout.xaxis.range[1], y0: 0, y1: 1, fillcolor: theme.veil, line: { width: 0 }, layer: "below" });
    if (layer.name) {
      layout.annotations.push({ text: layer.name, x: layer.from, xref: "x", y: 1, yref: `${yaxis} domain`, xanchor: "left", yanchor: "top", showarrow: false });
    }
  } else if (layer.kind === "vertical") {
    layout.shapes.push({ type: "line", xref: "x", yref: `${yaxis} domain`, x0: layer.x, x1: layer.x, y0: 0, y1: 1, line: { color: layer.colour, width: 1, dash: DASHES[layer.dash ?? "solid"], simplify: false } });
  } else if (layer.kind === "note") {
    layout.annotations.push({ text: layer.text, x: 0.5, xref: "paper", y: 0.5, yref: `${yaxis} domain`, showarrow: false });
  }
}

/** One entry of the legend for each name. */
function hideRepeated(data) {
  const seen = new Set();
  for (const trace of data) {
    if (seen.has(trace.name)) {
      trace.showlegend = false;
    }
    seen.add(trace.name);
  }
}

/**
 * The file of a figure.
 * @param {Object} figure of a view
 * @param {"svg"|"png"} format
 * @returns {Promise<Blob>}
 */
export async function figureFile(figure, format) {
  const address = figure.svg ? await drawingAddress(figure.svg, format) : await plotlyAddress(figure, format);
  return typeof address === "string" ? blobOf(address) : address;
}

async function plotlyAddress(figure, format) {
  const { width, height } = SIZE;
  const { data, layout } = plotlyFigure(figure);
  const library = await plotly();
  return library.toImage({ data, layout, config: {} }, { format, width, height, scale: format === "png" ? 3 : 1 });
}

/** The bytes behind a data: address, without asking the network for them. */
function blobOf(address) {
  const [head, body] = [address.slice(5, address.indexOf(",")), address.slice(address.indexOf(",") + 1)];
  const type = head.split(";")[0];
  if (!head.endsWith(";base64")) {
    return new Blob([decodeURIComponent(body)], { type });
  }
  return new Blob([Uint8Array.from(atob(body), (letter) => letter.charCodeAt(0))], { type });
}

/** A drawing of the page as a file of its own. */
async function drawingAddress(svg, format) {
  const copy = svg.cloneNode(true);
  const size = 600;
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  copy.setAttribute("width", size);
  copy.setAttribute("height", size);
  copy.removeAttribute("class");
  copy.removeAttribute("tabindex");
  const text = new XMLSerializer().serializeToString(copy);
  if (format === "svg") {
    return new Blob([text], { type: "image/svg+xml" });
  }
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 3 * size;
  const context = canvas.getContext("2d");
  context.fillStyle = colours().ground;
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

/**
 * Hand a file to the person.
 * @param {Blob} blob
 * @param {string} name
 */
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}
