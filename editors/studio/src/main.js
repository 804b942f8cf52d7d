// The studio: the text on the left, the board in the middle, what is asked for on the right.

import { Compartment, EditorState } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { basicSetup } from "codemirror";
import { Bench } from "./bench.js";
import { Board } from "./board.js";
import { element, find } from "./dom.js";
import { Drivers } from "./drivers.js";
import { Files } from "./files.js";
import { connectLanguage, languageOf } from "./language.js";
import { showNumbers, withNumber } from "./numbers.js";
import { painter } from "./painting.js";
import { ASKED, LASTING, PANELS, fill } from "./panels.js";
import { showTour } from "./tour.js";

const meta = (name) => document.querySelector(`meta[name="${name}"]`).content;
const files = new Files();
const KEYS = { ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right", ",": "comma", ".": "full_stop", " ": "space", Enter: "enter" };

const open = { path: "", uri: "", digest: null, saved: "", version: 0, variants: [], params: {}, game: null, map: null };
const shown = { panel: "rules", cell: null, agent: 0, driven: null, at: 0, moments: 1, running: false };
let view = null, language = null;

const bench = new Bench("/bench", { onLost: lost, onOpen: () => sendText(false) });
const beside = new Bench("/bench", { onLost: () => {}, onOpen: () => { beside.stale = true; refreshPanel(); } }); // for what takes long
beside.stale = true;
const board = new Board(find("board"), find("stage"), {
  onCell: (row, col) => { shown.cell = [row, col]; shown.agent = board.agentAt([row, col]) ?? shown.agent; board.choose(row, col); find("board").focus(); refreshPanel(); },
  onPut: (agent, row, col) => ask({ do: "put", agent, row, col }),
  onPaint: painter({
    open, files, bench, say, isExample: () => isExample(), glyph: () => find("glyph").value, view: () => view,
    changed: () => { markUnsaved(); sendText(false); },
  }),
});
const drivers = new Drivers({ files, say, ask: (request) => { stop(); return ask(request); } });

// ---- the text

async function openFile(path) {
  const file = await files.read(path);
  if (file.refused) { find("files").value = open.path; return say(file.refused); }
  say("");
  Object.assign(open, { path, uri: file.uri, digest: file.digest, saved: file.text, variants: [], params: {}, map: null });
  find("files").value = path;
  document.title = `${path} · sjdsl studio`;
  makeEditor(file.text);
  sendText(true);
}

// Opens a file, if need be after asking what becomes of a text that is not saved.
function openSafely(path) {
  if (!view || !isUnsaved()) return openFile(path);
  find("files").value = open.path;
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
  if (view) view.destroy();
  const changed = EditorView.updateListener.of((update) => {
    if (update.docChanged) { markUnsaved(); sendText(false); }
    if (update.selectionSet && shown.panel === "python") markPython();
  });
  view = new EditorView({
    state: EditorState.create({ doc: text, extensions: [basicSetup, keymap.of([{ key: "Mod-s", run: () => { save(); return true; } }]), changed, speech.of(spoken())] }),
    parent: find("text"),
  });
  markUnsaved();
}

const text = () => view.state.doc.toString();
// What stands before the path of a game that is only read: bundled, of the tour, of an installed package, whose name follows.
const prefixOf = (path) => path.match(/^(example:|tour:|package:[^/]*\/)/)?.[0] ?? "";
const isExample = () => prefixOf(open.path) !== "";

function sendText(fresh) {
  if (!view || !bench.isOpen) return;
  clearTimeout(soon.timer); // the panel waits for the answer to this text
  const version = ++open.version;
  const request = { version, ...asItIs(), fresh };
  bench.text(request, (answer) => {
    if (answer.lost && !bench.isOpen) return; // it is sent again as soon as there is a connection
    beside.stale = true;
    find("verdict").textContent = answer.refused ?? (answer.compiles ? "" : `${answer.errors} error${answer.errors > 1 ? "s" : ""}: the board shows the last rules that compiled`);
    document.body.dataset.version = version;
    document.body.dataset.compiles = answer.compiles === true;
    if (answer.refused || !answer.compiles) return;
    if (answer.game.left.length) say(`no longer numbers of this game: ${answer.game.left.join(", ")}`);
    showGame(answer.game);
    showScene(answer);
    soon();
  });
}

// Brings the panel up to date a moment after the last of many edits, so that the next one need not wait for it.
function soon() {
  clearTimeout(soon.timer);
  soon.timer = setTimeout(refreshPanel, LASTING.has(shown.panel) ? 300 : 0);
}

// What there is to open: the text and, if somebody has painted it, the file of its map.
function asItIs() {
  const over = open.map ? { [open.map.path]: open.map.text } : {};
  return { path: open.path, text: text(), variants: open.variants, params: open.params, over };
}

async function save() {
  const sent = text();
  if (isExample()) return saveCopy(sent);
  if (open.map && open.map.text !== open.map.saved) {
    const written = await files.write(open.map.path, open.map.text, open.map.digest);
    if (written.refused) return say(written.refused);
    Object.assign(open.map, { digest: written.digest, saved: open.map.text });
  }
  const answer = await files.write(open.path, sent, open.digest);
  if (answer.changed) return askAboutChange(answer.refused, sent);
  if (answer.refused) return say(answer.refused);
  Object.assign(open, { digest: answer.digest, saved: sent });
  say("");
  markUnsaved();
}

// A bundled game stays as it is: what somebody makes of it is a file of their own.
async function saveCopy(sent) {
  const name = element("input", { value: open.path.slice(prefixOf(open.path).length).split("/").pop(), "aria-label": "Name of the copy" });
  const write = element("button", { onclick: async () => {
    const answer = await files.copy(open.path, name.value, sent);
    if (answer.refused) return find("message").append(` ${answer.refused}`);
    await listGames();
    openFile(name.value);
  } }, "Save a copy");
  find("message").replaceChildren("This is an example. Save it in your folder as ", name, " ", write);
}

function askAboutChange(reason, sent) {
  const theirs = element("button", { onclick: () => openFile(open.path) }, "Open theirs, and lose mine");
  const mine = element("button", { onclick: async () => { open.digest = (await files.read(open.path)).digest ?? null; save(sent); } }, "Write mine over it");
  find("message").replaceChildren(`${reason}. `, theirs, mine);
}

function markUnsaved() {
  find("save").disabled = !view || !isUnsaved();
}

function isUnsaved() {
  return text() !== open.saved || (open.map !== null && open.map.text !== open.map.saved);
}

function toLine(number) {
  const line = view.state.doc.line(Math.min(number, view.state.doc.lines));
  view.dispatch({ selection: { anchor: line.from }, effects: EditorView.scrollIntoView(line.from, { y: "center" }) });
  view.focus();
}

// ---- the board

function showGame(game) {
  open.game = game;
  find("title").textContent = game.title;
  options(find("variant"), [["", "as it is"], ...game.variants], game.chosen.join("+"));
  find("diff").hidden = !game.chosen.length;
  find("counterexample").hidden = !game.counterexample;
  drivers.show(game);
  const nobody = shown.driven === null || shown.driven >= game.agents;
  if (nobody) shown.driven = null;
  options(find("driven"), [["", "nobody"], ...Array.from({ length: game.agents }, (_, agent) => [String(agent), `agent ${agent}`])], nobody ? "" : String(shown.driven));
  find("seed").value = game.seed;
  options(find("glyph"), [["", "nothing"], ...game.glyphs], game.glyphs.some(([glyph]) => glyph === find("glyph").value) ? find("glyph").value : "");
  showNumbers(find("numbers"), game.numbers, setNumber);
  board.begin(game);
  shown.agent = Math.min(shown.agent, game.agents - 1);
}

function options(select, pairs, chosen) {
  select.replaceChildren(...pairs.map(([value, text]) => new Option(text ? (value && text !== value ? `${value}: ${text}` : text) : value, value, false, value === chosen)));
}

async function setNumber(name, value) {
  const answer = await ask({ do: "number", name, value });
  if (answer.refused || open.game.counterexample) return;
  open.params = withNumber(open.params, name, value);
  beside.stale = true;
}

// Shows what led to the failure of a check, from its start.
async function showIt(verdict) {
  stop();
  const answer = await ask({ do: "replay", ...verdict.scenario });
  if (answer.refused) return;
  const back = element("button", { onclick: () => begin() }, "Back to the game");
  find("counterexample").replaceChildren(`The counterexample to `, element("code", {}, verdict.text), `: it ${verdict.reason}. `, back);
  find("forward").focus();
}

function begin() {
  stop();
  const { value, validity } = find("seed");
  if (value === "" || !validity.valid) return say("a seed is a whole number from 0 to 4294967295");
  return ask({ do: "begin", seed: Number(value) });
}

async function ask(request) {
  const answer = await bench.ask(request);
  if (answer.lost) sendText(false);
  if (answer.refused) { shown.running = false; markRunning(); say(answer.refused); return answer; }
  say("");
  if (answer.game) showGame(answer.game);
  if (answer.scene) { showScene(answer); refreshPanel(); }
  return answer;
}

function showScene(answer) {
  Object.assign(shown, { at: answer.at, moments: answer.moments });
  board.show(answer.scene, answer.pictures);
  find("scrub").max = answer.moments - 1;
  find("scrub").value = answer.at;
  find("step").textContent = `step ${answer.scene.step}` + (answer.scene.done ? ", the episode is over" : "");
  find("agents").replaceChildren(...answer.colours.map((colour, agent) => {
    const swatch = element("span", { class: "swatch" });
    swatch.style.background = colour;
    const action = answer.scene.actions.length ? open.game.actions[answer.scene.actions[agent]] : "";
    const cells = [[swatch, String(agent)], [action], [answer.scene.rewards[agent] || ""], [answer.scene.returns[agent]]];
    return element("tr", { class: agent === shown.driven ? "driven" : "" }, ...cells.map((inner) => element("td", {}, ...inner.map((part) => part instanceof Node ? part : String(part)))));
  }));
  find("events").textContent = answer.scene.events.map(([name, count]) => `${name} ${Array.isArray(count) ? count.reduce((a, b) => a + b, 0) : count}`).join(" · ");
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
  find("run").textContent = shown.running ? "Pause" : "Run";
}

function stop() {
  shown.running = false;
  markRunning();
}

find("board").addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey || !open.game) return;
  const action = open.game.keys[KEYS[event.key] ?? event.key];
  if (shown.driven === null || action === undefined) return;
  event.preventDefault();
  stop();
  ask({ do: "step", actions: { [shown.driven]: action } });
});
find("run").addEventListener("click", run);
find("back").addEventListener("click", () => { stop(); ask({ do: "go", to: shown.at - 1 }); });
find("forward").addEventListener("click", () => { stop(); ask(shown.at + 1 < shown.moments ? { do: "go", to: shown.at + 1 } : { do: "step" }); });
find("scrub").addEventListener("input", () => { stop(); ask({ do: "go", to: Number(find("scrub").value) }); });
find("again").addEventListener("click", begin);
find("seed").addEventListener("change", begin);
find("diff").addEventListener("click", () => find("tabs").querySelector('[data-panel="diff"]').click());
find("driven").addEventListener("change", () => { shown.driven = find("driven").value === "" ? null : Number(find("driven").value); find("board").focus(); showKeys(); });
find("variant").addEventListener("change", () => { open.variants = find("variant").value ? find("variant").value.split("+") : []; sendText(false); });
find("glyph").addEventListener("change", () => { board.painting = find("glyph").value !== ""; });
find("files").addEventListener("change", () => openSafely(find("files").value));
window.addEventListener("focus", lookAgain);
find("save").addEventListener("click", () => save());
find("share").addEventListener("click", async () => {
  const answer = await bench.ask({ do: "share" });
  if (answer.refused) return say(answer.refused);
  const link = element("a", { href: URL.createObjectURL(new Blob([answer.html], { type: "text/html" })), download: answer.name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
});
window.addEventListener("beforeunload", (event) => { if (view && isUnsaved()) event.preventDefault(); });

function showKeys() {
  const names = Object.entries(open.game?.keys ?? {}).map(([key, action]) => `${key.replace("full_stop", ".").replace("comma", ",")} ${open.game.actions[action]}`);
  find("keys").textContent = shown.driven === null ? "" : `Click on the board, then: ${names.join(", ")}`;
}

// ---- beside the board

async function refreshPanel() {
  const name = shown.panel, lasting = LASTING.has(name);
  if (name === "tour") { if (beside.kept !== name) { beside.kept = name; showTour(find("panel"), files, openSafely, () => shown.panel === "tour"); } return; }
  if (!open.game || (lasting && !beside.stale && beside.kept === name)) return;
  const asked = { do: "panel", panel: ASKED[name] ?? name, agent: shown.agent };
  if (name === "state" && shown.cell) Object.assign(asked, { row: shown.cell[0], col: shown.cell[1] });
  if (lasting && beside.busy) { beside.again = true; return; }
  if (lasting) await openBeside(name);
  const answer = await (lasting ? beside : bench).ask(asked);
  if (lasting) { beside.busy = false; if (beside.again) { beside.again = false; refreshPanel(); } }
  if (name !== shown.panel) return;
  if (answer.refused) return find("panel").replaceChildren(element("p", {}, answer.refused));
  beside.kept = name;
  const cell = shown.cell, agent = cell ? board.agentAt(cell) : null;
  fill(find("panel"), name, { answer, cell, agent, toLine, showIt, line: lineHere(), count: open.game.agents, chooseAgent: (chosen) => { shown.agent = chosen; refreshPanel(); } });
}

async function openBeside(name) {
  beside.busy = true;
  beside.stale = false;
  if (name === "checks") find("panel").replaceChildren(element("p", {}, "Playing the checks…"));
  await beside.ask({ do: "text", version: open.version, ...asItIs() });
}

function lineHere() {
  return view ? view.state.doc.lineAt(view.state.selection.main.head).number : null;
}

function markPython() {
  const line = String(lineHere());
  let first = null;
  for (const row of find("panel").querySelectorAll(".code")) {
    const here = row.dataset.line === line;
    row.classList.toggle("here", here);
    if (here) first ??= row;
  }
  first?.scrollIntoView({ block: "nearest" });
}

for (const [name, title] of Object.entries(PANELS)) {
  const tab = element("button", { role: "tab", "data-panel": name, "aria-selected": name === shown.panel }, title);
  tab.addEventListener("click", () => {
    shown.panel = name;
    for (const other of find("tabs").children) other.setAttribute("aria-selected", other === tab);
    find("panel").replaceChildren();
    beside.kept = null;
    refreshPanel();
  });
  find("tabs").append(tab);
}

// ---- messages, and the beginning

function say(message) {
  find("message").textContent = message;
}

function lost(gone) {
  find("lost").hidden = !gone;
}

async function speak() {
  try {
    language = await connectLanguage("/language", () => { language = null; setTimeout(speak, 2000); });
  } catch {
    return setTimeout(speak, 5000);
  }
  if (view) view.dispatch({ effects: speech.reconfigure(spoken()) });
}

async function listGames() {
  const { games, examples, packages, tour } = await files.games();
  const group = (label, paths) => {
    const made = element("optgroup", { label });
    made.append(...paths.map((path) => new Option(path.slice(prefixOf(path).length), path)));
    return made;
  };
  find("files").replaceChildren(group("in this folder", games), group("tour", tour), group("examples", examples), ...packages.map((p) => group(p.release, p.games)));
  if (open.path) find("files").value = open.path;
  return games[0] || tour[0];
}

const wanted = meta("opened");
const listed = listGames();
if (wanted) openFile(wanted); // without waiting for the list
const first = wanted || (await listed);
if (prefixOf(first) === "tour:") find("tabs").querySelector('[data-panel="tour"]').click(); // somebody who has no game yet
if (!wanted) openFile(first);
drivers.list();
speak();
