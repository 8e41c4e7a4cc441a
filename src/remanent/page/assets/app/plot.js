// A figure with axes on a canvas: panels above each other that share their horizontal axis.
//
// What follows a slider is painted here, since a canvas needs a millisecond or two for what
// plotly.js needs tens of; exported figures are made by plotly.js from the same layers.

import { axisMap, fittedRange, ticks } from "./axes.js";
import { button, element } from "./dom.js";
import { extent } from "./numbers.js";
import { mark, paintLayer } from "./paint.js";
import { letterFont, paintTitle, titleWidth } from "./titles.js";
import { colours, onTheme } from "./theme.js";
import { listenToPlot } from "./plot_events.js";

/**
 * Make a figure in a host element.
 * @param {HTMLElement} host
 * @param {{label: string, panels: Array<{id: string, share: number, logarithmic?: boolean}>,
 *   pick?: function(number, number): void, hover?: function(?Object): void,
 *   computeRange?: function([number, number]): void, refresh?: function(): void}} options
 *   pick: called with the coordinates of the first panel that were clicked or entered;
 *   computeRange: computes what is shown of the horizontal axis anew, where it has been zoomed;
 *   refresh: makes the layers anew, for another range or other colours
 * @returns {Object} with `show`, `moveMarks`, `redraw`, `resetZoom` ...
 */
export function createPlot(host, options) {
  const frame = element("canvas", { "aria-hidden": "true" });
  const base = element("canvas", { "aria-hidden": "true" });
  const overlay = element("canvas", { class: "plot-overlay", "aria-hidden": "true" });
  const tip = element("div", { class: "plot-tip", hidden: true });
  host.classList.add("plot");
  const zoomed = element("div", { class: "plot-zoomed", hidden: true },
    options.computeRange ? button("Compute this range", () => options.computeRange(plot.zoom.x)) : null,
    button("Show all", () => plot.resetZoom()));
  host.replaceChildren(frame, base, overlay, zoomed, tip);
  const plot = {
    host, frame, base, overlay, zoomed, tip, options, framed: "",
    content: null, maps: null, fitted: {}, zoom: {}, marks: [], cross: null, box: null,
    show: (content) => show(plot, content),
    moveMarks: (marks) => {
      plot.marks = marks;
      paintOverlay(plot);
    },
    redraw: () => (options.refresh ? options.refresh() : paintAll(plot)),
    repaintOverlay: () => paintOverlay(plot),
    forgetRanges: () => {
      plot.zoom = {};
      plot.fitted = {};
    },
    resetZoom: () => {
      plot.forgetRanges();
      plot.redraw();
    },
  };
  new ResizeObserver(() => resize(plot)).observe(host);
  onTheme(plot.redraw);
  listenToPlot(plot);
  return plot;
}

function show(plot, content) {
  plot.content = content;
  paintAll(plot);
}

function resize(plot) {
  const { clientWidth: width, clientHeight: height } = plot.host;
  const ratio = window.devicePixelRatio || 1;
  for (const canvas of [plot.frame, plot.base, plot.overlay]) {
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
  }
  plot.size = { width, height, ratio, em: parseFloat(getComputedStyle(plot.host).fontSize) };
  plot.framed = "";
  paintAll(plot);
}

/** Ranges, maps and margins of what is shown. */
function arrange(plot) {
  const { width, height, em } = plot.size;
  const { content, options } = plot;
  const area = { left: 4.6 * em, right: width - 1.3 * em, top: 0.7 * em, bottom: height - 3.1 * em };
  const gap = 0.7 * em;
  const shared = options.panels.reduce((sum, panel) => sum + panel.share, 0);
  const room = area.bottom - area.top - gap * (options.panels.length - 1);
  const xRange = plot.zoom.x ?? rangeOf(plot, "x", content.x, content.panels.flatMap((p) => p.layers));
  const x = axisMap(xRange, area.left, area.right, content.x.logarithmic);
  let top = area.top;
  const panels = options.panels.map((panel, k) => {
    const bottom = top + (room * panel.share) / shared;
    const shown = content.panels[k];
    const yRange = plot.zoom[panel.id] ?? rangeOf(plot, panel.id, { ...panel, ...shown }, shown.layers);
    const y = axisMap(yRange, bottom, top, panel.logarithmic);
    top = bottom + gap;
    return { ...panel, ...shown, y };
  });
  return { em, x, panels };
}

