// Why something is as it is: what the last step changed on a cell, or everywhere, with the reasons behind each change.

import { coded, element } from "./dom.js";

export function why({ answer, cell, toLine }) {
  if (answer.step === null && !answer.turns.length) return element("p", {}, "Nothing has happened yet: take a step.");
  const concerns = (effect) => !cell || effect.cells.some(([row, col]) => row === cell[0] && col === cell[1]);
  const asked = cell ? `what concerns the cell (${cell[0]}, ${cell[1]})` : "everything";
  const made = [element("p", { class: "hint" }, `The last step, ${asked}. Click on a cell of the board to ask about it.`)];
  for (const turn of answer.turns) {
    const found = turn.rules.map((rule) => ({ ...rule, effects: rule.effects.filter(concerns) })).filter((rule) => rule.effects.length);
    if (!found.length) continue;
    made.push(element("h3", {}, turn.phase));
    for (const rule of found) {
      made.push(element("button", { class: "rule", disabled: rule.line === null, onclick: () => toLine(rule.line) }, `${rule.place}  ${rule.text}`));
      made.push(element("ul", {}, ...rule.effects.map((effect) => element("li", {}, ...coded(effect.said), chain(effect.because, "because ", "and ")))));
    }
  }
  if (made.length === 1) made.push(element("p", {}, "Nothing changed there."));
  return made;
}

// Reasons as a list in which each has those behind it as a list; random bits are unfolded by hand.
function chain(reasons, first = "", others = "") {
  if (!reasons.length) return null;
  const item = (reason, number) => element("li", {}, ...coded((number ? others : first) + reason.text), bits(reason), chain(reason.because));
  return element("ul", { class: "draw" }, ...reasons.map(item));
}

function bits(reason) {
  return reason.bits ? element("details", {}, element("summary", {}, "more"), reason.bits) : null;
}
