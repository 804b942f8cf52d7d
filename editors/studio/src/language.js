// The language server, over a socket: messages, completion, hover, definitions, renaming and layout.

import { forEachDiagnostic, lintGutter, linter, setDiagnostics } from "@codemirror/lint";
import {
  LSPClient, LSPPlugin, findReferencesKeymap, formatKeymap, hoverTooltips, jumpToDefinitionKeymap, renameKeymap, serverCompletion, serverDiagnostics,
  signatureHelp,
} from "@codemirror/lsp-client";
import { keymap } from "@codemirror/view";
import DOMPurify from "dompurify";
import { coded, element } from "./dom.js";
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
        extensions: [
          serverCompletion(), hoverTooltips(), signatureHelp(), mistakes(),
          keymap.of([...formatKeymap, ...renameKeymap, ...jumpToDefinitionKeymap, ...findReferencesKeymap]),
        ],
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
  return client.plugin(uri, "sj");
}

// ---- mistakes: lines under the words, marks in the gutter, and what stands first where the pointer rests

const tooltipFilter = (diagnostics) => {
  for (const diagnostic of diagnostics) diagnostic.renderMessage ??= () => element("span", {}, ...coded(diagnostic.message));
  return diagnostics;
};
export const lint = [linter(null, { tooltipFilter }), lintGutter({ tooltipFilter })];

const QUIET = 400; // milliseconds without a change until repairs are asked for, which costs more than messages
const MOST_REPAIRED = 10; // messages for which repairs are asked

// Shows messages as lsp-client does, with the repairs that the server offers a moment later.
function mistakes() {
  const shown = serverDiagnostics(), sort = "textDocument/publishDiagnostics";
  let timer = null;
  return {
    ...shown,
    notificationHandlers: {
      [sort](client, params) {
        const taken = shown.notificationHandlers[sort](client, params), view = client.workspace.getFile(params.uri)?.getView();
        clearTimeout(timer);
        if (taken && view && params.diagnostics.length) timer = setTimeout(() => offerRepairs(client, view), QUIET);
        return taken;
      },
    },
  };
}

async function offerRepairs(client, view) {
  const doc = view.state.doc, found = diagnosticsOf(view.state), plugin = LSPPlugin.get(view);
  let some = false;
  for (const diagnostic of found.slice(0, MOST_REPAIRED)) {
    if (!plugin || view.state.doc !== doc) return;
    const repairs = (await repairsOf(client, plugin, diagnostic)).filter((action) => action.diagnostics?.some((own) => own.message === diagnostic.message));
    diagnostic.actions = repairs.map(({ title }) => ({ name: title, apply: (here, from, to) => repair(client, here, { from, to }, title) }));
    some ||= repairs.length > 0;
  }
  if (some && view.state.doc === doc && LSPPlugin.get(view)) view.dispatch(setDiagnostics(view.state, found));
}

function repairsOf(client, plugin, { from, to }) {
  client.sync();
  const range = { start: plugin.toPosition(from), end: plugin.toPosition(to) };
  const asked = { textDocument: { uri: plugin.uri }, range, context: { diagnostics: [] } };
  return client.request("textDocument/codeAction", asked).then((actions) => actions ?? [], () => []);
}

// Makes the change of a repair, asked for again: the text may have changed since it was offered.
async function repair(client, view, place, title) {
  const plugin = LSPPlugin.get(view), doc = view.state.doc;
  const action = plugin && (await repairsOf(client, plugin, place)).find((offered) => offered.title === title);
  if (!action || view.state.doc !== doc) return;
  const edits = action.edit.documentChanges.flatMap((change) => change.edits);
  const changes = edits.map(({ range, newText }) => ({ from: plugin.fromPosition(range.start), to: plugin.fromPosition(range.end), insert: newText }));
  view.dispatch({ changes, userEvent: "input.repair" });
  view.focus();
}

// Returns the messages about a text, each where it stands now.
export function diagnosticsOf(state) {
  const found = [];
  forEachDiagnostic(state, (diagnostic, from, to) => found.push({ ...diagnostic, from, to }));
  return found;
}
