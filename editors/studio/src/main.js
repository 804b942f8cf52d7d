// The studio: the text on the left, the board in the middle, what is asked for on the right.

import { setDiagnosticsEffect } from "@codemirror/lint";
import { Compartment, EditorState } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { basicSetup } from "codemirror";
import { Bench } from "./bench.js";
import { Board } from "./board.js";
import { Curves } from "./curves.js";
import { coded, element, find } from "./dom.js";
import { draftOf, dropDraft, keepDraft } from "./drafts.js";
import { foldLongComments, followShade, language as texts } from "./editor.js";
import { Files } from "./files.js";
import { Games, nameOf, prefixOf } from "./games.js";
import { connectLanguage, languageOf, lint } from "./language.js";
import { entryOf, showNumbers, withNumber, withoutNumber } from "./numbers.js";
import { painter } from "./painting.js";
import { makePanes, showPane } from "./panes.js";
import { ASKED, LASTING, PANELS, fill, working } from "./panels.js";
import { Problems } from "./problems.js";
import { keepThumbnail } from "./thumbnails.js";
import { showTour } from "./tour.js";
import { ahead, isServed } from "./transport.js";

const meta = (name) => document.querySelector(`meta[name="${name}"]`).content;
const files = new Files();
const CAPS = { up: "↑", down: "↓", left: "←", right: "→", comma: ",", full_stop: ".", space: "Space", enter: "Enter" };
const KEYS = { ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right", ",": "comma", ".": "full_stop", " ": "space", Enter: "enter" };

const open = { path: "", uri: "", digest: null, saved: "", version: 0, variants: [], agents: null, params: {}, game: null, map: null, isKept: true };
const shown = { panel: "rules", cell: null, agent: 0, driven: null, at: 0, moments: 1, running: false };
const SLOW = 1000; // milliseconds after which something that is waited for is said to be under way
const SOON = 150; // and after which a panel shows that it is worked on
let view = null, language = null, unfollow = null, program = null;

const bench = new Bench("/bench", { onLost: lost, onOpen: () => sendText(false), onBusy: (busy) => markBusy("bench", busy) });
const beside = new Bench("/bench", { onLost: () => {}, onOpen: () => { beside.stale = true; refreshPanel(); }, onBusy: (busy) => markBusy("beside", busy) }); // for what takes long
beside.stale = true;
const board = new Board(find("board"), find("stage"), {
  onCell: chooseCell,
  onPut: (agent, row, col) => ask({ do: "put", agent, row, col }),
  onPaint: painter({
    open, files, bench, say, isExample: () => isExample(), glyph: () => find("glyph").value, view: () => view,
    changed: () => { markUnsaved(); sendText(false); },
  }),
});
const curves = new Curves({ ask: () => bench.ask({ do: "panel", panel: "curves" }), choose: goTo });
const problems = new Problems({ view: () => view, toLine, say: tell });
const games = new Games({ files, current: () => open.path, open: (path, isSaved) => (isSaved ? openFile(path) : openSafely(path)) });

// ---- the text

// Resolves to whether there is such a file. What somebody has not saved of it is there again.
async function openFile(path) {
  const file = await files.read(path);
  if (file.refused) { say(file.refused); return false; }
  const draft = draftOf(path);
  const chosen = (name) => (path === meta("opened") ? meta(name) : ""); // on the command line
  Object.assign(open, {
    path, uri: file.uri, digest: draft?.digest ?? file.digest, saved: file.text,
    variants: chosen("variant") ? chosen("variant").split("+") : [],
    agents: chosen("agents") ? Number(chosen("agents")) : null,
    params: {}, map: draft?.map ?? null,
  });
  find("name").textContent = nameOf(path);
  document.title = `${path} · sjdsl studio`;
  history.replaceState(null, "", `#${encodeURI(path)}`);
  say("");
  makeEditor(draft?.text ?? file.text);
  if (draft && draft.digest !== file.digest) askAboutChange(`${path} was changed by somebody else since these changes, which are not saved`, draft.text);
  else if (draft && isUnsaved()) find("message").replaceChildren("Your changes that are not saved are here again. ", element("button", { onclick: () => openAnew(path) }, "Discard them"));
  if (!draft && !bench.wasOpen && ahead?.path === path) {
    showGame(ahead.answer);
    showScene(ahead.answer);
    say("Loading Python: the board can be played in a moment.");
  }
  sendText(true);
  return true;
}

// Opens a file as it is, without what somebody has not saved of it.
function openAnew(path) {
  dropDraft(path);
  return openFile(path);
}

// The path that the address names, "" without one.
function addressed() {
  try {
    return decodeURIComponent(location.hash.slice(1));
  } catch {
    return "";
  }
}

// Opens a file; what is not saved of the one before stays in the browser, and if that keeps nothing, somebody is asked what becomes of it.
function openSafely(path) {
  if (!view || !isUnsaved() || open.isKept) return openFile(path);
  const lose = element("button", { onclick: () => openFile(path) }, `Open ${path}, and lose them`);
  const stay = element("button", { onclick: () => say("") }, "Stay here");
  find("message").replaceChildren(`${open.path} has changes that are not saved. `, lose, " ", stay);
}

// Looks whether somebody else has changed the file, another window or an editor; called when this window is come back to.
async function lookAgain() {
  if (!view || isExample() || !open.digest) return;
  const { path, digest } = open, file = await files.read(path).catch(() => ({ refused: true }));
  if (file.refused || file.digest === digest || open.path !== path || open.digest !== digest) return;
  if (isUnsaved()) return askAboutChange(`${path} was changed by somebody else since it was opened`, text());
  await openFile(path);
  say(`${path} was changed by somebody else, and is shown as it is now`);
}

// What the language server adds to the editor: it comes and goes without taking the cursor or the history of changes along.
const speech = new Compartment();
const spoken = () => (language ? languageOf(language, open.uri) : []);

function makeEditor(text) {
  if (view) { unfollow(); view.destroy(); }
  const changed = EditorView.updateListener.of((update) => {
    if (update.docChanged) { markUnsaved(); sendText(false); }
    if (update.docChanged || update.transactions.some(({ effects }) => effects.some((effect) => effect.is(setDiagnosticsEffect)))) problems.show();
    if (update.selectionSet) program?.show(lineHere());
  });
  const keys = keymap.of([{ key: "Mod-s", run: () => { save(); return true; } }]), named = EditorView.contentAttributes.of({ "aria-label": "Text of the game", tabindex: "0" });
  view = new EditorView({
    state: EditorState.create({ doc: text, extensions: [lint, basicSetup, texts, keys, named, changed, speech.of(spoken())] }), // lint first: so is its message in a hover
    parent: find("text"),
  });
  unfollow = followShade(view);
  const made = view;
  requestAnimationFrame(() => { if (view === made) foldLongComments(made); }); // when it is known how wide it is
  markUnsaved();
}

const text = () => view.state.doc.toString();
const isExample = () => prefixOf(open.path) !== "";

function sendText(fresh) {
  if (!view || !bench.isOpen) return;
  clearTimeout(soon.timer); // the panel waits for the answer to this text
  const version = ++open.version;
  const request = { version, ...asItIs(), fresh };
  bench.latest("text", { do: "text", ...request }, (answer) => {
    if (answer.lost && !bench.isOpen) return; // it is sent again as soon as there is a connection
    beside.stale = true;
    problems.answered(answer);
    document.body.dataset.version = version;
    document.body.dataset.compiles = answer.compiles === true;
    if (answer.refused || !answer.compiles) {
      if (!open.game && shown.panel !== "tour") find("panel").replaceChildren(element("p", {}, "No rules have compiled yet."));
      return;
    }
    if (answer.game.left.length) say(`no longer numbers of this game: ${answer.game.left.join(", ")}`);
    showGame(answer);
    showScene(answer);
    if (fresh) board.drawn.then(() => keepThumbnail(request.path, find("board")));
    soon();
  });
}

// Brings the panel up to date a moment after the last of many edits, so that the next one need not wait for it.
function soon() {
  clearTimeout(soon.timer);
  soon.timer = setTimeout(() => { refreshPanel(); curves.fill(); }, LASTING.has(shown.panel) ? 300 : 0);
}

// What there is to open: the text and, if somebody has painted it, the file of its map.
function asItIs() {
  const over = open.map ? { [open.map.path]: open.map.text } : {};
  return { path: open.path, text: text(), variants: open.variants, agents: open.agents, params: open.params, over };
}

async function save() {
  const sent = text();
  if (isExample()) return saveAs();
  if (!(await saveMap())) return;
  const answer = await files.write(open.path, sent, open.digest);
  if (answer.changed) return askAboutChange(answer.refused, sent);
  if (answer.refused) return say(answer.refused);
  Object.assign(open, { digest: answer.digest, saved: sent });
  say("");
  markUnsaved();
}

// Writes the file of the map, if somebody has painted it; resolves to whether that went well.
async function saveMap() {
  if (!open.map || open.map.text === open.map.saved) return true;
  const written = await files.write(open.map.path, open.map.text, open.map.digest);
  if (written.refused) say(written.refused);
  else Object.assign(open.map, { digest: written.digest, saved: open.map.text });
  return !written.refused;
}

// A bundled game stays as it is: what somebody makes of it is a file of their own.
async function saveAs() {
  if (!(await saveMap())) return;
  games.saveAs(async (path) => {
    const answer = await files.copy(open.path, path, text());
    if (!answer.refused) dropDraft(open.path);
    return answer;
  });
}

function askAboutChange(reason, sent) {
  const theirs = element("button", { onclick: () => openAnew(open.path) }, "Open theirs, and lose mine");
  const mine = element("button", { onclick: async () => { open.digest = (await files.read(open.path)).digest ?? null; save(sent); } }, "Write mine over it");
  find("message").replaceChildren(...coded(`${reason}. `), theirs, mine);
}

function markUnsaved() {
  find("save").disabled = !view || !isUnsaved();
  find("unsaved").hidden = find("save").disabled;
  if (find("save").disabled) dropDraft(open.path);
  else open.isKept = keepDraft(open.path, { text: text(), map: open.map, digest: open.digest });
}

function isUnsaved() {
  return text() !== open.saved || (open.map !== null && open.map.text !== open.map.saved);
}

function toLine(number, at = null) {
  const { doc } = view.state, from = Math.min(at ?? doc.line(Math.min(number, doc.lines)).from, doc.length);
  showPane("text");
  view.dispatch({ selection: { anchor: from }, effects: EditorView.scrollIntoView(from, { y: "center" }) });
  view.focus();
}

// ---- the board

function showGame({ game, pictures }) {
  open.game = game;
  find("title").textContent = game.title;
  const chosen = game.chosen.join("+");
  const names = game.variants.map(([name]) => name), several = names.includes(chosen) || !chosen ? [] : [chosen];
  options(find("variant"), [["", "as written"], ...[...names, ...several].map((name) => [name, name])], chosen);
  find("variant").title = game.variants.find(([name]) => name === chosen)?.[1] ?? "";
  for (const [number, [, title]] of game.variants.entries()) find("variant").options[number + 1].title = title;
  find("variant").disabled = !game.variants.length;
  if (document.activeElement !== find("crew")) find("crew").value = game.agents;
  find("crew").disabled = !game.agents_are_free && open.agents === null;
  find("crew").title = find("crew").disabled ? "The text says how many: name a `size` after `agents` to choose here" : "Number of agents; empty: as the text says";
  find("diff").hidden = !game.chosen.length;
  find("counterexample").hidden = !game.counterexample;
  showRoles(game);
  find("seed").value = game.seed;
  options(find("glyph"), [["", "nothing"], ...game.glyphs], game.glyphs.some(([glyph]) => glyph === find("glyph").value) ? find("glyph").value : "");
  showNumbers(find("numbers"), game.numbers, { set: setNumber, write: writeNumber });
  find("numbers-title").hidden = !game.numbers.length;
  showLegend(game.legend.map(([picture, text]) => [pictures[picture], text]));
  curves.begin(game);
  board.begin(game);
  shown.agent = Math.min(shown.agent, game.agents - 1);
}

// Who is driven and who drives the others, which the seats say if there are any.
function showRoles(game) {
  const isSeated = game.seats.length > 0, wasSeated = find("driven").disabled;
  find("driven").disabled = find("others").disabled = isSeated;
  if (isSeated) {
    const person = game.seats.indexOf("you");
    shown.driven = person < 0 ? null : person;
    options(find("others"), [["", "as seated"]], "");
  } else {
    if (wasSeated || shown.driven >= game.agents) shown.driven = null;
    const elsewhere = isServed ? [["RUN@best", "trained, or a model"]] : []; // a browser has no JAX: no seats to ask for
    options(find("others"), [...game.policies.map((name) => [name, name]), ...elsewhere], game.others);
  }
  options(find("driven"), [["", "nobody"], ...Array.from({ length: game.agents }, (_, agent) => [String(agent), `agent ${agent}`])], String(shown.driven ?? ""));
  showKeys();
}

function options(select, pairs, chosen) {
  select.replaceChildren(...pairs.map(([value, text]) => new Option(text ? (value && text !== value ? `${value}: ${text}` : text) : value, value, false, value === chosen)));
}

function showLegend(entries) {
  const form = JSON.stringify(entries);
  if (form === showLegend.form) return;
  showLegend.form = form;
  find("legend").replaceChildren(...entries.map(([picture, text]) => element("li", {}, element("img", { src: picture, alt: "" }), text)));
}

// Sets a number from the next step on; of many values that somebody drags through, the last. Resolves to whether the game takes it.
function setNumber(name, entry, value, isWritten) {
  const request = { do: "number", name, value: entryOf(entry, value) };
  return new Promise((resolve) => bench.latest(`number ${name} ${entry}`, request, (answer) => {
    take(answer);
    if (answer.refused) return resolve(false);
    if (!open.game.counterexample) open.params = isWritten ? withoutNumber(open.params, name, entry) : withNumber(open.params, name, request.value);
    beside.stale = true;
    resolve(true);
  }));
}

async function writeNumber(name, entry, value) {
  const { doc } = view.state;
  if (document.body.dataset.compiles !== "true" || bench.next.has("text")) return say("The text has errors: mend them first.");
  const answer = await bench.ask({ do: "write", name, entry, value });
  if (answer.refused) return say(answer.refused);
  if (view.state.doc !== doc) return;
  const { start, end, glyph } = answer.change;
  open.params = withoutNumber(open.params, name, entry);
  view.dispatch({ changes: { from: start, to: end, insert: glyph }, selection: { anchor: start, head: start + glyph.length }, scrollIntoView: true });
}

// Shows what led to the failure of a check, from its start.
async function showIt(verdict) {
  stop();
  const answer = await ask({ do: "replay", ...verdict.scenario });
  if (answer.refused) return;
  const back = element("button", { onclick: () => begin() }, "Back to the game");
  find("counterexample").replaceChildren(`The counterexample to `, element("code", {}, verdict.text), ...coded(`: it ${verdict.reason}. `), back);
  find("forward").focus();
}

function begin() {
  stop();
  const { value, validity } = find("seed");
  if (value === "" || !validity.valid) return say("a seed is a whole number from 0 to 4294967295");
  return ask({ do: "begin", seed: Number(value) });
}

async function ask(request) {
  return take(await bench.ask(request));
}

function take(answer) {
  if (answer.lost) sendText(false);
  if (answer.refused) { shown.running = false; markRunning(); say(answer.refused); return answer; }
  say("");
  if (answer.game) showGame(answer);
  if (answer.scene) { showScene(answer); refreshPanel(); }
  return answer;
}

function showScene(answer) {
  Object.assign(shown, { at: answer.at, moments: answer.moments });
  board.show(answer.scene, answer.pictures);
  curves.note(answer);
  find("scrub").max = answer.moments - 1;
  find("scrub").value = answer.at;
  find("step").textContent = `step ${answer.scene.step}` + (answer.scene.done ? ", the episode is over" : "");
  find("agents").replaceChildren(...answer.colours.map((colour, agent) => {
    const swatch = element("span", { class: "swatch" });
    swatch.style.background = colour;
    const action = answer.scene.actions.length ? open.game.actions[answer.scene.actions[agent]] : "";
    const isAway = answer.scene.places[agent] === null;
    const cells = [[swatch, `${agent} ${open.game.seats[agent] ?? ""}`.trim() + (isAway ? ", away" : "")], [action], [answer.scene.rewards[agent] || ""], [answer.scene.returns[agent]]];
    return element("tr", { class: `${agent === shown.driven ? "driven" : ""} ${isAway ? "away" : ""}` }, ...cells.map((inner) => element("td", {}, ...inner.map((part) => part instanceof Node ? part : String(part)))));
  }));
  if (!shown.running) tell(described(answer));
  find("events").textContent = answer.scene.events.map(([name, count]) => `${name} ${Array.isArray(count) ? count.reduce((a, b) => a + b, 0) : count}`).join(" · ");
}

// What a moment is like, for those who do not see the board.
function described({ scene }) {
  const paid = scene.rewards.flatMap((reward, agent) => (reward ? [`agent ${agent} got ${reward}`] : []));
  return [`Step ${scene.step}`, ...paid, ...(scene.done ? ["the episode is over"] : [])].join(", ");
}

function goTo(moment) {
  stop();
  bench.latest("go", { do: "go", to: moment }, take);
}

// Asks about a cell, and tells what is on it.
function chooseCell(row, col) {
  shown.cell = [row, col];
  shown.agent = board.agentAt([row, col]) ?? shown.agent;
  board.choose(row, col);
  find("board").focus();
  refreshPanel();
  bench.latest("cell", { do: "panel", panel: "state", row, col }, ({ cell }) => {
    const agent = board.agentAt([row, col]), fields = cell?.values.map(([name, value]) => `${name} ${value}`) ?? [];
    if (cell) tell([`Row ${row}, column ${col}: ${cell.kind}`, ...fields, ...(agent === null ? [] : [`agent ${agent}`])].join(", "));
  });
}

async function run() {
  shown.running = !shown.running;
  markRunning();
  while (shown.running) {
    const began = performance.now();
    await ask({ do: "step" });
    await board.drawn;
    await new Promise((resolve) => setTimeout(resolve, Math.max(0, 1000 / Number(find("speed").value) - (performance.now() - began))));
  }
}

function markRunning() {
  const name = shown.running ? "Pause" : "Play";
  find("run").setAttribute("aria-label", name);
  find("run").title = name;
  find("run").querySelector("use").setAttribute("href", shown.running ? "#icon-pause" : "#icon-run");
}

function stop() {
  shown.running = false;
  markRunning();
}

find("board").addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || !open.game) return;
  const way = { ArrowUp: [-1, 0], ArrowDown: [1, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] }[event.key];
  if (way && (shown.driven === null || event.shiftKey)) { event.preventDefault(); return board.move(...way); }
  const action = open.game.keys[KEYS[event.key] ?? event.key];
  if (shown.driven === null || action === undefined) return;
  event.preventDefault();
  stop();
  ask({ do: "step", actions: { [shown.driven]: action } });
});
find("run").addEventListener("click", run);
find("back").addEventListener("click", () => { stop(); ask({ do: "go", to: shown.at - 1 }); });
find("forward").addEventListener("click", () => { stop(); ask(shown.at + 1 < shown.moments ? { do: "go", to: shown.at + 1 } : { do: "step" }); });
find("scrub").addEventListener("input", () => goTo(Number(find("scrub").value)));
find("again").addEventListener("click", begin);
find("seed").addEventListener("change", begin);
find("diff").addEventListener("click", () => find("tabs").querySelector('[data-panel="diff"]').click());
find("driven").addEventListener("change", () => { shown.driven = find("driven").value === "" ? null : Number(find("driven").value); find("board").focus(); showKeys(); });
find("others").addEventListener("change", async () => {
  stop();
  const policy = find("others").value, answer = await ask({ do: "others", policy });
  if (answer.refused) find("others").value = open.game.others;
  else open.game.others = policy;
});
find("variant").addEventListener("change", () => { open.variants = find("variant").value ? find("variant").value.split("+") : []; sendText(false); });
find("glyph").addEventListener("change", () => { board.painting = find("glyph").value !== ""; });
find("crew").addEventListener("change", () => {
  const { value, validity } = find("crew");
  if (!validity.valid) return say("a number of agents is a whole number from 1 to 1000; without one it is what the text says");
  open.agents = value === "" ? null : Number(value);
  sendText(false);
});
find("save-as").addEventListener("click", saveAs);
window.addEventListener("focus", lookAgain);
find("save").addEventListener("click", () => save());
find("share").addEventListener("click", () => download("share", ({ html }) => [html, "text/html"]));
find("record").addEventListener("click", () => download("record", ({ recording }) => [recording, "application/json"]));
window.addEventListener("beforeunload", (event) => { if (view && isUnsaved() && !open.isKept) event.preventDefault(); });
window.addEventListener("hashchange", () => { if (addressed() && addressed() !== open.path) openSafely(addressed()); });

