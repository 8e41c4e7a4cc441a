// The page: what it starts with, what it shows, and how its parts come together.

import { ask, isServerThere, onConnection } from "./api.js";
import { addActions } from "./actions.js";
import { actuatorView } from "./actuator_view.js";
import { backgroundWork } from "./background.js";
import { createClock } from "./clock.js";
import { controlPanel } from "./controls.js";
import { button, byId, refill } from "./dom.js";
import { historyView } from "./history_view.js";
import { basinsView, regimeChartView } from "./map_views.js";
import { addModels, showFirst } from "./models.js";
import { ownSystemDialog } from "./own_system.js";
import { phaseView } from "./phase_view.js";
import { addPictures } from "./pictures.js";
import { potentialView } from "./potential_view.js";
import { regimeView } from "./regime_view.js";
import { responseView } from "./response_view.js";
import { initialState } from "./state.js";
import { statusBar } from "./status_bar.js";
import { createStore } from "./store.js";
import { storeView } from "./store_view.js";
import { takeAwayDialog } from "./take_away.js";
import { startTheme } from "./theme.js";
import { foldingPanel, toolBar } from "./tool_bar.js";

/** Milliseconds between two questions to a server that has gone. */
const ASK_AGAIN_MS = 4000;

/** What the page starts with: from the file itself where it was saved, else from the server. */
async function startingData() {
  const embedded = byId("start");
  return embedded ? { ...JSON.parse(embedded.textContent), saved: true } : ask("/api/start");
}

async function run() {
  startTheme();
  foldingPanel();
  const start = await startingData();
  const field = await import(start.field);
  const app = {
    start, saved: Boolean(start.saved), kinds: start.kinds, presets: start.presets,
    store: createStore(initialState(start.model, field, { isStart: !start.saved })),
  };
  addActions(app);
  addModels(app);
  addParts(app);
  addPictures(app);
  byId("loading").remove();
  await showFirst(app);
  document.documentElement.dataset.ready = "true";
}

/** The parts of the page around the state. */
function addParts(app) {
  app.views = makeViews(app);
  app.status = statusBar(app);
  app.say = app.status.say;
  app.panel = controlPanel(byId("panel"), app);
  app.bar = toolBar(app);
  app.background = app.saved ? null : backgroundWork(app, app.views);
  app.clock = createClock({
    instant: (now) => app.views.live.forEach((view) => view.mark?.(now)),
    state: (on) => app.views.actuator.playing(on),
  });
  byId("saved").hidden = !app.saved;
  app.views.actuator.playing(app.clock.isOn());
  let asking = null;
  onConnection((isThere) => {
    app.status.server(isThere);
    clearInterval(asking);
    if (isThere) {
      app.background?.again();
    } else {
      asking = setInterval(isServerThere, ASK_AGAIN_MS);
    }
  });
}

function makeViews(app) {
  const views = {
    actuator: actuatorView(app), history: historyView(app), phase: phaseView(app),
    potential: potentialView(app), response: responseView(app), regime: regimeView(app),
    basins: basinsView(app), regime_chart: regimeChartView(app),
  };
  const nodes = Object.values(views).map((view) => view.node);
  if (app.start.store) {
    views.store = storeView(app, app.start.store);
    nodes.splice(2, 0, views.store.node);
    views.store.load();
  }
  byId("views").append(...nodes);
  app.save = takeAwayDialog(app).open;
  app.openOwnSystem = ownSystemDialog(app).open;
  app.figures = () => Object.entries(views)
    .filter(([, view]) => view.figure && !view.node.hidden && view.figure().plotly !== null)
    .map(([id, view]) => ({ id, title: view.figure().title, figure: view.figure }));
  views.maps = [views.basins, views.regime_chart];
  views.live = [views.history, views.phase, views.potential, views.actuator, views.response, views.regime, ...views.maps];
  return views;
}

run().catch((error) => {
  console.warn(error);
  const place = byId("loading") ?? byId("banner");
  place.hidden = false;
  refill(place, `The page could not start: ${error.message} `, button("Try again", () => location.reload()));
});