function rangeOf(plot, id, axis, layers) {
  if (axis.range) {
    return axis.range;
  }
  const key = id === "x" ? "x" : "y";
  const arrays = layers
    .filter((layer) => layer.fit !== false && layer[key]?.length !== undefined)
    .map((layer) => layer[key]);
  const data = extent(...arrays);
  plot.fitted[id] = fittedRange(data, plot.fitted[id], axis);
  return plot.fitted[id];
}

function paintAll(plot) {
  if (!plot.size || plot.size.width < 40 || plot.size.height < 40 || !plot.content) {
    return;
  }
  plot.maps = arrange(plot);
  plot.zoomed.hidden = Object.keys(plot.zoom).length === 0;
  paintAxes(plot);
  paintData(plot);
  paintOverlay(plot);
}

function cleared(plot, canvas) {
  const { width, height, ratio, em } = plot.size;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = letterFont(0.87 * em);
  return context;
}

/** Grid, frame and titles; they are left as they are while no range changes. */
function paintAxes(plot) {
  const { em, x, panels } = plot.maps;
  const theme = colours();
  const titles = [plot.content.x.title, ...panels.map((panel) => panel.title)];
  const said = JSON.stringify([theme.name, x.range, panels.map((panel) => panel.y.range), titles]);
  if (said === plot.framed) {
    return;
  }
  plot.framed = said;
  const context = cleared(plot, plot.frame);
  panels.forEach((panel, k) => {
    paintGrid(context, panel, x, em, theme);
    paintFrame(context, panel, x, em, theme, { first: k === 0, last: k === panels.length - 1 });
  });
  paintTitles(context, plot, em, theme);
}

function paintData(plot) {
  const { x, panels, em } = plot.maps;
  const context = cleared(plot, plot.base);
  const theme = colours();
  for (const panel of panels) {
    context.save();
    context.beginPath();
    context.rect(x.start, panel.y.end, x.end - x.start, panel.y.start - panel.y.end);
    context.clip();
    panel.layers.forEach((layer) => paintLayer(context, layer, { x, y: panel.y, scale: em / 14.4 }, theme));
    context.restore();
  }
}

function panelTicks(panel, em) {
  const length = panel.y.start - panel.y.end;
  return ticks(panel.y.range, length, { logarithmic: panel.logarithmic, spacing: 2.6 * em });
}

function paintGrid(context, panel, x, em, theme) {
  context.strokeStyle = theme.grid;
  context.lineWidth = 1;
  context.beginPath();
  for (const { value } of ticks(x.range, x.end - x.start, { spacing: 4.6 * em, logarithmic: x.logarithmic })) {
    const place = Math.round(x.pixel(value)) + 0.5;
    context.moveTo(place, panel.y.start);
    context.lineTo(place, panel.y.end);
  }
  for (const { value } of panelTicks(panel, em)) {
    const place = Math.round(panel.y.pixel(value)) + 0.5;
    context.moveTo(x.start, place);
    context.lineTo(x.end, place);
  }
  context.stroke();
}

