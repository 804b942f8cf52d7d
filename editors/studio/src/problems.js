// What is wrong with the text, in a strip under it: each message with its line and its repairs; a click leads there.

import { EditorView } from "@codemirror/view";
import { diagnosticsOf } from "./language.js";
import { coded, element, find } from "./dom.js";

const PATIENCE = 350; // milliseconds until a new message is listed: most mistakes are words that somebody is just writing

export class Problems {
  // view: asked for the editor; toLine: leads to a line; say: tells those who cannot see the strip.
  constructor({ view, toLine, say }) {
    Object.assign(this, { view, toLine, say });
    this.told = []; // of the process that plays the game, each [line or null, message]: it knows of numbers that were chosen beside the text
    this.errors = 0;
    this.listed = "";
  }

  // The answer to a text: how many errors it has, and the first of them.
  answered({ errors = 0, problems = [], refused }) {
    this.told = refused ? [[null, refused]] : problems;
    this.errors = refused ? 1 : errors;
    const count = `${this.errors} error${this.errors > 1 ? "s" : ""}`;
    find("verdict").replaceChildren(...coded(refused ?? (this.errors ? `${count}: the board shows the last rules that compiled` : "")));
    this.show();
  }

  // Lists what there is now; sooner where something has gone than where something has come.
  show() {
    clearTimeout(this.timer);
    const rows = this.rows(), few = rows.length <= find("problems").childElementCount;
    this.timer = setTimeout(() => this.list(rows), few ? 0 : PATIENCE);
  }

  rows() {
    const view = this.view();
    if (!view) return [];
    const { doc } = view.state;
    const found = diagnosticsOf(view.state).map(({ from, severity, message, actions = [] }) => ({ line: doc.lineAt(from).number, from, severity, message, actions }));
    const more = this.told.filter(([line, message]) => !found.some((row) => row.line === line && row.message.endsWith(message)));
    const rows = [...found, ...more.map(([line, message]) => ({ line, from: null, severity: "error", message, actions: [] }))];
    return rows.sort((a, b) => (a.severity === "error" ? 0 : 1) - (b.severity === "error" ? 0 : 1) || (a.line ?? 0) - (b.line ?? 0));
  }

  list(rows) {
    const view = this.view(), place = find("problems"), warnings = rows.filter((row) => row.severity !== "error").length;
    const signature = JSON.stringify(rows.map(({ line, message, actions }) => [line, message, actions.map((action) => action.name)]));
    find("warned").textContent = warnings ? `${warnings} warning${warnings > 1 ? "s" : ""}` : rows.length ? "" : "No problems";
    find("problems-box").classList.toggle("wrong", rows.length > warnings);
    if (signature === this.listed) return;
    this.listed = signature;
    const [first] = rows;
    this.say(first && first.severity === "error" ? `${first.line ? `Line ${first.line}: ` : ""}${first.message}` : "");
    place.replaceChildren(...rows.map((row) => {
      const [what, ...help] = row.message.split("\nhelp: ");
      const go = element("button", { class: "go", disabled: row.line === null, onclick: () => this.toLine(row.line, row.from) },
        element("span", { class: `line ${row.severity}` }, row.line === null ? "–" : `line ${row.line}`),
        element("span", {}, element("span", { class: "what" }, ...coded(what)), ...help.map((text) => element("span", { class: "help" }, ...coded(text)))));
      const repairs = row.actions.map((action) => element("button", { class: "fix", title: action.name, onclick: () => action.apply(view, row.from, row.from) }, element("span", {}, ...coded(`Fix: ${action.name}`))));
      return element("li", {}, go, ...repairs);
    }));
    if (view?.hasFocus) view.dispatch({ effects: EditorView.scrollIntoView(view.state.selection.main.head) }); // the strip may have grown over it
  }
}
