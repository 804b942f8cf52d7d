// How texts look and fold in the editor.

import { StreamLanguage, codeFolding, foldEffect, foldService, syntaxHighlighting } from "@codemirror/language";
import { python } from "@codemirror/legacy-modes/mode/python";
import { Compartment, EditorState, RangeSetBuilder } from "@codemirror/state";
import { Decoration, EditorView, lineNumbers } from "@codemirror/view";
import { classHighlighter } from "@lezer/highlight";
import { minimalSetup } from "codemirror";

const LONG_RUN = 4; // lines that hold only a comment, from which on they are folded when a text is opened
const WORTH_IT = 12; // characters that folding the end of a comment hides at least

// What CodeMirror calls the scopes of the grammar that have a colour.
const SCOPES = {
  "comment.line.number-sign.sj": "comment", "constant.numeric.sj": "number", "constant.language.sj": "atom",
  "storage.type.sj": "keyword", "keyword.control.sj": "keyword", "keyword.other.statement.sj": "keyword", "keyword.operator.word.sj": "keyword",
  "entity.name.type.sj": "typeName", "support.type.sj": "typeName", "support.function.sj": "macroName",
};
const written = JSON.parse(document.querySelector('meta[name="patterns"]').content); // by the server, from the language itself
const patterns = written.filter(({ match }) => match).map((pattern) => ({ ...pattern, match: new RegExp(pattern.match) }));

const sj = StreamLanguage.define({
  name: "sj",
  startState: () => ({ parts: [] }), // of the pattern that matched last: those still to come, each with its scope
  token(stream, state) {
    if (!state.parts.length) {
      if (stream.match(/"(?:[^"\\]|\\.)*"?/)) return "string";
      for (const { match, name, captures } of patterns) {
        const found = stream.match(match, false);
        if (!found) continue;
        if (captures) state.parts = Object.entries(captures).map(([group, scope]) => [found[group], scope.name]).filter(([text]) => text);
        else state.parts = [[found[0], name]];
        break;
      }
    }
    const [text, scope] = state.parts.shift() ?? [/\w+|[^]/u, null];
    stream.match(text);
    return SCOPES[scope] ?? null;
  },
  languageData: { commentTokens: { line: "#" } },
});

// Colours are those of studio.css, which knows light and dark; CodeMirror has to know which, for what it draws by itself.
const dark = matchMedia("(prefers-color-scheme: dark)");
const shade = new Compartment();
const shadeNow = () => EditorView.darkTheme.of(dark.matches);
const look = [shade.of(shadeNow()), syntaxHighlighting(classHighlighter)];

export function followShade(view) {
  const follow = () => view.dispatch({ effects: shade.reconfigure(shadeNow()) });
  dark.addEventListener("change", follow);
  return () => dark.removeEventListener("change", follow);
}

const withoutTexts = (line) => line.replace(/"(?:[^"\\]|\\.)*"|#.*/g, "");
const isComment = (line) => /^\s*#/.test(line);

// Blocks in braces over several lines, and runs of comments.
const folds = foldService.of(({ doc }, from) => {
  const first = doc.lineAt(from);
  if (isComment(first.text)) {
    if (first.number > 1 && isComment(doc.line(first.number - 1).text)) return null;
    const last = endOfComments(doc, first.number);
    return last > first.number ? { from: first.to, to: doc.line(last).to } : null;
  }
  let depth = 0;
  for (let number = first.number; number <= doc.lines; number++) {
    for (const sign of withoutTexts(doc.line(number).text).match(/[{}]/g) ?? []) depth = Math.max(0, depth + (sign === "{" ? 1 : -1));
    if (depth === 0) return number > first.number + 1 ? { from: first.to, to: doc.line(number - 1).to } : null;
  }
  return null;
});

function endOfComments(doc, number) {
  while (number < doc.lines && isComment(doc.line(number + 1).text)) number++;
  return number;
}

// Folds what is long when a text is opened: runs of comments, and the end of a comment behind code that the pane has no room for.
export function foldLongComments(view) {
  const { doc } = view.state, effects = [];
  const gutters = view.dom.querySelector(".cm-gutters")?.offsetWidth ?? 0;
  const columns = Math.floor((view.scrollDOM.clientWidth - gutters) / view.defaultCharacterWidth) - 5;
  for (let number = 1; number <= doc.lines; number++) {
    const line = doc.line(number);
    if (isComment(line.text)) {
      const last = endOfComments(doc, number);
      if (last - number + 1 >= LONG_RUN) effects.push(foldEffect.of({ from: line.to, to: doc.line(last).to }));
      number = last;
      continue;
    }
    const at = line.text.replace(/"(?:[^"\\]|\\.)*"/g, (quoted) => "_".repeat(quoted.length)).indexOf("#");
    const from = Math.max(at + 1, columns);
    if (at >= 0 && line.length - from >= WORTH_IT) effects.push(foldEffect.of({ from: line.from + from, to: line.to }));
  }
  if (effects.length) view.dispatch({ effects });
}

const placeholder = codeFolding({
  placeholderDOM(view, onclick) {
    const made = document.createElement("span");
    Object.assign(made, { className: "cm-foldPlaceholder", textContent: "…", title: "Unfold", onclick });
    return made;
  },
});

export const language = [sj, folds, placeholder, look];

// A program that is read only. lines: each [text, line of the game that it comes from, or null]; toLine: called with that of a line that is clicked.
export function pythonView(parent, lines, toLine) {
  const mark = new Compartment();
  const marked = (line) => {
    const rows = new RangeSetBuilder(), doc = view ? view.state.doc : null;
    if (doc && line !== null) lines.forEach(([, from], row) => { if (from === line) { const at = doc.line(row + 1).from; rows.add(at, at, Decoration.line({ class: "here" })); } });
    return EditorView.decorations.of(rows.finish());
  };
  let view = null;
  view = new EditorView({
    parent,
    state: EditorState.create({
      doc: lines.map(([text]) => text).join("\n"),
      extensions: [
        minimalSetup, lineNumbers(), StreamLanguage.define(python), look, mark.of([]), EditorState.readOnly.of(true), EditorView.editable.of(false),
        EditorView.contentAttributes.of({ "aria-label": "The generated program", tabindex: "0", role: "textbox", "aria-multiline": "true", "aria-readonly": "true" }),
        EditorView.domEventHandlers({
          click(event, here) {
            const at = here.posAtCoords({ x: event.clientX, y: event.clientY });
            const from = at === null ? null : lines[here.state.doc.lineAt(at).number - 1][1];
            if (from !== null) toLine(from);
          },
        }),
      ],
    }),
  });
  const unfollow = followShade(view);
  return {
    // Marks what comes from a line of the game, and shows the first of it.
    show(line) {
      const inside = lines.findIndex(([text, from]) => from === line && text.startsWith(" ")); // a function, where there is one
      const first = inside >= 0 ? inside : lines.findIndex(([, from]) => from === line), effects = [mark.reconfigure(marked(line))];
      if (first >= 0) effects.push(EditorView.scrollIntoView(view.state.doc.line(first + 1).from, { y: "center" }));
      view.dispatch({ effects });
    },
    end() { unfollow(); view.destroy(); },
  };
}
