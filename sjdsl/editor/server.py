"""The language server: messages of the Language Server Protocol, carried by pygls, to and from one session."""

import asyncio
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.lsp.server import LanguageServer

from sjdsl.editor import completion
from sjdsl.editor.documents import path_of
from sjdsl.editor.navigation import Refused
from sjdsl.editor.session import Session
from sjdsl.version import __version__

QUIET = 0.01  # seconds without a change before a text is looked at, so that of many fast ones only the last costs anything
PATIENCE = 0.3  # seconds after which it is looked at whatever comes
REQUEST_FAILED = -32803  # ErrorCodes.RequestFailed of the protocol


class Server(LanguageServer):
    """A session and the tasks that look at its texts."""

    def __init__(self, inside: Sequence[Path] | None) -> None:
        super().__init__(
            "sjdsl", __version__, text_document_sync_kind=types.TextDocumentSyncKind.Full
        )
        self.inside = inside
        self.session = Session(inside=inside)
        self.shut_down = False  # the client has asked for the end
        self.ended_early = False  # it says `exit` without that
        self._waiting: dict[
            str, float
        ] = {}  # URI -> when it changed first since it was last looked at
        self._changed: dict[str, float] = {}  # and when it changed last
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def begin(self, params: types.InitializeParams) -> None:
        """Takes over what the client says of itself."""
        uris = [folder.uri for folder in params.workspace_folders or []] or [
            uri for uri in [params.root_uri] if uri
        ]
        encoding = str(
            getattr(self.workspace.position_encoding, "value", self.workspace.position_encoding)
            or "utf-16"
        )
        self.session = Session(
            encoding, [p for p in map(path_of, uris) if p is not None], self.inside
        )

    def watch_files(self) -> None:
        """Has the client tell of changes of games and maps on the disk, if it can."""
        workspace = self.client_capabilities.workspace
        watched = workspace.did_change_watched_files if workspace else None
        if watched is not None and watched.dynamic_registration:
            watchers = [types.FileSystemWatcher(f"**/*.{suffix}") for suffix in ("sj", "txt")]
            options = types.DidChangeWatchedFilesRegistrationOptions(watchers)
            wanted = types.Registration("files", types.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
            self.client_register_capability(types.RegistrationParams([wanted]))

    def change_folders(self, change: types.WorkspaceFoldersChangeEvent) -> None:
        """Takes over which folders the client has open now."""
        gone, come = (
            [path_of(folder.uri) for folder in folders]
            for folders in (change.removed, change.added)
        )
        kept = [folder for folder in self.session.folders if folder not in gone]
        self.session.folders = [*kept, *(path for path in come if path is not None)]

    def opened(
        self, document: types.TextDocumentItem | types.VersionedTextDocumentIdentifier, text: str
    ) -> None:
        """Takes over a text that is opened or changed: the client sends the whole of it each time."""
        self.session.open(document.uri, text, document.version)
        self.look_at_those_on(document.uri)

    def look_at_those_on(self, uri: str, itself: bool = True) -> None:
        """Has texts looked at again whose messages may differ when a text or a file has changed."""
        self.look_at([other for other in self.session.affected_by(uri) if itself or other != uri])

    def look_at(self, uris: list[str]) -> None:
        """Has texts looked at soon, each by one task at a time."""
        now = asyncio.get_running_loop().time()
        for uri in uris:
            self._waiting.setdefault(uri, now)
            self._changed[uri] = now
            if uri not in self._tasks or self._tasks[uri].done():
                self._tasks[uri] = asyncio.ensure_future(self._look(uri))

    async def _look(self, uri: str) -> None:
        while uri in self._waiting:
            now = asyncio.get_running_loop().time
            while now() - self._changed[uri] < QUIET and now() - self._waiting[uri] < PATIENCE:
                await asyncio.sleep(QUIET)
            del self._waiting[uri]
            await self._publish(uri)

    async def _publish(self, uri: str) -> None:
        """Sends the messages about a text: at once those of the game as it is, at last those of all variants; none of an older text."""
        document = self.session.documents.get(uri)
        sent = last = None
        for found in self.session.diagnosed(uri):
            await asyncio.sleep(0.001)  # what has come in the meantime goes first
            if document is None or uri in self._waiting or not self.session.documents.is_open(uri):
                return
            last = found
            if sent is None:
                self.send(uri, document.version, found)
                sent = found
        if document is not None and last is not None and last != sent:
            self.send(uri, document.version, last)

    def send(self, uri: str, version: int | None, found: list[types.Diagnostic]) -> None:
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, found, version))

    def closed(self, uri: str) -> None:
        """Takes back the messages about a text that is closed."""
        others = [other for other in self.session.affected_by(uri) if other != uri]
        self.session.close(uri)
        self._waiting.pop(uri, None)
        self.send(uri, None, [])
        self.look_at(others)


