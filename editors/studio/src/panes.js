// The three panes: bars between them that are dragged or moved by keys, and, where there is room for one pane only, which of them is shown.

import { find } from "./dom.js";

const KEPT = "sjdsl-panes"; // in the browser's storage
const LEAST = 15, MOST = 60, STEP = 2; // percent of the width
const SIDES = { left: 27, right: 23 }; // percent that the text and the panels have at first

// moved: called when a pane has another width.
export function makePanes(moved) {
  const main = document.querySelector("main"), sides = { ...SIDES, ...kept() };
  const bars = [...main.querySelectorAll('[role="separator"]')];
  const show = () => {
    for (const bar of bars) {
      const side = bar.dataset.side;
      main.style.setProperty(`--${side}-pane`, `${sides[side]}%`);
      bar.setAttribute("aria-valuenow", Math.round(sides[side]));
    }
    moved();
  };
  const set = (side, percent) => {
    const other = sides[side === "left" ? "right" : "left"];
    sides[side] = Math.min(Math.max(percent, LEAST), MOST, 100 - LEAST - other);
    show();
    try { localStorage.setItem(KEPT, JSON.stringify(sides)); } catch { /* they are as usual the next time */ }
  };
  for (const bar of bars) {
    const side = bar.dataset.side, outwards = side === "left" ? 1 : -1;
    bar.addEventListener("pointerdown", (event) => { bar.setPointerCapture(event.pointerId); event.preventDefault(); bar.focus(); });
    bar.addEventListener("pointermove", (event) => {
      if (!bar.hasPointerCapture(event.pointerId)) return;
      const box = main.getBoundingClientRect();
      set(side, (100 * (side === "left" ? event.clientX - box.left : box.right - event.clientX)) / box.width);
    });
    bar.addEventListener("dblclick", () => set(side, SIDES[side]));
    bar.addEventListener("keydown", (event) => {
      const way = { ArrowRight: STEP, ArrowLeft: -STEP }[event.key];
      if (way) { set(side, sides[side] + outwards * way); event.preventDefault(); }
    });
  }
  for (const button of find("views").children) button.addEventListener("click", () => showPane(button.dataset.view));
  showPane("board");
  show();
}

export function showPane(name) {
  document.body.dataset.view = name;
  for (const button of find("views").children) button.setAttribute("aria-pressed", String(button.dataset.view === name));
}

function kept() {
  try {
    return JSON.parse(localStorage.getItem(KEPT)) ?? {};
  } catch {
    return {};
  }
}
