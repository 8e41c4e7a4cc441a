// The frequency response, with the place where the motion is, and its branches where asked.

import { jobCard } from "./job_card.js";
import { keyEntry, showKey } from "./card.js";
import { element } from "./dom.js";
import { determinedCount } from "./curves.js";
import { errorText, numberText } from "./numbers.js";
import { createPlot } from "./plot.js";
import { branchKey, branchLayers, branchNote } from "./branches.js";
import { colours } from "./theme.js";
import { placeTip } from "./tip.js";
import { conversion, converted, frequencyText, timeText, titleOf } from "./units.js";

/** Duration over which the amplitude is taken, in units of tau. */
const WINDOW = 100;
const POINTS = 400;
const SWEEPS = { up: { symbol: "ring", colour: "blue" }, down: { symbol: "square", colour: "green" } };

/**
 * The view of the frequency response.
 * @param {Object} app
 * @returns {Object} with `node`, `draw`, `figure`, `request`, `showSaved`, `isWanted`
 */
export function responseView(app) {
  const branches = element("input", { type: "checkbox", id: "branches" });
  const sweeps = element("input", { type: "checkbox", id: "sweeps" });
  const view = jobCard(app, {
    id: "response", title: "Frequency response", job: "frequency_response", save: () => app.save("response"),
    tools: app.saved ? [] : [
      element("label", { class: "check", title: "coexisting and unstable branches of periodic response" }, branches, " branches"),
      element("label", { class: "check", title: "rising and falling frequencies" }, sweeps, " sweeps"),
    ],
  });
  const diagram = jobCard(app, { id: "diagram-job", title: "branches", job: "response_diagram" });
  const diagramLine = diagram.node.querySelector(".job-line");
  view.node.append(diagramLine);
  const seen = { scene: null, response: null, colour: null, diagram: null, range: null, stale: false, old: app.saved ? "as saved" : "before the last change" };
  const plot = createPlot(view.body, {
    label: "Frequency response: amplitude against the frequency of the load. Click to go to a frequency; or move the cross with the arrow keys and press Enter.",
    panels: [{ id: "y", share: 1 }],
    pick: (x) => goTo(app, seen, x),
    computeRange: app.saved ? null : (shown) => {
      seen.range = shown.map((edge) => Number(conversion("omega", seen.scene.factors).back(edge).toPrecision(4)));
      plot.forgetRanges();
      request(app.currentSpec());
    },
    hover: (place) => placeTip(plot, place ? words(seen, place) : "", place),
    speak: (place) => app.say(words(seen, place)),
    refresh: () => seen.scene && show(),
  });
  const show = () => {
    plot.show(contentOf(seen, view.running()));
    showKey(view.key, keyOf(seen));
    plot.moveMarks(placeMarks(seen));
  };
  /** Say something in the units in force, and again when these change. */
  const tell = (words, isBad = false) => {
    seen.words = isBad ? null : words;
    view.say(words(seen.scene.factors), isBad);
  };
  const request = async (spec) => {
    seen.stale = seen.response !== null;
    const result = await view.run(spec, { range: wantedRange(seen), count: POINTS, duration: WINDOW, sweeps: sweeps.checked });
    if (result) {
      seen.response = result;
      seen.colour = seen.scene.colour;
      seen.stale = false;
      tell((factors) => noteOf(result, factors) + (coversFrequency(seen) ? "" : " The frequency of the load lies outside this range."));
    }
    show();
    if (result && branches.checked) {
      await requestBranches(spec);
    }
    return result;
  };
  const requestBranches = async (spec) => {
    const result = await diagram.run(spec, { range: seen.response?.settings.range ?? wantedRange(seen) });
    seen.diagram = result;
    tell(() => (result ? branchNote(result) : diagram.note.textContent || "No branches."), !result);
    show();
  };
  branches.addEventListener("change", () => {
    if (branches.checked) {
      requestBranches(app.currentSpec());
    } else {
      diagram.cancel();
      seen.diagram = null;
      show();
    }
  });
  sweeps.addEventListener("change", () => request(app.currentSpec()));
  return {
    node: view.node, plot, request,
    cancel: () => { view.cancel(); diagram.cancel(); },
    isWanted,
    covers: () => coversFrequency(seen),
    forget: () => { seen.response = seen.diagram = seen.colour = seen.range = seen.words = null; seen.stale = false; view.say(""); },
    outdate: () => { seen.stale = true; seen.diagram = null; show(); },
    draw: (scene) => {
      view.node.hidden = app.saved ? !app.hasResults : !isWanted(scene);
      const stale = app.saved ? app.isChanged() : seen.stale;
      const same = seen.scene && stale === seen.stale && plot.content && seen.scene.colour === scene.colour && seen.scene.factors === scene.factors && seen.scene.description === scene.description;
      const otherUnits = seen.scene && seen.scene.factors !== scene.factors;
      seen.scene = scene;
      seen.stale = stale;
      if (otherUnits && seen.words) {
        tell(seen.words);
      }
      if (same) {
        plot.moveMarks(placeMarks(seen));
      } else {
        show();
      }
    },
    showSaved: (results) => {
      const some = (result) => (result?.series.length ? result : null);
      seen.response = some(results.frequency_response);
      seen.diagram = some(results.response_diagram);
      seen.colour = seen.scene.colour;
      const reason = results.frequency_response?.reason || "The page was saved without a frequency response.";
      tell((factors) => (seen.response ? `As computed when this page was saved. ${noteOf(seen.response, factors)}` : reason));
      show();
    },
    say: view.say,
    figure: () => ({ plot, name: "frequency_response", title: "Frequency response" }),
    data: () => seen.response,
  };
}