def make_server(inside: Sequence[Path] | None = None) -> Server:
    """Returns a server with everything registered; `start_io` runs it. `inside`: the folders in which it reads files, None for all."""
    server = Server(inside)

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def files(ls: Server, params: types.DidChangeWatchedFilesParams) -> None:
        for change in params.changes:
            ls.look_at_those_on(change.uri, itself=False)

    @server.feature(types.SHUTDOWN)
    def shut_down(ls: Server, _params: None) -> None:
        ls.shut_down = True

    @server.feature(types.EXIT)
    def leave(ls: Server, _params: None) -> None:
        ls.ended_early = not ls.shut_down

    def at(params: Any) -> tuple[str, types.Position]:
        return params.text_document.uri, params.position

    def rename(
        ls: Server, uri: str, position: types.Position, new_name: str
    ) -> types.WorkspaceEdit:
        try:
            return ls.session.rename(uri, position, new_name)
        except Refused as reason:  # the client shows the message of an error
            raise JsonRpcException(str(reason), REQUEST_FAILED) from None

    answers: dict[str, Callable[[Server, Any], Any]] = {
        types.INITIALIZE: lambda ls, params: ls.begin(params),
        types.INITIALIZED: lambda ls, _params: ls.watch_files(),
        types.TEXT_DOCUMENT_DID_OPEN: lambda ls, params: ls.opened(
            params.text_document, params.text_document.text
        ),
        types.TEXT_DOCUMENT_DID_CHANGE: lambda ls, params: ls.opened(
            params.text_document, params.content_changes[-1].text
        ),
        types.TEXT_DOCUMENT_DID_SAVE: lambda ls, params: ls.look_at_those_on(
            params.text_document.uri
        ),
        types.TEXT_DOCUMENT_DID_CLOSE: lambda ls, params: ls.closed(params.text_document.uri),
        types.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS: lambda ls, params: ls.change_folders(
            params.event
        ),
        types.TEXT_DOCUMENT_COMPLETION: lambda ls, params: types.CompletionList(
            False, ls.session.completion(*at(params))
        ),
        types.TEXT_DOCUMENT_HOVER: lambda ls, params: ls.session.hover(*at(params)),
        types.TEXT_DOCUMENT_DEFINITION: lambda ls, params: ls.session.definition(*at(params)),
        types.TEXT_DOCUMENT_REFERENCES: lambda ls, params: ls.session.references(
            *at(params), params.context.include_declaration
        ),
        types.TEXT_DOCUMENT_DOCUMENT_SYMBOL: lambda ls, params: ls.session.symbols(
            params.text_document.uri
        ),
        types.TEXT_DOCUMENT_CODE_ACTION: lambda ls, params: ls.session.quick_fixes(
            params.text_document.uri, params.range
        ),
        types.TEXT_DOCUMENT_FORMATTING: lambda ls, params: ls.session.formatting(
            params.text_document.uri
        ),
        types.TEXT_DOCUMENT_RENAME: lambda ls, params: rename(ls, *at(params), params.new_name),
    }
    options: dict[str, Any] = {
        types.TEXT_DOCUMENT_COMPLETION: types.CompletionOptions(
            trigger_characters=list(completion.TRIGGERS)
        ),
        types.TEXT_DOCUMENT_CODE_ACTION: types.CodeActionOptions(
            code_action_kinds=[types.CodeActionKind.QuickFix]
        ),
    }
    for message, answer in answers.items():
        server.feature(message, options.get(message))(answer)

    return server
