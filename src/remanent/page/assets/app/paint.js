// Layers of a panel, painted on a canvas: lines, points, bands, regions, words.

/** Pieces of lines in pixels: for a line style's name. */
export const DASHES = { solid: [], dashed: [6, 4], dotted: [1.5, 3], dashdot: [7, 3, 1.5, 3] };

/**
 * Paint one layer.
 * @param {CanvasRenderingContext2D} context
 * @param {Object} layer of kind "line", "points", "rug", "band", "region", "vertical" or "note"
 * @param {{x: Object, y: Object}} maps of `axisMap`
 * @param {Object} colours of the theme
 */
export function paintLayer(context, layer, maps, colours) {
  context.save();
  context.globalAlpha = layer.alpha ?? 1;
  painters[layer.kind](context, layer, maps, colours);
  context.restore();
}

const painters = { line, points, band, region, vertical, note, rug };

function line(context, layer, { x, y, scale = 1 }) {
  context.strokeStyle = layer.colour;
  context.lineWidth = Math.max(1, scale) * (layer.width ?? 1.25);
  context.lineJoin = "round";
  context.setLineDash(DASHES[layer.dash ?? "solid"].map((part) => part * scale));
  context.beginPath();
  const crowded = layer.x.length > 4 * Math.abs(x.end - x.start);
  (layer.monotonic && crowded ? traceColumns : tracePoints)(context, layer, x, y);
  context.stroke();
}

function tracePoints(context, layer, x, y) {
  let broken = true;
  for (let i = 0; i < layer.x.length; i += 1) {
    const px = x.pixel(layer.x[i]);
    const py = y.pixel(layer.y[i]);
    if (!Number.isFinite(px + py)) {
      broken = true;
    } else if (broken) {
      context.moveTo(px, py);
      broken = false;
    } else {
      context.lineTo(px, py);
    }
  }
}

/** First, smallest, largest and last of each pixel column: what a longer line would paint. */
function traceColumns(context, layer, x, y) {
  let column = NaN;
  let open = false;
  let first, last, low, high;
  const flush = () => {
    if (Number.isFinite(column)) {
      context[open ? "lineTo" : "moveTo"](column, first);
      context.lineTo(column, low);
      context.lineTo(column, high);
      context.lineTo(column, last);
      open = true;
    }
  };
  for (let i = 0; i < layer.x.length; i += 1) {
    const px = Math.round(x.pixel(layer.x[i]) * 2) / 2;
    const py = y.pixel(layer.y[i]);
    if (!Number.isFinite(py)) {
      flush();
      column = NaN;
      open = false;
    } else if (px === column) {
      low = Math.min(low, py);
      high = Math.max(high, py);
      last = py;
    } else {
      flush();
      column = px;
      first = last = low = high = py;
    }
  }
  flush();
}

function points(context, layer, { x, y, scale = 1 }, colours) {
  const size = Math.max(1, scale) * (layer.size ?? 2);
  context.fillStyle = context.strokeStyle = layer.colour;
  context.lineWidth = scale * (layer.width ?? 1.5);
  for (let i = 0; i < layer.x.length; i += 1) {
    const px = x.pixel(layer.x[i]);
    const py = y.pixel(layer.y[i]);
    if (Number.isFinite(px + py)) {
      mark(context, layer.symbol ?? "dot", px, py, size, colours);
    }
  }
}

/**
 * One mark.
 * @param {CanvasRenderingContext2D} context
 * @param {string} symbol "dot", "ring", "square", "cross" or "diamond"
 * @param {number} px
 * @param {number} py
 * @param {number} size half of its width, pixels
 * @param {Object} colours
 */
