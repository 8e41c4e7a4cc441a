// The bar at the top: presets, one's own system, units, what can be taken away, the theme.

import { writeAddress } from "./address.js";
import { segments } from "./card.js";
import { hasUnits, presetMenu } from "./controls.js";
import { button, byId, element, menu, refill } from "./dom.js";
import { chooseTheme, chosenTheme } from "./theme.js";

/**
 * The bar at the top.
 * @param {Object} app
 * @returns {{build: function(): void, show: function(): void}}
 */
export function toolBar(app) {
  let units = null;
  const changed = button("Reset", () => app.reset(), { class: "quiet", id: "reset", title: "back to the values of the preset" });
  const build = () => {
    const { description } = app.store.get();
    byId("title").textContent = titleOf(app);
    units = hasUnits(description)
      ? segments("units", [{ value: "no", text: "Dimensionless" }, { value: "yes", text: "SI" }], () => (app.store.get().si ? "yes" : "no"), (choice) => app.changeUnits(choice === "yes"))
      : null;
    refill(
      byId("bar"),
      app.presets.length ? element("label", { class: "kind" }, element("span", { text: "Preset" }), presetMenu(app)) : null,
      changed,
      app.saved ? null : button("Own system …", app.openOwnSystem, { id: "open-own" }),
      units?.node ?? null,
      button("Take away …", () => app.save(null), { id: "open-take-away" }),
      shareButton(app),
      themeMenu(),
    );
    show();
  };
  const show = () => {
    changed.hidden = !app.isChanged();
    units?.show();
  };
  return { build, show };
}

function titleOf(app) {
  const { preset, description } = app.store.get();
  return app.presets.find((one) => one.id === preset)?.text ?? description.title;
}

/** An address that says all, also where the page was started with a study of its own. */
function addressToShare(app) {
  const here = location.href.split("#")[0];
  return here + writeAddress({ ...app.store.get(), isStart: false });
}

function shareButton(app) {
  const share = button("Copy link", async () => {
    try {
      await navigator.clipboard.writeText(addressToShare(app));
      app.say("The address is copied.");
      share.textContent = "Copied";
    } catch {
      app.say("Copy the address of this page: it says all that is shown.");
      share.textContent = "See address";
    }
    setTimeout(() => { share.textContent = "Copy link"; }, 2000);
  }, { id: "share" });
  return share;
}

function themeMenu() {
  const choices = [{ value: "auto", text: "Auto theme" }, { value: "light", text: "Light" }, { value: "dark", text: "Dark" }];
  return menu(choices, chosenTheme(), chooseTheme, { id: "theme", "aria-label": "light or dark" });
}

/** The panel of parameters folds away where there is no room beside the curves. */
export function foldingPanel() {
  const [toggle, panel] = [byId("controls-toggle"), byId("controls")];
  const narrow = matchMedia("(max-width: 820px)");
  const put = (open) => {
    panel.classList.toggle("folded", !open);
    toggle.setAttribute("aria-expanded", String(open));
  };
  toggle.addEventListener("click", () => put(panel.classList.contains("folded")));
  narrow.addEventListener("change", () => put(!narrow.matches));
  put(!narrow.matches);
}
