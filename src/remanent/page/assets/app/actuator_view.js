// The block in three dimensions, as it deforms: it plays the motion that the curves show.

import { drawBlock, VIEW } from "./block_drawing.js";
import { card, keyEntry, putText, showKey } from "./card.js";
import { button, drawing, menu } from "./dom.js";
import { numberText } from "./numbers.js";
import { colours, onTheme } from "./theme.js";
import { timeText } from "./units.js";

const SPEEDS = [["0.25", "¼"], ["1", "1"], ["4", "4"], ["16", "16"]];

/**
 * The view of the block.
 * @param {Object} app
 * @returns {Object} with `node`, `draw`, `mark`, `figure`, `playing`, `fits`
 */
export function actuatorView(app) {
  const angles = { turn: -0.62, tilt: 0.42 };
  let seen = null;
  let instant = null;
  const svg = drawing("svg", {
    viewBox: `${-VIEW} ${-VIEW} ${2 * VIEW} ${2 * VIEW}`, role: "img", tabindex: 0, class: "block",
    "aria-label": "The block in three dimensions. Arrow keys turn it.",
  });
  const play = button("Pause", () => app.clock.toggle(), { class: "quiet", id: "play" });
  const speed = menu(SPEEDS.map(([value, text]) => ({ value, text: `${text} ×` })), "1",
    (value) => app.clock.setSpeed(Number(value)), { "aria-label": "speed of the animation" });
  const view = card({ id: "actuator", title: "Actuator", tools: [play, speed], save: () => app.save("actuator") });
  view.body.append(svg);
  const paint = () => {
    if (!seen || !instant || !seen.isActuator) {
      return;
    }
    const block = blockScene(seen, instant, angles);
    if ([...block.half, ...block.loads, block.scale, block.load, block.largest].every(Number.isFinite)) {
      drawBlock(svg, block);
    } else {
      svg.replaceChildren();
    }
    putText(view.note, caption(seen, instant));
  };
  turnable(svg, angles, paint);
  onTheme(() => {
    paint();
    showLegend(view.key, seen);
  });
  return {
    node: view.node, svg,
    draw: (scene) => {
      seen = scene;
      view.node.hidden = !scene.isActuator;
      showLegend(view.key, scene);
    },
    mark: (now) => {
      instant = now;
      paint();
    },
    playing: (on) => {
      play.textContent = on ? "Pause" : "Play";
      play.setAttribute("aria-label", on ? "pause the animation" : "play the animation");
    },
    figure: () => ({ svg, name: "actuator", title: "Actuator" }),
  };
}

function showLegend(key, scene) {
  const theme = colours();
  const loaded = scene && deadLoads(scene.values).some((load) => load !== 0);
  showKey(key, [
    keyEntry("field", theme.blue, { symbol: "arrow" }), keyEntry("magnetisation", theme.ink, { symbol: "arrow" }),
    ...(loaded ? [keyEntry("dead load", theme.green, { symbol: "arrow" })] : []),
    keyEntry("undeformed", theme.faint, { dash: "dashed" }),
  ]);
}

function deadLoads(values) {
  return [values.prestress ?? values.prestress_1 ?? 0, values.prestress ?? values.prestress_2 ?? 0];
}

/** Stretches along the two edges of a state. */
function stretchesOf({ description }, state) {
  const at = (name) => state[description.state.findIndex((one) => one.name === name)];
  return description.coordinates === 2 ? [at("stretch_1"), at("stretch_2")] : [at("stretch"), at("stretch")];
}

function blockScene(scene, instant, angles) {
  const { values, colour, largestLoad, largestHalf, description } = scene;
  const [l1, l2] = stretchesOf(scene, instant.y);
  const edges = [values.edges_1 ?? 1, values.edges_2 ?? 1];
  const height = Math.sqrt(values.c);
  const rest = [edges[0], edges[1], height];
  const half = [edges[0] * l1, edges[1] * l2, height / (l1 * l2)];
  const loadAt = description.observables.findIndex((one) => one.name === "load");
  const size = 1.15 * Math.max(...rest, 0.72 * largestHalf);
  return {
    half, rest, angles, colour, scale: (0.52 * VIEW) / size, largest: largestLoad / Math.max(0.55, height),
    load: loadAt >= 0 ? instant.observables[loadAt] : 0,
    loads: deadLoads(values),
  };
}

function caption(scene, instant) {
  const { factors } = scene;
  const [l1, l2] = stretchesOf(scene, instant.y);
  const fixed = (x) => x.toFixed(3);
  const shown = [timeText(instant.t, factors)];
  shown.push(scene.description.coordinates === 2 ? `λ₁ = ${fixed(l1)}, λ₂ = ${fixed(l2)}` : `λ = ${fixed(l1)}`);
  shown.push(`λ₃ = ${fixed(1 / (l1 * l2))}`);
  if (factors?.lengths) {
    shown.push(`thickness ${numberText((1e3 * factors.lengths.thickness) / (l1 * l2), 3)} mm`);
  }
  return shown.join(" · ");
}

function turnable(svg, angles, paint) {
  let from = null;
  svg.addEventListener("pointerdown", (event) => {
    from = { x: event.clientX, y: event.clientY, ...angles };
    svg.setPointerCapture(event.pointerId);
  });
  svg.addEventListener("pointermove", (event) => {
    if (from) {
      turn(angles, from.turn + (event.clientX - from.x) / 120, from.tilt + (event.clientY - from.y) / 120);
      paint();
    }
  });
  ["pointerup", "pointercancel"].forEach((name) => svg.addEventListener(name, () => { from = null; }));
  svg.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (step) {
      event.preventDefault();
      turn(angles, angles.turn + step[0], angles.tilt + step[1]);
      paint();
    }
  });
}

function turn(angles, to, tilt) {
  angles.turn = to;
  angles.tilt = Math.min(1.45, Math.max(-0.3, tilt));
}