export function mark(context, symbol, px, py, size, colours) {
  context.beginPath();
  if (symbol === "dot") {
    context.arc(px, py, size, 0, 2 * Math.PI);
    context.fill();
  } else if (symbol === "cross") {
    context.moveTo(px - size, py - size);
    context.lineTo(px + size, py + size);
    context.moveTo(px - size, py + size);
    context.lineTo(px + size, py - size);
    context.stroke();
  } else {
    if (symbol === "ring") {
      context.arc(px, py, size, 0, 2 * Math.PI);
    } else if (symbol === "square") {
      context.rect(px - size, py - size, 2 * size, 2 * size);
    } else {
      context.moveTo(px, py - size);
      context.lineTo(px + size, py);
      context.lineTo(px, py + size);
      context.lineTo(px - size, py);
      context.closePath();
    }
    context.save();
    context.fillStyle = colours.ground;
    context.fill();
    context.restore();
    context.stroke();
  }
}

function band(context, layer, { x, y }) {
  context.fillStyle = layer.colour;
  context.beginPath();
  const last = layer.x.length - 1;
  for (let i = 0; i <= last; i += 1) {
    context.lineTo(x.pixel(layer.x[i]), y.pixel(layer.high[i]));
  }
  for (let i = last; i >= 0; i -= 1) {
    context.lineTo(x.pixel(layer.x[i]), y.pixel(layer.low[i]));
  }
  context.fill();
}

/** A part of the axis that is hatched, with its name. */
function region(context, layer, { x, y }, colours) {
  const left = Math.max(x.pixel(layer.from), x.start);
  const right = Math.min(x.pixel(layer.to), x.end);
  if (!(left < right)) {
    return;
  }
  const [top, bottom] = [y.end, y.start];
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
  context.fillStyle = colours.veil;
  context.fillRect(left, top, right - left, bottom - top);
  context.strokeStyle = colours.veil;
  context.lineWidth = 1;
  context.beginPath();
  for (let at = left - (bottom - top); at < right; at += 8) {
    context.moveTo(at, bottom);
    context.lineTo(at + (bottom - top), top);
  }
  context.stroke();
  if (layer.name) {
    context.fillStyle = colours.faint;
    context.textBaseline = "top";
    context.fillText(layer.name, left + 6, top + 6);
  }
}

function vertical(context, layer, { x, y }) {
  const place = Math.round(x.pixel(layer.x)) + 0.5;
  context.strokeStyle = layer.colour;
  context.lineWidth = layer.width ?? 1;
  context.setLineDash(DASHES[layer.dash ?? "solid"]);
  context.beginPath();
  context.moveTo(place, y.start);
  context.lineTo(place, y.end);
  context.stroke();
  if (layer.name) {
    const nearRight = place > (x.start + x.end) / 2;
    context.fillStyle = layer.colour;
    context.textAlign = nearRight ? "right" : "left";
    context.textBaseline = "top";
    context.fillText(layer.name, place + (nearRight ? -5 : 5), y.end + 5);
  }
}

/** Strokes at the foot of a panel, where something is missing. */
function rug(context, layer, { x, y, scale = 1 }) {
  context.strokeStyle = layer.colour;
  context.lineWidth = 1;
  context.beginPath();
  for (const value of layer.x) {
    const place = Math.round(x.pixel(value)) + 0.5;
    context.moveTo(place, y.start);
    context.lineTo(place, y.start - 9 * scale);
  }
  context.stroke();
}

/** Words in the middle of an empty panel. */
function note(context, layer, { x, y }, colours) {
  context.fillStyle = colours.faint;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const width = x.end - x.start - 20;
  const lines = wrapped(context, layer.text, width);
  const height = 1.45 * parseFloat(context.font.match(/([\d.]+)px/)?.[1] ?? "13");
  const top = (y.start + y.end) / 2 - ((lines.length - 1) * height) / 2;
  lines.forEach((text, k) => context.fillText(text, (x.start + x.end) / 2, top + k * height));
}

function wrapped(context, text, width) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = `${lines[lines.length - 1]} ${word}`.trim();
    if (context.measureText(longer).width > width && lines[lines.length - 1]) {
      lines.push(word);
    } else {
      lines[lines.length - 1] = longer;
    }
  }
  return lines;
}
