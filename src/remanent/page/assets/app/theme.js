// Light and dark: the colours that drawings use, and the switch between them.

/** Colours of words, after Okabe and Ito; orange and sky are darkened for lines on white. */
const LIGHT = {
  name: "light", ground: "#ffffff", ink: "#1a1a1a", faint: "#6b6f76", grid: "#e4e7eb", frame: "#4a4e55",
  blue: "#0072B2", vermillion: "#C44E00", green: "#00805E", purple: "#A84F82", orange: "#9A6900",
  sky: "#2F8FD0", here: "#0a7fc4", missing: "#9a9a9a", veil: "rgba(120,120,120,0.16)",
  temperature: ["#20068f", "#44039e", "#6300a7", "#8104a7", "#9c179e", "#b42e8d", "#c8437b", "#da5a6a", "#e87059"],
  numbers: ["#440154", "#481c6e", "#463480", "#3e4a89", "#355f8d", "#2c728e", "#25848e", "#1f968b", "#22a884"],
};
const DARK = {
  name: "dark", ground: "#15181c", ink: "#eceef0", faint: "#a0a6ad", grid: "#2b3036", frame: "#8b9199",
  blue: "#56B4E9", vermillion: "#FF8A3D", green: "#2FC79A", purple: "#E59BC4", orange: "#E6B23C",
  sky: "#8CCBF2", here: "#56B4E9", missing: "#7d7d7d", veil: "rgba(190,190,190,0.14)",
  temperature: ["#b12a90", "#c5407e", "#d6556d", "#e66c5c", "#f2844b", "#fa9e3b", "#feba2c", "#fad824", "#f0f921"],
  numbers: ["#2a788e", "#238a8d", "#1e9c89", "#28ae80", "#44bf70", "#6ccd5a", "#9bd93c", "#cde11d", "#fde725"],
};
const TEMPERATURES_KELVIN = [240, 410];
const KEY = "remanent.theme";

/** Colours of regimes and periods: as in the figures of the package. */
export const REGIME_COLOURS = {
  periods: ["#f6f3ea", "#d8c78c", "#4269d1", "#5fa779", "#8a4462", "#2b1b8d", "#c6a6f6"],
  "quasi-periodic": "#1a547d",
  chaotic: "#f2701d",
  undecided: "#9a9a9a",
  escaped: "#101018",
};

let theme = LIGHT;
const listeners = new Set();

/** The colours in force. */
export function colours() {
  return theme;
}

/**
 * Call a function whenever the colours change.
 * @param {function(): void} listener
 */
export function onTheme(listener) {
  listeners.add(listener);
}

/** What was chosen: "auto", "light" or "dark". */
export function chosenTheme() {
  try {
    return localStorage.getItem(KEY) ?? "auto";
  } catch {
    return "auto";
  }
}

/**
 * Choose "auto", "light" or "dark".
 * @param {string} choice
 */
export function chooseTheme(choice) {
  try {
    localStorage.setItem(KEY, choice);
  } catch {
    // A page from a file may not remember; the choice holds until it is closed.
  }
  apply(choice);
}

/** Follow the choice, and the system where there is none. */
export function startTheme() {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    if (chosenTheme() === "auto") {
      apply("auto");
    }
  });
  apply(chosenTheme());
}

function apply(choice) {
  const dark = choice === "dark" || (choice === "auto" && matchMedia("(prefers-color-scheme: dark)").matches);
  theme = dark ? DARK : LIGHT;
  document.documentElement.dataset.theme = theme.name;
  listeners.forEach((listener) => listener());
}

/**
 * The colour of a temperature, the same in every view.
 * @param {number} kelvin
 * @returns {string}
 */
export function temperatureColour(kelvin) {
  const [low, high] = TEMPERATURES_KELVIN;
  return mixed(theme.temperature, (kelvin - low) / (high - low));
}

/**
 * A colour of an ordered number.
 * @param {number} share from 0 to 1
 * @returns {string}
 */
export function numberColour(share) {
  return mixed(theme.numbers, share);
}

function mixed(stops, share) {
  const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const k = Math.min(Math.floor(place), stops.length - 2);
  const channel = (colour, i) => parseInt(colour.slice(1 + 2 * i, 3 + 2 * i), 16);
  const parts = [0, 1, 2].map((i) => {
    const [a, b] = [channel(stops[k], i), channel(stops[k + 1], i)];
    return Math.round(a + (b - a) * (place - k));
  });
  return `rgb(${parts.join(",")})`;
}

/** Whether motion on the page is to be kept to what was asked for. */
export function prefersStill() {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}
