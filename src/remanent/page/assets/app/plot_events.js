// Pointer and keyboard on a figure: read values, zoom, pick a point.

/** Pixels that a pointer may move in a click. */
const CLICK_SLACK = 5;

/**
 * Listen to the pointer and the keyboard on a figure.
 *
 * The pointer reads values; a drag zooms (along the horizontal axis where the figure has
 * several panels); a double click shows all again.  Arrow keys move a cross, Enter picks what
 * is under it, + and - zoom about it, 0 shows all again.
 * @param {Object} plot of `createPlot`
 */
export function listenToPlot(plot) {
  const { host } = plot;
  host.tabIndex = 0;
  host.setAttribute("role", "group");
  host.setAttribute("aria-label", plot.options.label);
  let start = null;
  host.addEventListener("pointerdown", (event) => {
    start = event.button === 0 && !event.target.closest("button") ? inside(plot, event) : null;
    if (start && event.pointerType !== "touch") {
      host.setPointerCapture(event.pointerId);
    }
  });
  host.addEventListener("pointermove", (event) => {
    const place = inside(plot, event);
    if (start && place && event.pointerType !== "touch" && moved(start, place)) {
      plot.box = boxOf(plot, start, place);
      plot.repaintOverlay();
      return;
    }
    plot.options.hover?.(place && valuesAt(plot, place), place);
  });
  host.addEventListener("pointerup", (event) => {
    const place = inside(plot, event);
    if (start && place) {
      finish(plot, start, place);
    }
    start = null;
  });
  host.addEventListener("pointercancel", () => {
    start = null;
    plot.box = null;
    plot.repaintOverlay();
  });
  host.addEventListener("pointerleave", () => {
    plot.options.hover?.(null);
  });
  host.addEventListener("dblclick", () => {
    if (!plot.options.pick) {
      plot.resetZoom();
    }
  });
  host.addEventListener("keydown", (event) => pressKey(plot, event));
  host.addEventListener("blur", () => {
    plot.cross = null;
    plot.options.hover?.(null);
    plot.repaintOverlay();
  });
}

function moved(a, b) {
  return Math.hypot(a.px - b.px, a.py - b.py) > CLICK_SLACK;
}

/** The place of an event where it lies in a panel. */
function inside(plot, event) {
  if (!plot.maps) {
    return null;
  }
  const edges = plot.host.getBoundingClientRect();
  const [px, py] = [event.clientX - edges.left, event.clientY - edges.top];
  const { x, panels } = plot.maps;
  const panel = panels.findIndex(({ y }) => py <= y.start && py >= y.end);
  return panel >= 0 && px >= x.start && px <= x.end ? { px, py, panel } : null;
}

function valuesAt(plot, { px, py, panel }) {
  const { x, panels } = plot.maps;
  return { x: x.value(px), y: panels[panel].y.value(py), panel, px, py };
}

function boxOf(plot, a, b) {
  const { panels } = plot.maps;
  const whole = panels.length > 1;
  return {
    left: Math.min(a.px, b.px), right: Math.max(a.px, b.px),
    top: whole ? panels[0].y.end : Math.min(a.py, b.py),
    bottom: whole ? panels[panels.length - 1].y.start : Math.max(a.py, b.py),
  };
}

function finish(plot, start, place) {
  plot.box = null;
  const { x, panels } = plot.maps;
  if (moved(start, place)) {
    const box = boxOf(plot, start, place);
    plot.zoom.x = [x.value(box.left), x.value(box.right)];
    if (panels.length === 1) {
      plot.zoom[panels[0].id] = [panels[0].y.value(box.bottom), panels[0].y.value(box.top)];
    }
    plot.redraw();
  } else {
    const values = valuesAt(plot, start);
    plot.options.pick?.(values.x, values.y);
    plot.repaintOverlay();
  }
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

function pressKey(plot, event) {
  if (!plot.maps || event.altKey || event.ctrlKey || event.metaKey || event.target !== plot.host) {
    return;
  }
  if (event.key in ARROWS) {
    moveCross(plot, ARROWS[event.key], event.shiftKey ? 10 : 1);
  } else if (event.key === "Enter" && plot.cross) {
    plot.options.pick?.(plot.cross.x, plot.cross.y);
  } else if (event.key === "0" || event.key === "Escape") {
    plot.cross = null;
    plot.resetZoom();
  } else if (event.key === "+" || event.key === "=" || event.key === "-") {
    zoomBy(plot, event.key === "-" ? 1.6 : 1 / 1.6);
  } else {
    return;
  }
  event.preventDefault();
}

function moveCross(plot, [right, up], factor) {
  const { x, panels } = plot.maps;
  const { y } = panels[0];
  const step = (factor * (x.end - x.start)) / 160;
  const from = plot.cross
    ? { px: x.pixel(plot.cross.x), py: y.pixel(plot.cross.y) }
    : { px: (x.start + x.end) / 2, py: (y.start + y.end) / 2 };
  const px = Math.min(Math.max(from.px + right * step, x.start), x.end);
  const py = Math.min(Math.max(from.py - up * step, y.end), y.start);
  plot.cross = valuesAt(plot, { px, py, panel: 0 });
  plot.options.hover?.(plot.cross, { px, py, panel: 0 });
  plot.options.speak?.(plot.cross);
  plot.repaintOverlay();
}

function zoomBy(plot, factor) {
  const { x, panels } = plot.maps;
  const about = (map, centre) => {
    const middle = map.pixel(centre);
    return [map.start, map.end].map((edge) => map.value(middle + (edge - middle) * factor));
  };
  plot.zoom.x = about(x, plot.cross?.x ?? x.value((x.start + x.end) / 2));
  if (panels.length === 1) {
    const { y } = panels[0];
    plot.zoom[panels[0].id] = about(y, plot.cross?.y ?? y.value((y.start + y.end) / 2));
  }
  plot.redraw();
}
