// Symbols: from the LaTeX of the schema to pieces of text that a canvas and a page can show.

import { element } from "./dom.js";

const LETTERS = {
  alpha: "α", beta: "β", gamma: "γ", delta: "δ", epsilon: "ε", varepsilon: "ε", zeta: "ζ", eta: "η",
  theta: "θ", kappa: "κ", lambda: "λ", mu: "μ", nu: "ν", xi: "ξ", pi: "π", rho: "ρ", sigma: "σ",
  tau: "τ", phi: "φ", varphi: "φ", chi: "χ", psi: "ψ", omega: "ω", Delta: "Δ", Lambda: "Λ",
  Omega: "Ω", infty: "∞", partial: "∂", pm: "±", langle: "⟨", rangle: "⟩", max: "max", min: "min",
  ln: "ln", cdot: "·", times: "×", prime: "′", ell: "ℓ", quad: " ",
};
const ACCENTS = { bar: "\u0304", hat: "\u0302", dot: "\u0307", ddot: "\u0308", tilde: "\u0303" };
const UPRIGHT = new Set(["mathrm", "text", "operatorname"]);

/**
 * Pieces of a symbol.
 * @param {string} latex for example `\lambda_3'`
 * @returns {Array<{text: string, italic: boolean, level: number}>} level 0 is the line, 1 above
 *   it and -1 below it
 */
export function symbolPieces(latex) {
  const pieces = [];
  read(String(latex ?? "").replace(/^\$|\$$/g, ""), 0, true, pieces);
  return joined(pieces);
}

function read(text, level, italic, pieces) {
  let i = 0;
  while (i < text.length) {
    const mark = text[i];
    if (mark === "_" || mark === "^") {
      const [inner, next] = group(text, i + 1);
      read(inner, mark === "_" ? -1 : 1, italic, pieces);
      i = next;
    } else if (mark === "\\") {
      i = readCommand(text, i, level, italic, pieces);
    } else if (mark === "{") {
      const [inner, next] = group(text, i);
      read(inner, level, italic, pieces);
      i = next;
    } else {
      const shown = mark === "'" ? "′" : mark === "~" ? " " : mark;
      pieces.push({ text: shown, italic: italic && /\p{L}/u.test(shown), level });
      i += 1;
    }
  }
}

function readCommand(text, i, level, italic, pieces) {
  const word = /^\\([a-zA-Z]+)\s*/.exec(text.slice(i));
  if (!word) {
    const narrow = { ",": " ", ";": " ", " ": " ", "!": "" };
    pieces.push({ text: narrow[text[i + 1]] ?? text[i + 1] ?? "", italic: false, level });
    return i + 2;
  }
  const [all, name] = word;
  const after = i + all.length;
  if (name in LETTERS) {
    const letter = LETTERS[name];
    pieces.push({ text: letter, italic: italic && letter.length === 1 && /\p{Ll}/u.test(letter), level });
    return after;
  }
  const [inner, next] = group(text, after);
  const part = [];
  read(inner, level, italic && !UPRIGHT.has(name), part);
  if (name in ACCENTS && part.length) {
    part[0] = { ...part[0], text: part[0].text + ACCENTS[name] };
  }
  pieces.push(...part);
  return next;
}

/** The group or single mark that begins at a place, and the place after it. */
function group(text, start) {
  if (text[start] !== "{") {
    const command = /^\\[a-zA-Z]+/.exec(text.slice(start));
    const length = command ? command[0].length : 1;
    return [text.slice(start, start + length), start + length];
  }
  let depth = 0;
  for (let i = start; i < text.length; i += 1) {
    depth += text[i] === "{" ? 1 : text[i] === "}" ? -1 : 0;
    if (depth === 0) {
      return [text.slice(start + 1, i), i + 1];
    }
  }
  return [text.slice(start + 1), text.length];
}

function joined(pieces) {
  const result = [];
  for (const piece of pieces) {
    const last = result[result.length - 1];
    if (last && last.italic === piece.italic && last.level === piece.level) {
      last.text += piece.text;
    } else {
      result.push({ ...piece });
    }
  }
  return result;
}

/**
 * A symbol as an element of the page.
 * @param {string} latex
 * @returns {HTMLElement}
 */
export function symbolElement(latex) {
  const tags = { "-1": "sub", 0: "span", 1: "sup" };
  const parts = symbolPieces(latex).map(({ text, italic, level }) =>
    element(tags[level], { class: italic ? "letter" : "upright", text }),
  );
  return element("span", { class: "symbol" }, ...parts);
}

/**
 * A symbol in the marks that plotly.js reads.
 * @param {string} latex
 * @returns {string}
 */
export function symbolForPlotly(latex) {
  const tags = { "-1": "sub", 1: "sup" };
  return symbolPieces(latex)
    .map(({ text, italic, level }) => {
      const safe = text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
      const letters = italic ? `<i>${safe}</i>` : safe;
      return level ? `<${tags[level]}>${letters}</${tags[level]}>` : letters;
    })
    .join("");
}

/**
 * A symbol as plain text, for names that are read out.
 * @param {string} latex
 * @returns {string}
 */
export function symbolText(latex) {
  const below = "₀₁₂₃₄₅₆₇₈₉";
  return symbolPieces(latex)
    .map(({ text, level }) => (level < 0 ? text.replace(/\d/g, (d) => below[Number(d)]) : text))
    .join("");
}