// Offers what the bench makes of the episode as a file. contentOf: its text and type, of the answer.
async function download(what, contentOf) {
  const answer = await bench.ask({ do: what });
  if (answer.refused) return say(answer.refused);
  const [text, type] = contentOf(answer);
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type })), download: answer.name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

function showKeys() {
  const keys = shown.driven === null ? [] : Object.entries(open.game?.keys ?? {});
  const names = keys.map(([key, action]) => element("span", { class: "key" }, element("kbd", {}, CAPS[key] ?? key), ` ${open.game.actions[action]} `));
  find("keys").replaceChildren(...(names.length ? ["With the board in focus: ", ...names] : []));
}

// ---- beside the board

async function refreshPanel() {
  const name = shown.panel, lasting = LASTING.has(name);
  clearTimeout(refreshPanel.timer);
  refreshPanel.timer = setTimeout(() => { if (!find("panel").childElementCount) find("panel").replaceChildren(working()); }, SOON);
  if (name === "tour") { if (beside.kept !== name) { beside.kept = name; showTour(find("panel"), files, openSafely, () => shown.panel === "tour"); } return; }
  if (!open.game || (lasting && !beside.stale && beside.kept === name)) return;
  const asked = { do: "panel", panel: ASKED[name] ?? name, agent: shown.agent };
  if (name === "state" && shown.cell) Object.assign(asked, { row: shown.cell[0], col: shown.cell[1] });
  if (lasting && beside.busy) { beside.again = true; return; }
  if (lasting) await openBeside(name);
  const answer = await (lasting ? beside : bench).ask(asked);
  if (lasting) { beside.busy = false; if (beside.again) { beside.again = false; refreshPanel(); } }
  if (name !== shown.panel) return;
  if (answer.refused) return find("panel").replaceChildren(element("p", {}, ...coded(answer.refused)));
  beside.kept = name;
  endProgram();
  const cell = shown.cell, agent = cell ? board.agentAt(cell) : null;
  fill(find("panel"), name, { answer, board, cell, agent, toLine, showIt, line: lineHere(), count: open.game.agents, chooseAgent: (chosen) => { shown.agent = chosen; refreshPanel(); }, keep: (made) => { program = made; } });
}