function paintFrame(context, panel, x, em, theme, { first, last }) {
  const tick = 0.35 * em;
  context.strokeStyle = theme.frame;
  context.fillStyle = theme.ink;
  context.lineWidth = 1;
  context.strokeRect(
    Math.round(x.start) + 0.5, Math.round(panel.y.end) + 0.5,
    Math.round(x.end - x.start), Math.round(panel.y.start - panel.y.end),
  );
  context.beginPath();
  context.textAlign = "right";
  context.textBaseline = "middle";
  for (const { value, text } of panelTicks(panel, em)) {
    const place = Math.round(panel.y.pixel(value)) + 0.5;
    context.moveTo(x.start, place);
    context.lineTo(x.start + tick, place);
    const crowded = (!first && place < panel.y.end + 0.45 * em) || (!last && place > panel.y.start - 0.45 * em);
    if (!crowded) {
      context.fillText(text, x.start - 0.45 * em, place);
    }
  }
  context.textAlign = "center";
  context.textBaseline = "top";
  for (const { value, text } of ticks(x.range, x.end - x.start, { spacing: 4.6 * em, logarithmic: x.logarithmic })) {
    const place = Math.round(x.pixel(value)) + 0.5;
    context.moveTo(place, panel.y.start);
    context.lineTo(place, panel.y.start - tick);
    if (last) {
      context.fillText(text, place, panel.y.start + 0.4 * em);
    }
  }
  context.stroke();
}

function paintTitles(context, plot, em, theme) {
  const { x, panels } = plot.maps;
  const size = 0.95 * em;
  context.fillStyle = theme.ink;
  context.textBaseline = "alphabetic";
  paintTitle(context, plot.content.x.title, (x.start + x.end) / 2, plot.size.height - 0.55 * em, size, x.end - x.start);
  for (const panel of panels) {
    context.save();
    context.translate(1.05 * em, (panel.y.start + panel.y.end) / 2);
    context.rotate(-Math.PI / 2);
    const room = panel.y.start - panel.y.end;
    const long = 0.78 * titleWidth(context, panel.title, size) <= room;
    paintTitle(context, long ? panel.title : { ...panel.title, text: "" }, 0, 0, size, room);
    context.restore();
  }
}

/** What moves by itself: the instant of the animation, the cross of the pointer. */
function paintOverlay(plot) {
  if (!plot.maps) {
    return;
  }
  const context = cleared(plot, plot.overlay);
  const theme = colours();
  const { x, panels, em } = plot.maps;
  for (const item of plot.marks) {
    const panel = panels[item.panel ?? 0];
    if (item.kind === "dot") {
      const [px, py] = [x.pixel(item.x), panel.y.pixel(item.y)];
      if (px >= x.start - 1 && px <= x.end + 1 && py <= panel.y.start + 1 && py >= panel.y.end - 1) {
        context.fillStyle = theme.ground;
        mark(context, "dot", px, py, 0.5 * em, theme);
        context.fillStyle = item.colour;
        mark(context, "dot", px, py, 0.34 * em, theme);
      }
    } else if (x.pixel(item.x) >= x.start && x.pixel(item.x) <= x.end) {
      panels.forEach(({ y }, k) =>
        paintLayer(context, { ...item, kind: "vertical", name: k ? "" : item.name }, { x, y }, theme),
      );
    }
  }
  paintCross(context, plot, theme);
}

function paintCross(context, plot, theme) {
  const { x, panels } = plot.maps;
  context.lineWidth = 1;
  context.setLineDash([]);
  if (plot.cross) {
    const { y } = panels[plot.cross.panel];
    const px = Math.round(x.pixel(plot.cross.x)) + 0.5;
    const py = Math.round(y.pixel(plot.cross.y)) + 0.5;
    context.strokeStyle = theme.faint;
    context.beginPath();
    context.moveTo(px, y.start);
    context.lineTo(px, y.end);
    context.moveTo(x.start, py);
    context.lineTo(x.end, py);
    context.stroke();
  }
  if (plot.box) {
    const { left, top, right, bottom } = plot.box;
    context.fillStyle = theme.veil;
    context.strokeStyle = theme.faint;
    context.fillRect(left, top, right - left, bottom - top);
    context.strokeRect(left, top, right - left, bottom - top);
  }
}