/** The range that was asked for, while the frequency lies in it; else the server chooses one. */
function wantedRange({ range, scene }) {
  const { omega } = scene.values;
  return range && range[0] > 0 && range[0] <= omega && omega <= range[1] ? range : undefined;
}

/** Whether the frequency of the load lies in the range of the response, if there is one. */
function coversFrequency({ response, scene }) {
  const [low, high] = response?.settings.range ?? [0, Infinity];
  return low <= scene.values.omega && scene.values.omega <= high;
}

/** Whether the load has a frequency. */
function isWanted({ description }) {
  return description.drive.periodic && description.parameters.some((one) => one.name === "omega" && one.group === "drive");
}

/** (max - min)/2 of the page's own motion over the window of the response. */
function amplitudeOf({ motion, watched }) {
  let [low, high] = [Infinity, -Infinity];
  const y = motion.observables[watched];
  const count = determinedCount(motion);
  for (let i = 0; i < count && motion.t[i] <= WINDOW; i += 1) {
    low = Math.min(low, y[i]);
    high = Math.max(high, y[i]);
  }
  return high > low ? (high - low) / 2 : NaN;
}

function contentOf(seen, running) {
  const { scene, response, diagram, stale } = seen;
  const { description, factors } = scene;
  const colour = seen.colour ?? scene.colour;
  const theme = colours();
  const omega = description.parameters.find((one) => one.name === "omega");
  const watched = description.observables[scene.watched];
  const layers = [];
  if (response) {
    const x = (one) => converted(one.omega.values, "omega", factors);
    for (const one of response.series) {
      const y = one.amplitude.values.map((value) => value ?? NaN);
      const look = SWEEPS[one.name];
      const alpha = stale ? 0.35 : 1;
      layers.push(look
        ? { kind: "points", x: x(one), y, ...look, colour: theme[look.colour], size: 2.4, width: 1, name: one.text, alpha }
        : { kind: "line", x: x(one), y, colour, width: 1.4, name: one.text, alpha });
    }
  }
  const missing = missingOf(response);
  if (missing.length) {
    layers.push({ kind: "rug", fit: false, x: converted(missing, "omega", factors), colour: theme.missing, name: "no result" });
  }
  layers.push(...branchLayers(diagram, factors, theme));
  if (!layers.length) {
    layers.push({ kind: "note", text: running ? "computing the frequency response …" : "no frequency response yet" });
  }
  const y = { text: "amplitude", symbol: `${watched.symbol}^{\\mathrm{a}}`, unit: "" };
  const empty = !response && !diagram;
  return {
    x: { title: omega ? titleOf({ ...omega, text: "drive frequency" }, factors) : { text: "drive frequency", symbol: "\\omega" }, tight: true, ...(empty ? { range: emptyRange(scene) } : {}) },
    panels: [{ title: y, layers, floor: 0 }],
  };
}

