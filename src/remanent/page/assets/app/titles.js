// Titles of axes: "meaning, symbol (unit)".

import { symbolForPlotly, symbolPieces, symbolText } from "./symbols.js";

const LETTERS = '"STIX Two Text", "STIXGeneral", "Cambria Math", Cambria, "Times New Roman", "DejaVu Serif", serif';
const WORDS = 'system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", "DejaVu Sans", sans-serif';

/** The font of words on a canvas. */
export function letterFont(size) {
  return `${size}px ${WORDS}`;
}

/** The families of words, for plotly.js. */
export const FONT_FAMILY = WORDS;

/** A variable of one's own may have its symbol as its only name. */
function meaning(title) {
  return title.symbol && title.text === symbolText(title.symbol) ? "" : title.text;
}

function pieces(title) {
  const symbol = title.symbol ? symbolPieces(title.symbol) : [];
  const text = meaning(title) ? [{ text: meaning(title) + (symbol.length ? ", " : ""), level: 0, word: true }] : [];
  const unit = title.unit && title.unit !== "1" ? [{ text: ` (${title.unit})`, level: 0, word: true }] : [];
  return [...text, ...symbol, ...unit];
}

function fontOf(piece, size) {
  const scaled = piece.level ? 0.72 * size : size;
  if (piece.word) {
    return `${scaled}px ${WORDS}`;
  }
  return `${piece.italic ? "italic " : ""}${1.08 * scaled}px ${LETTERS}`;
}

/**
 * Width of a title.
 * @param {CanvasRenderingContext2D} context
 * @param {{text: string, symbol?: string, unit?: string}} title
 * @param {number} size of letters, pixels
 * @returns {number} pixels
 */
export function titleWidth(context, title, size) {
  return pieces(title).reduce((sum, piece) => {
    context.font = fontOf(piece, size);
    return sum + context.measureText(piece.text).width;
  }, 0);
}

/**
 * Paint a title centred on a place.
 * @param {CanvasRenderingContext2D} context
 * @param {{text: string, symbol?: string, unit?: string}} title
 * @param {number} x
 * @param {number} y of the base line
 * @param {number} size of letters, pixels
 * @param {number} room it may take, pixels
 */
export function paintTitle(context, title, x, y, size, room) {
  const width = titleWidth(context, title, size);
  const shrunk = Math.max(0.75, Math.min(1, room / width));
  let at = x - (shrunk * width) / 2;
  context.textAlign = "left";
  for (const piece of pieces(title)) {
    context.font = fontOf(piece, shrunk * size);
    context.fillText(piece.text, at, y - piece.level * (piece.level > 0 ? 0.36 : 0.2) * size);
    at += context.measureText(piece.text).width;
  }
}

/** A stored text as plotly.js shows it: without its marks. */
export function harmless(text) {
  return text.replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;");
}

/** A title in the marks that plotly.js reads. */
export function titleForPlotly(title) {
  const parts = [harmless(meaning(title) ?? ""), title.symbol && symbolForPlotly(title.symbol)].filter(Boolean).join(", ");
  return title.unit && title.unit !== "1" ? `${parts} (${harmless(title.unit)})` : parts;
}

/** A title as plain text. */
export function titleText(title) {
  const parts = [meaning(title), title.symbol && symbolText(title.symbol)].filter(Boolean).join(", ");
  return title.unit && title.unit !== "1" ? `${parts} (${title.unit})` : parts;
}
