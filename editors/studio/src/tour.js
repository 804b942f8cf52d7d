// The tour: its steps as pages, each with the game that it has built by then.

import DOMPurify from "dompurify";
import { marked } from "marked";
import { element } from "./dom.js";

let steps = null, at = 0;

// Fills a place with the step somebody has come to. open: called with the path of a step's game.
export async function showTour(place, files, open, isShown = () => true) {
  steps ??= (await files.tour()).steps;
  if (!isShown()) return;
  const step = steps[at], go = (to) => { at = to; showTour(place, files, open); place.scrollTop = 0; };
  const menu = element("select", { "aria-label": "Step of the tour", onchange: () => go(Number(menu.value)) });
  menu.append(...steps.map(({ title }, number) => new Option(title, number, false, number === at)));
  const page = element("div", { class: "sheet" });
  page.innerHTML = DOMPurify.sanitize(marked.parse(step.text), { FORBID_TAGS: ["img", "style", "form", "a"], FORBID_ATTR: ["style"] });
  const way = () => element("div", { class: "controls" },
    element("button", { disabled: at === 0, onclick: () => go(at - 1) }, "Previous step"),
    element("button", { disabled: at === steps.length - 1, onclick: () => go(at + 1) }, "Next step"),
    step.game ? element("button", { "data-game": step.game, onclick: () => open(step.game) }, "Open the game of this step") : null);
  place.replaceChildren(menu, way(), element("h3", {}, step.title), page, way());
}