/** Frequencies at which the response from the start has no result. */
function missingOf(response) {
  const rest = response?.series.find((one) => one.name === "rest") ?? response?.series[0];
  return rest ? rest.omega.values.filter((_, k) => rest.amplitude.values[k] === null) : [];
}

/** Frequencies of the axis before there is a response. */
function emptyRange({ values, factors }) {
  const { to } = conversion("omega", factors);
  return [to(0.5 * values.omega), to(2 * values.omega)];
}

function keyOf({ scene, response, diagram, stale, colour, old }) {
  const theme = colours();
  const entries = (response?.series ?? []).map((one) =>
    keyEntry(stale ? `${one.text} (${old})` : one.text, SWEEPS[one.name] ? theme[SWEEPS[one.name].colour] : (colour ?? scene.colour), { symbol: SWEEPS[one.name]?.symbol }));
  if (missingOf(response).length) {
    entries.push(keyEntry("no result", theme.missing, { symbol: "rug" }));
  }
  return [...entries, ...branchKey(diagram, theme), keyEntry("you are here", scene.here, { symbol: "dot" })];
}

function placeMarks({ scene }) {
  const place = conversion("omega", scene.factors).to(scene.values.omega);
  const colour = scene.here;
  const amplitude = amplitudeOf(scene);
  const dot = Number.isFinite(amplitude) ? [{ kind: "dot", x: place, y: amplitude, colour }] : [];
  return Number.isFinite(place) ? [{ kind: "vertical", x: place, colour, dash: "dotted", name: "you are here" }, ...dot] : [];
}

function goTo(app, seen, x) {
  const omega = conversion("omega", seen.scene.factors).back(x);
  if (omega > 0) {
    app.move("omega", Number(omega.toPrecision(4)));
    app.commit("omega");
  }
}

function words({ scene, response }, place) {
  const rest = response?.series.find((one) => one.name === "rest") ?? response?.series[0];
  if (!rest) {
    return "";
  }
  const omega = conversion("omega", scene.factors).back(place.x);
  const xs = rest.omega.values;
  let k = 0;
  xs.forEach((value, i) => {
    if (Math.abs(value - omega) < Math.abs(xs[k] - omega)) {
      k = i;
    }
  });
  const value = rest.amplitude.values[k];
  const error = rest.error.values[k];
  const at = frequencyText(xs[k], scene.factors, 4);
  return value === null ? `${at}: ${rest.status[k]}` : `${at}, amplitude ${numberText(value, 4)} ± ${errorText(error ?? NaN)}`;
}

function noteOf(result, factors) {
  const { resonance = {}, series, reason } = result;
  const at = resonance.resonance?.values;
  const rest = series.find((one) => one.name === "rest") ?? series[0];
  const errors = rest.error.values.filter((x) => x !== null);
  const missing = rest.amplitude.values.filter((x) => x === null).length;
  const parts = [];
  if (typeof at === "number") {
    parts.push(`Largest at ${frequencyText(at, factors, 5)} ± ${errorText(conversion("omega", factors).to(resonance.resonance_error.values ?? NaN))}`);
  } else {
    parts.push("No resonance inside this range");
  }
  if (errors.length) {
    parts.push(`error of amplitudes ≤ ${errorText(Math.max(...errors))}`);
  }
  if (missing) {
    parts.push(`${missing} of ${rest.amplitude.values.length} frequencies without a result${reason ? `: ${reason}` : ""}`);
  }
  return `${parts.join("; ")}. From the start up to ${timeText(result.settings?.duration ?? WINDOW, factors)}.`;
}
