// The line that is always in sight: the regime, the error, and what the page and server do.

import { button, byId, element, refill } from "./dom.js";
import { errorText, numberText } from "./numbers.js";
import { timeText } from "./units.js";

/** Milliseconds of rest after which the line is read out. */
const SPOKEN_AFTER_MS = 900;

/**
 * The line of status.
 * @param {Object} app
 * @returns {{draw: function(Object): void, regime: function(string, boolean): void,
 *   server: function(boolean): void, say: function(string): void}}
 */
export function statusBar(app) {
  const regime = element("output", { id: "status-regime", class: "chip" });
  const error = element("output", { id: "status-error", class: "chip" });
  const server = element("span", { id: "status-server", class: "status-server", hidden: true },
    element("span", { text: "The server has gone. Curves still follow the sliders." }),
    button("Try again", () => app.retry(), { class: "quiet", id: "retry" }));
  refill(byId("status"), regime, error, server);
  let timer = null;
  let spoken = "";
  const speakSoon = () => {
    clearTimeout(timer);
    timer = setTimeout(() => {
      const known = regime.classList.contains("old") ? "" : regime.textContent;
      const words = [known, error.textContent].filter(Boolean).join(". ");
      if (words !== spoken) {
        spoken = words;
        byId("live").textContent = words;
      }
    }, SPOKEN_AFTER_MS);
  };
  return {
    draw: (scene) => {
      const [text, bad] = errorWords(scene);
      error.textContent = text;
      error.classList.toggle("bad", bad);
      speakSoon();
    },
    regime: (text, isOld) => {
      regime.textContent = text ? `Regime: ${text}` : "";
      regime.classList.toggle("old", isOld);
      regime.title = isOld ? "of the parameters before the last change" : "";
      speakSoon();
    },
    server: (isThere) => {
      server.hidden = isThere;
      if (!isThere) {
        byId("live").textContent = "The server has gone. Curves still follow the sliders.";
      }
    },
    say: (text) => {
      byId("live").textContent = "";
      byId("live").textContent = text;
      spoken = text;
    },
  };
}

/** The stated error at the end of what is determined, in words; and whether it is bad. */
function errorWords({ motion, factors, period }) {
  const { t, error, status, determinedUntil } = motion;
  if (t.length < 2) {
    return ["no motion", true];
  }
  const until = (x) => timeText(x, factors);
  const last = t[t.length - 1];
  if (status === "ok") {
    const periods = period > 0 ? ` (${numberText(last / period, 4)} periods)` : "";
    return [`Error ≤ ${errorText(error[error.length - 1])} of each variable’s size up to ${until(last)}${periods}`, false];
  }
  if (status === "left") {
    return [`Determined up to ${until(Math.min(last, determinedUntil))}, where the motion leaves the model`, true];
  }
  return [`Determined up to ${until(determinedUntil)}; not beyond`, true];
}
