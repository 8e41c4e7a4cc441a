// A block in three dimensions as a drawing: faces, magnetisation, field and dead loads.

import { drawing, refill } from "./dom.js";
import { colours } from "./theme.js";

const HALF = 118;
/** Half of the width of the drawing in its own units. */
export const VIEW = 150;

/**
 * The projection of a view from above and aside.
 * @param {{turn: number, tilt: number}} angles in radians
 * @param {number} scale units of the drawing in a unit of length
 * @returns {function(number[]): number[]} from a point (x1, x2, x3) to (right, down, depth)
 */
export function projection({ turn, tilt }, scale) {
  const [cosTurn, sinTurn, cosTilt, sinTilt] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
  return ([x, y, z]) => {
    const right = cosTurn * x - sinTurn * y;
    const far = sinTurn * x + cosTurn * y;
    const depth = cosTilt * far - sinTilt * z;
    const grown = scale * (1 - 0.07 * depth * (scale / HALF));
    return [grown * right, -grown * (sinTilt * far + cosTilt * z), depth];
  };
}

const FACES = [
  [[0, 1, 3, 2], [-1, 0, 0]], [[4, 6, 7, 5], [1, 0, 0]], [[0, 4, 5, 1], [0, -1, 0]],
  [[2, 3, 7, 6], [0, 1, 0]], [[0, 2, 6, 4], [0, 0, -1]], [[1, 5, 7, 3], [0, 0, 1]],
];

function corners([a, b, c]) {
  return [-1, 1].flatMap((i) => [-1, 1].flatMap((j) => [-1, 1].map((k) => [i * a, j * b, k * c])));
}

function path(points) {
  return `M${points.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L")}Z`;
}

/**
 * Fill a drawing with the block at an instant.
 * @param {SVGElement} host
 * @param {{half: number[], rest: number[], angles: Object, scale: number, colour: string,
 *   load: number, loads: number[], largest: number}} scene
 *   half, rest: half edges now and undeformed; load: of the field, signed; largest: of its size;
 *   loads: dead loads along the two edges
 */
export function drawBlock(host, { half, rest, angles, scale, colour, load, loads, largest }) {
  const theme = colours();
  const to = projection(angles, scale);
  refill(
    host,
    ...fieldArrows(to, half, load, largest, theme),
    outline(to, rest, theme),
    ...faces(to, half, colour, theme, angles),
    ...magnetisation(to, half, theme),
    ...deadLoads(to, half, loads, theme),
  );
}

function outline(to, rest, theme) {
  const points = corners(rest).map(to);
  const edges = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
  const d = edges.map(([i, j]) => `M${points[i].slice(0, 2).map((x) => x.toFixed(2)).join(" ")}L${points[j].slice(0, 2).map((x) => x.toFixed(2)).join(" ")}`).join("");
  return drawing("path", { d, fill: "none", stroke: theme.faint, "stroke-width": 0.8, "stroke-dasharray": "3 3", opacity: 0.8 });
}

function faces(to, half, colour, theme, angles) {
  const points = corners(half).map(to);
  const light = { "0,0,1": 0.3, "0,0,-1": 0.62, "-1,0,0": 0.5, "1,0,0": 0.5, "0,-1,0": 0.72, "0,1,0": 0.72 };
  const { turn, tilt } = angles;
  const sight = [-Math.sin(turn) * Math.cos(tilt), -Math.cos(turn) * Math.cos(tilt), Math.sin(tilt)];
  return FACES.filter(([, normal]) => normal.reduce((sum, n, i) => sum + n * sight[i], 0) > 0).map(([indices, normal]) =>
    drawing("path", {
      d: path(indices.map((i) => points[i])), fill: colour, "fill-opacity": light[normal.join()],
      stroke: theme.ink, "stroke-width": 1, "stroke-linejoin": "round",
    }),
  );
}

function arrow(from, to, colour, width, extra = {}) {
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(dx, dy);
  if (length < 2) {
    return drawing("circle", { cx: from[0], cy: from[1], r: width, fill: colour, ...extra });
  }
  const head = Math.min(3.2 * width + 2, 0.6 * length);
  const [ux, uy] = [dx / length, dy / length];
  const neck = [to[0] - head * ux, to[1] - head * uy];
  const wing = 0.42 * head;
  const shaft = drawing("line", { x1: from[0], y1: from[1], x2: neck[0], y2: neck[1], stroke: colour, "stroke-width": width, "stroke-linecap": "round" });
  const tip = drawing("path", { d: path([to, [neck[0] - wing * uy, neck[1] + wing * ux], [neck[0] + wing * uy, neck[1] - wing * ux]]), fill: colour });
  return drawing("g", extra, shaft, tip);
}

/** The residual flux moves with the material: along x3, as long as the thickness is stretched. */
function magnetisation(to, [a, b, c], theme) {
  const places = [[-0.5, -0.5], [0.5, -0.5], [-0.5, 0.5], [0.5, 0.5]];
  return places.map(([u, v]) => {
    const [from, end] = [[u * a, v * b, -0.72 * c], [u * a, v * b, 0.72 * c]].map((x) => to(x));
    return arrow(from, end, theme.ink, 1.7, { opacity: 0.85 });
  });
}

/** Arrows of the applied field around the block, as long as the load is strong. */
function fieldArrows(to, [a, b], load, largest, theme) {
  const reach = 1.32 * Math.max(a, b, 1);
  const places = [[-1, 1], [0, 1], [1, 1], [1, 0], [-1, 0]];
  const length = largest > 0 ? load / largest : 0;
  return places.map(([u, v]) => {
    const base = [u * reach, v * reach, 0];
    const [from, end] = [to([base[0], base[1], -0.75 * length]), to([base[0], base[1], 0.75 * length])];
    return arrow(from, end, theme.blue, 2.1, { opacity: 0.9 });
  });
}

function deadLoads(to, [a, b, c], [first, second], theme) {
  const sides = [[1, 0, first], [-1, 0, first], [0, 1, second], [0, -1, second]];
  return sides.filter(([, , size]) => Math.abs(size) > 1e-9).map(([u, v, size]) => {
    const reach = 0.2 + 0.28 * Math.min(2, Math.abs(size));
    const near = to([u * a, v * b, 0 * c]);
    const far = to([u * (a + reach * Math.abs(u)), v * (b + reach * Math.abs(v)), 0]);
    return size > 0 ? arrow(near, far, theme.green, 2.6) : arrow(far, near, theme.green, 2.6);
  });
}
