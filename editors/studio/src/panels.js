// What stands beside the board: each panel is made of the answer to one request.

import DOMPurify from "dompurify";
import { marked } from "marked";
import { coded, element, table } from "./dom.js";
import { pythonView } from "./editor.js";
import { why } from "./why.js";

export const PANELS = {
  rules: "Rules",
  why: "Why",
  state: "State",
  seen: "Seen",
  python: "Python",
  checks: "Checks",
  diff: "Variant",
  tour: "Tour",
};
export const ASKED = { why: "trace" }; // where the request has another name
export const LASTING = new Set(["rules", "python", "checks", "diff"]); // depend on the text alone

// What stands in a panel that is still worked on.
export const working = () => element("div", { class: "working", "aria-hidden": "true" }, ...Array.from({ length: 8 }, () => element("div", {})));

// Fills a panel. about: { answer, agent, board, cell, toLine, line, chooseAgent, showIt, keep }; keep: called with a view that follows the cursor.
export function fill(place, name, about) {
  const made = { rules, why, state, seen, python, checks, diff }[name](about);
  place.replaceChildren(...(Array.isArray(made) ? made : [made]));
}

function rules({ answer }) {
  const sheet = element("div", { class: "sheet" });
  sheet.innerHTML = DOMPurify.sanitize(marked.parse(answer.markdown), { FORBID_TAGS: ["img", "style", "form"], FORBID_ATTR: ["style"] });
  for (const block of sheet.querySelectorAll("pre")) block.tabIndex = 0; // long lines are scrolled to by keys, too
  return sheet;
}

function python({ answer, toLine, line, keep }) {
  const place = element("div", { class: "program" }), view = pythonView(place, answer.lines, toLine);
  keep(view);
  requestAnimationFrame(() => view.show(line)); // when it is on the page
  return place;
}

function state({ answer }) {
  const made = [];
  if (answer.cell) {
    made.push(element("h3", {}, `${answer.cell.kind} (${answer.cell.place.join(", ")})`));
    made.push(answer.cell.values.length ? table(answer.cell.values) : element("p", {}, "This kind has no fields."));
  } else made.push(element("p", { class: "hint" }, "Click on a cell of the board to see its fields."));
  made.push(element("h3", {}, "World"), table(answer.world));
  answer.agents.forEach((values, agent) => made.push(element("h3", {}, `Agent ${agent}`), table(values)));
  answer.movers.forEach(([sort, number, values]) => made.push(element("h3", {}, `${sort} ${number}`), table(values)));
  return made;
}

function seen({ answer, board, chooseAgent, count }) {
  const choice = element("select", { onchange: (event) => chooseAgent(Number(event.target.value)) });
  for (let agent = 0; agent < count; agent++) choice.append(new Option(`agent ${agent}`, agent, false, agent === answer.agent));
  const made = [element("label", {}, "What ", choice, " sees, as a picture and plane by plane. Its heading points up.")];
  if (answer.window) {
    const window = element("canvas", { class: "window", role: "img", "aria-label": "The cells that the agent sees" });
    board.paintWindow(window, answer.window, answer.heading);
    made.push(window);
  } else made.push(element("p", {}, "It is away."));
  made.push(element("details", {}, element("summary", {}, "As a language model sees it"), element("pre", {}, answer.message)));
  for (const plane of answer.planes) {
    const rows = plane.values.map((row) => element("tr", {}, ...row.map((value) => element("td", { title: meaning(plane, value), class: value ? "" : "zero" }, String(value)))));
    made.push(element("h3", {}, plane.name), element("table", { class: "plane" }, element("tbody", {}, ...rows)));
    const used = [...new Set(plane.values.flat())].sort((a, b) => a - b);
    if (plane.encoding !== "number") made.push(element("p", { class: "hint" }, used.map((value) => `${value} ${meaning(plane, value)}`).join(", ")));
  }
  return made;
}

function meaning(plane, value) {
  if (plane.encoding === "word") return plane.labels[value] ?? "";
  if (plane.encoding === "bits") return plane.labels.filter((_, bit) => (value >> bit) & 1).join(" + ") || "nothing";
  return String(value);
}

function diff({ answer }) {
  if (answer.text === null) return element("p", {}, "Choose a variant to see what it changes.");
  const sign = (line) => ({ "+": "added", "-": "gone" })[line.trim()[0]] ?? "";
  return element("pre", { class: "diff" }, ...answer.text.split("\n").map((line) => element("div", { class: sign(line) }, line || " ")));
}

function checks({ answer, toLine, showIt }) {
  if (!answer.verdicts.length) return element("p", {}, "This game has no checks.");
  return answer.verdicts.map((verdict) => {
    const rule = element("button", { class: "rule", disabled: verdict.line === null, onclick: () => toLine(verdict.line) }, verdict.text);
    const told = [element("p", {}, element("b", { class: verdict.status.replace(" ", "-") }, verdict.status), ": ", ...coded(verdict.reason))];
    if (verdict.untested.length) told.push(element("p", {}, `Lines that never ran: ${verdict.untested.join("; ")}`));
    if (verdict.scenario) told.push(element("button", { onclick: () => showIt(verdict) }, "Show it on the board"));
    if (verdict.trace.length) told.push(element("pre", {}, verdict.trace.join("\n")));
    return element("section", {}, rule, ...told);
  });
}