async function openBeside(name) {
  beside.busy = true;
  beside.stale = false;
  if (name === "checks") find("panel").replaceChildren(element("p", {}, "Playing the checks…"), working());
  await beside.ask({ do: "text", version: open.version, ...asItIs() });
}

function lineHere() {
  return view ? view.state.doc.lineAt(view.state.selection.main.head).number : null;
}

function endProgram() {
  program?.end();
  program = null;
}

function showPanel(name) {
  shown.panel = name;
  for (const tab of find("tabs").children) {
    const isShown = tab.dataset.panel === name;
    tab.setAttribute("aria-selected", String(isShown));
    tab.tabIndex = isShown ? 0 : -1;
    if (isShown) tab.scrollIntoView({ block: "nearest", inline: "center" });
  }
  find("panel").setAttribute("aria-labelledby", `tab-${name}`);
  endProgram();
  find("panel").replaceChildren();
  beside.kept = null;
  refreshPanel();
}

for (const [name, title] of Object.entries(PANELS)) {
  find("tabs").append(element("button", { role: "tab", id: `tab-${name}`, "data-panel": name, "aria-controls": "panel", onclick: () => showPanel(name) }, title));
}
find("tabs").addEventListener("keydown", (event) => {
  const tabs = [...find("tabs").children], at = tabs.indexOf(document.activeElement);
  const to = { ArrowRight: at + 1, ArrowLeft: at - 1 + tabs.length, Home: 0, End: tabs.length - 1 }[event.key];
  if (to === undefined) return;
  event.preventDefault();
  const tab = tabs[to % tabs.length];
  tab.focus();
  tab.click();
});

