// The language server, over a socket: messages, completion, hover, definitions, renaming, layout, and colours by meaning.

import { LSPClient, languageServerExtensions } from "@codemirror/lsp-client";
import { StateEffect, StateField } from "@codemirror/state";
import { Decoration, EditorView, ViewPlugin } from "@codemirror/view";
import DOMPurify from "dompurify";
import { openSocket } from "./transport.js";

// Resolves to a client that is connected. lost: called when the connection ends.
export function connectLanguage(path, lost) {
  return new Promise((resolve, reject) => {
    const socket = openSocket(path);
    const handlers = new Set();
    socket.addEventListener("message", (event) => handlers.forEach((handle) => handle(event.data)));
    socket.addEventListener("error", reject);
    socket.addEventListener("close", lost);
    socket.addEventListener("open", () => {
      const client = new LSPClient({
        extensions: [...languageServerExtensions()],
        sanitizeHTML: (html) => DOMPurify.sanitize(html),
        timeout: 60_000, // a busy machine takes long to start it; to begin again would take longer
      });
      client.connect({
        send: (message) => socket.send(message),
        subscribe: (handler) => handlers.add(handler),
        unsubscribe: (handler) => handlers.delete(handler),
      });
      client.initializing.then(() => resolve(client), reject);
    });
  });
}

// What an editor needs to speak of one text.
export function languageOf(client, uri) {
  return [client.plugin(uri, "sj"), coloursOf(client, uri)];
}

const setColours = StateEffect.define();
const colours = StateField.define({
  create: () => Decoration.none,
  update(value, transaction) {
    for (const effect of transaction.effects) if (effect.is(setColours)) return effect.value;
    return value.map(transaction.changes);
  },
  provide: (field) => EditorView.decorations.from(field),
});

// Asks for the colours of words a moment after each change.
function coloursOf(client, uri) {
  const plugin = ViewPlugin.define((view) => {
    let timer = null, alive = true;
    const ask = async () => {
      const doc = view.state.doc;
      client.sync();
      const { types } = client.serverCapabilities?.semanticTokensProvider?.legend
        ? { types: client.serverCapabilities.semanticTokensProvider.legend.tokenTypes } : { types: [] };
      if (!types.length) return;
      const found = await client.request("textDocument/semanticTokens/full", { textDocument: { uri } }).catch(() => null);
      if (alive && found && view.state.doc === doc) view.dispatch({ effects: setColours.of(decorate(doc, found.data, types)) });
    };
    const soon = () => { clearTimeout(timer); timer = setTimeout(ask, 60); };
    soon();
    return { update(update) { if (update.docChanged) soon(); }, destroy() { alive = false; clearTimeout(timer); } };
  });
  return [colours, plugin];
}

// Each word has five numbers: lines and characters after the one before, its length, its type, its modifiers.
function decorate(doc, data, types) {
  const found = [];
  let line = 0, character = 0;
  for (let i = 0; i + 4 < data.length; i += 5) {
    character = data[i] ? data[i + 1] : character + data[i + 1];
    line += data[i];
    if (line >= doc.lines) break;
    const from = doc.line(line + 1).from + character, to = from + data[i + 2];
    if (to <= doc.length && to > from) found.push(Decoration.mark({ class: `sj-${types[data[i + 3]]}` }).range(from, to));
  }
  return Decoration.set(found, true);
}
