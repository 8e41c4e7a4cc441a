// From the state of the page to its pictures.

import { drawSoon } from "./frames.js";
import { isKnownBetter, isWorthRefining, relabelled, sceneOf } from "./scene.js";
import { onTheme } from "./theme.js";

/** Milliseconds without a change after which a motion that is not known well is followed again. */
const REST_MS = 250;

/**
 * Add to the page what draws it: `scene`, `drawNow`, `redraw`, `relabel`, `resetZooms`.
 * @param {Object} app
 */
export function addPictures(app) {
  let scene = null;
  let timer = null;
  app.scene = () => scene;
  const refine = () => {
    const finer = sceneOf(app.store.get(), { refine: true });
    if (isKnownBetter(finer.motion, scene.motion)) {
      scene = finer;
      show(app, scene);
    }
  };
  app.drawNow = () => {
    scene = sceneOf(app.store.get());
    clearTimeout(timer);
    if (isWorthRefining(scene.motion)) {
      timer = setTimeout(refine, REST_MS);
    }
    const integrated = performance.now();
    show(app, scene);
    app.panel.show();
    app.bar.show();
    return integrated;
  };
  app.redraw = drawSoon(app.drawNow);
  app.relabel = () => {
    scene = relabelled(scene, app.store.get());
    show(app, scene);
  };
  app.resetZooms = () => app.views.live.forEach(({ plot }) => plot?.forgetRanges());
  onTheme(() => scene && app.relabel());
}

function show(app, scene) {
  app.views.live.forEach((view) => view.draw(scene));
  app.clock.show(scene);
  app.status.draw(scene);
}
