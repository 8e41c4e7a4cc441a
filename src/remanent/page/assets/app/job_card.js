// A view whose result the server computes: what it is doing, how far it is, and how to stop it.

import { Refused, ServerGone, onConnection } from "./api.js";
import { card } from "./card.js";
import { button, element } from "./dom.js";
import { startJob } from "./jobs.js";

/**
 * A view with a line that says how its work is going.
 * @param {Object} app
 * @param {Object} options of `card`, with `job`, and `again`: what to do when the server has come
 *   back after it was gone before there was a result
 * @returns {Object} the card, with `run`, `cancel`, `say`, `running`
 */
export function jobCard(app, options) {
  const view = card(options);
  const bar = element("progress", { max: 1, "aria-label": `progress: ${options.title}` });
  const words = element("span", { class: "job-words" });
  const stop = button("Cancel", () => cancel(), { class: "quiet" });
  const line = element("div", { class: "job-line", hidden: true }, bar, words, stop);
  view.node.append(line);
  let current = null;
  let isLost = false;
  onConnection((isThere) => {
    if (isThere && isLost) {
      isLost = false;
      say("");
      options.again?.();
    }
  });

  const say = (text, isBad = false) => {
    view.note.textContent = text;
    view.note.classList.toggle("bad", isBad);
  };
  const cancel = () => current?.cancel();

  /** Run the job; the result, or null where it was cancelled, replaced or refused. */
  const run = async (spec, jobOptions) => {
    current?.cancel();
    isLost = false;
    words.textContent = "computing …";
    const job = startJob(options.job, spec, jobOptions, (share, text) => {
      if (Number.isFinite(share)) {
        bar.value = share;
      }
      words.textContent = text ?? "";
    });
    current = job;
    bar.removeAttribute("value");
    line.hidden = false;
    view.node.setAttribute("aria-busy", "true");
    try {
      return await job.result;
    } catch (error) {
      if (current === job) {
        isLost = error instanceof ServerGone;
        explain(error, say);
      }
      return null;
    } finally {
      if (current === job) {
        current = null;
        line.hidden = true;
        view.node.removeAttribute("aria-busy");
      }
    }
  };
  return { ...view, run, cancel, say, running: () => current !== null };
}

function explain(error, say) {
  if (error.name === "AbortError") {
    say("Cancelled. Nothing new has been computed.");
  } else if (error instanceof Refused || error instanceof ServerGone) {
    say(error.message, true);
  } else {
    say(`This could not be computed: ${error.message}`, true);
    console.warn(error);
  }
}
