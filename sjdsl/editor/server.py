"""The language server: passes messages of the Language Server Protocol to one session, by pygls."""

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
from sjdsl.editor.positions import UTF16
from sjdsl.editor.session import Session
from sjdsl.version import __version__

QUIET = 0.01  # seconds without a change before a text is checked: of many fast ones, only the last
PATIENCE = 0.3  # seconds after which it is checked even if it still changes
REQUEST_FAILED = -32803  # ErrorCodes.RequestFailed of the protocol


class Server(LanguageServer):
    """A session and the tasks that check its texts.

    allowed: the folders in which files may be read; None: anywhere.
    """

    def __init__(self, allowed: Sequence[Path] | None) -> None:
        super().__init__(
            "sjdsl", __version__, text_document_sync_kind=types.TextDocumentSyncKind.Full
        )
        self.allowed = allowed
        self.session = Session(allowed=allowed)
        self.shut_down = False  # whether the client has sent `shutdown`
        self.ended_early = False  # whether it has sent `exit` without `shutdown`
        self._waiting: dict[str, float] = {}  # URI -> its first change since it was checked
        self._changed: dict[str, float] = {}  # URI -> its last change
        self._tasks: dict[str, asyncio.Task[None]] = {}

    def begin(self, params: types.InitializeParams) -> None:
        """Starts a session with the folders and the encoding of the client."""
        uris = [folder.uri for folder in params.workspace_folders or []]
        if not uris and params.root_uri:
            uris = [params.root_uri]
        encoding = self.workspace.position_encoding or UTF16
        folders = [path for path in map(path_of, uris) if path is not None]
        self.session = Session(str(getattr(encoding, "value", encoding)), folders, self.allowed)

    def watch_files(self) -> None:
        """Asks the client to report changes of games and maps on the disk, if it can."""
        workspace = self.client_capabilities.workspace
        watched = workspace.did_change_watched_files if workspace else None
        if watched is not None and watched.dynamic_registration:
            watchers = [types.FileSystemWatcher(f"**/*.{suffix}") for suffix in ("sj", "txt")]
            options = types.DidChangeWatchedFilesRegistrationOptions(watchers)
            wanted = types.Registration("files", types.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
            self.client_register_capability(types.RegistrationParams([wanted]))

    def change_folders(self, change: types.WorkspaceFoldersChangeEvent) -> None:
        """Updates the folders that the client has open."""
        removed = [path_of(folder.uri) for folder in change.removed]
        added = [path_of(folder.uri) for folder in change.added]
        kept = [folder for folder in self.session.folders if folder not in removed]
        self.session.folders = [*kept, *(path for path in added if path is not None)]

    def opened(
        self, document: types.TextDocumentItem | types.VersionedTextDocumentIdentifier, text: str
    ) -> None:
        """Takes over a text that is opened or changed; the client sends all of it each time."""
        self.session.open(document.uri, text, document.version)
        self.check(self.session.affected_by(document.uri))

    def file_changed(self, uri: str) -> None:
        """Checks the texts that read a file which changed on the disk."""
        self.check([text for text in self.session.affected_by(uri) if text != uri])

    def check(self, uris: list[str]) -> None:
        """Schedules texts to be checked soon, each by one task at a time."""
        now = asyncio.get_running_loop().time()
        for uri in uris:
            self._waiting.setdefault(uri, now)
            self._changed[uri] = now
            if uri not in self._tasks or self._tasks[uri].done():
                self._tasks[uri] = asyncio.ensure_future(self._check_when_quiet(uri))

    async def _check_when_quiet(self, uri: str) -> None:
        """Checks a text once it hasn't changed for a moment, as long as it changes again."""
        while uri in self._waiting:
            now = asyncio.get_running_loop().time
            while now() - self._changed[uri] < QUIET and now() - self._waiting[uri] < PATIENCE:
                await asyncio.sleep(QUIET)
            del self._waiting[uri]
            await self._publish(uri)

    async def _publish(self, uri: str) -> None:
        """Sends the messages about a text: first without variants, at last with all of them.

        It stops when the text has changed again.
        """
        documents = self.session.documents
        document = documents.get(uri)
        if document is None:
            return
        sent: list[types.Diagnostic] | None = None
        latest: list[types.Diagnostic] | None = None
        for latest in self.session.diagnosed(uri):
            await asyncio.sleep(0.001)  # messages that have arrived meanwhile go first
            if uri in self._waiting or not documents.is_open(uri):
                return
            if sent is None:
                sent = latest
                self.send(uri, document.version, sent)
        if latest is not None and latest != sent:
            self.send(uri, document.version, latest)

    def send(self, uri: str, version: int | None, diagnostics: list[types.Diagnostic]) -> None:
        """Sends the messages about a text; the client shows only the last ones sent."""
        params = types.PublishDiagnosticsParams(uri, diagnostics, version)
        self.text_document_publish_diagnostics(params)

    def closed(self, uri: str) -> None:
        """Takes back the messages about a text that is closed."""
        others = [text for text in self.session.affected_by(uri) if text != uri]
        self.session.close(uri)
        self._waiting.pop(uri, None)
        self.send(uri, None, [])
        self.check(others)


def make_server(allowed: Sequence[Path] | None = None) -> Server:
    """Returns a server with all its handlers; `start_io` runs it.

    Args:
      allowed: the folders in which it may read files; None: anywhere.
    """
    server = Server(allowed)

    @server.feature(types.WORKSPACE_DID_CHANGE_WATCHED_FILES)
    def files_changed(ls: Server, params: types.DidChangeWatchedFilesParams) -> None:
        for change in params.changes:
            ls.file_changed(change.uri)

    @server.feature(types.SHUTDOWN)
    def shut_down(ls: Server, _params: None) -> None:
        ls.shut_down = True

    @server.feature(types.EXIT)
    def leave(ls: Server, _params: None) -> None:
        ls.ended_early = not ls.shut_down

    @server.feature(types.TEXT_DOCUMENT_RENAME)
    def rename(ls: Server, params: types.RenameParams) -> types.WorkspaceEdit:
        try:
            return ls.session.rename(params.text_document.uri, params.position, params.new_name)
        except Refused as reason:  # the client shows the message of an error
            raise JsonRpcException(str(reason), REQUEST_FAILED) from None

    def place(params: Any) -> tuple[str, types.Position]:
        """Returns the text and the position that a message is about."""
        return params.text_document.uri, params.position

    handlers: dict[str, Callable[[Server, Any], Any]] = {
        types.INITIALIZE: lambda ls, params: ls.begin(params),
        types.INITIALIZED: lambda ls, _params: ls.watch_files(),
        types.TEXT_DOCUMENT_DID_OPEN: lambda ls, params: ls.opened(
            params.text_document, params.text_document.text
        ),
        types.TEXT_DOCUMENT_DID_CHANGE: lambda ls, params: ls.opened(
            params.text_document, params.content_changes[-1].text
        ),
        types.TEXT_DOCUMENT_DID_SAVE: lambda ls, params: ls.check(
            ls.session.affected_by(params.text_document.uri)
        ),
        types.TEXT_DOCUMENT_DID_CLOSE: lambda ls, params: ls.closed(params.text_document.uri),
        types.WORKSPACE_DID_CHANGE_WORKSPACE_FOLDERS: lambda ls, params: ls.change_folders(
            params.event
        ),
        types.TEXT_DOCUMENT_COMPLETION: lambda ls, params: types.CompletionList(
            False, ls.session.completion(*place(params))
        ),
        types.TEXT_DOCUMENT_HOVER: lambda ls, params: ls.session.hover(*place(params)),
        types.TEXT_DOCUMENT_DEFINITION: lambda ls, params: ls.session.definition(*place(params)),
        types.TEXT_DOCUMENT_REFERENCES: lambda ls, params: ls.session.references(
            *place(params), params.context.include_declaration
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
    }
    options: dict[str, Any] = {
        types.TEXT_DOCUMENT_COMPLETION: types.CompletionOptions(
            trigger_characters=list(completion.TRIGGERS)
        ),
        types.TEXT_DOCUMENT_CODE_ACTION: types.CodeActionOptions(
            code_action_kinds=[types.CodeActionKind.QuickFix]
        ),
    }
    for message, handler in handlers.items():
        server.feature(message, options.get(message))(handler)
    return server
