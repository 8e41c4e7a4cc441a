// plotly.js, which draws charts and writes figures as files: a large script, asked for when needed.

const ADDRESS = "/plotly.js";

let library = null;

/**
 * The library; in a saved page it is there from the beginning.
 * @returns {Promise<Object>}
 */
export function plotly() {
  library ??= globalThis.Plotly ? Promise.resolve(globalThis.Plotly) : loaded();
  return library;
}

function loaded() {
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = ADDRESS;
    script.onload = () => resolve(globalThis.Plotly);
    script.onerror = () => {
      library = null;
      script.remove();
      reject(new Error("The server does not give the library that draws charts; is it still running?"));
    };
    document.head.append(script);
  });
}