// ---- messages, and the beginning

function say(message) {
  find("message").replaceChildren(...coded(message));
}

function lost(gone) {
  find("lost").hidden = !gone;
}

// Says something to screen readers alone.
function tell(message) {
  find("said").textContent = message;
}

function markBusy(who, busy) {
  markBusy.who ??= new Set();
  if (busy) markBusy.who.add(who); else markBusy.who.delete(who);
  if (busy) markBusy.timer ??= setTimeout(() => { find("busy").hidden = false; }, SLOW);
  if (!markBusy.who.size) { clearTimeout(markBusy.timer); markBusy.timer = null; find("busy").hidden = true; }
}

async function speak() {
  try {
    language = await connectLanguage("/language", () => { language = null; setTimeout(speak, 2000); });
  } catch {
    return setTimeout(speak, 5000);
  }
  if (view) view.dispatch({ effects: speech.reconfigure(spoken()) });
}

makePanes(() => board.paint());
const usual = meta("opened") || (await games.list());
const isTour = prefixOf(addressed() || usual) === "tour:"; // for somebody who has no game yet
if (isTour) showPane("panels");
showPanel(isTour ? "tour" : shown.panel);
const isOpened = addressed() !== "" && (await openFile(addressed()));
if (!isOpened) openFile(usual);
speak();
