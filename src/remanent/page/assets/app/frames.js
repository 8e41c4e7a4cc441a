// One picture for all changes since the last, and how long each took.

/** Pictures whose times are kept. */
const KEPT = 500;

/**
 * A function that draws with the next picture of the screen, once for all calls before it.
 *
 * What it took is told in `window.remanentTimings`, the last pictures, each with times in
 * milliseconds: `asked` (the first change), `started`, `integrated`, `drawn`, and as an entry of
 * the browser's performance timeline called "remanent: change to curves".
 * @param {function(): number} draw returns the time at which the motion was known
 * @returns {function(): void}
 */
export function drawSoon(draw) {
  let asked = null;
  globalThis.remanentTimings = [];
  const frame = () => {
    const started = performance.now();
    const first = asked;
    asked = null;
    const integrated = draw();
    const drawn = performance.now();
    const timings = globalThis.remanentTimings;
    timings.push({ asked: first, started, integrated, drawn });
    if (timings.length > KEPT) {
      timings.shift();
    }
    performance.clearMeasures("remanent: change to curves");
    performance.measure("remanent: change to curves", { start: first, end: drawn });
  };
  return () => {
    if (asked === null) {
      asked = performance.now();
      requestAnimationFrame(frame);
    }
  };
}
