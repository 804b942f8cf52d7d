"""The server as an editor has it: one process, spoken to over standard input and output."""

import asyncio
import json
import subprocess
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
import pytest_lsp
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities
from pytest_lsp.client import make_test_lsp_client

from tests.editor.asked import ORCHARD

SMALL = 'sj 1\ngame small "S" extends "orchard.sj" { set apple = 3 }\n'
COMMAND = [sys.executable, "-c", "from sjdsl.cli import main; main()", "lsp"]
PATIENCE = 60  # seconds, on a machine that has much else to do
asked = pytest.mark.asyncio(loop_scope="module")


def make_client() -> LanguageClient:
    made = make_test_lsp_client()

    @made.feature(types.CLIENT_REGISTER_CAPABILITY)
    def register(params: types.RegistrationParams) -> None:
        del params

    return made


@pytest_lsp.fixture(
    config=ClientServerConfig(server_command=COMMAND, client_factory=make_client), scope="module"
)
async def client(
    lsp_client: LanguageClient, tmp_path_factory: pytest.TempPathFactory
) -> AsyncIterator[None]:
    folder = tmp_path_factory.mktemp("games")
    (folder / "small.sj").write_text(SMALL)
    lsp_client.folder = folder
    lsp_client.uri = (folder / "orchard.sj").as_uri()
    lsp_client.version = 0
    capabilities = client_capabilities("visual_studio_code")
    folders = [types.WorkspaceFolder(folder.as_uri(), "games")]
    await lsp_client.initialize_session(
        types.InitializeParams(capabilities=capabilities, workspace_folders=folders)
    )
    item = types.TextDocumentItem(lsp_client.uri, "sj", 0, ORCHARD)
    lsp_client.text_document_did_open(types.DidOpenTextDocumentParams(item))
    yield
    await lsp_client.shutdown_session()


def change(client: LanguageClient, text: str) -> int:
    """Sends the open text as it is now; returns its version."""
    client.version += 1
    identifier = types.VersionedTextDocumentIdentifier(uri=client.uri, version=client.version)
    client.text_document_did_change(
        types.DidChangeTextDocumentParams(
            identifier, [types.TextDocumentContentChangeWholeDocument(text)]
        )
    )
    return client.version


async def messages(client: LanguageClient, wanted: list[str | None]) -> list[types.Diagnostic]:
    """Waits until the messages about the open text have these codes."""
    async with asyncio.timeout(PATIENCE):
        while [d.code for d in client.diagnostics.get(client.uri, ())] != wanted:
            await asyncio.sleep(0.01)
    return list(client.diagnostics[client.uri])


def named(client: LanguageClient) -> types.TextDocumentIdentifier:
    return types.TextDocumentIdentifier(client.uri)


@asked
async def test_messages_follow_the_text(client: LanguageClient) -> None:
    change(client, "# é😀\n" + ORCHARD.replace("give apple", "give appel"))
    (found,) = await messages(client, ["SJ101"])
    assert found.range == types.Range(types.Position(27, 78), types.Position(27, 83))
    change(client, "# a\n" + ORCHARD)
    await messages(client, [])


@asked
async def test_after_many_fast_edits_the_messages_are_of_the_last_text(
    client: LanguageClient,
) -> None:
    for number in range(200):
        change(
            client,
            ORCHARD.replace("give apple", f"give appel_{number}")
            if number < 199
            else ORCHARD.replace("chose share", "chose shaer"),
        )
    (found,) = await messages(client, ["SJ105"])
    assert found.range.start.line == 33
    await asyncio.sleep(0.2)
    assert [d.code for d in client.diagnostics[client.uri]] == ["SJ105"]
    change(client, ORCHARD)
    await messages(client, [])


@asked
async def test_questions_are_answered(client: LanguageClient) -> None:
    change(client, ORCHARD)
    lines = ORCHARD.splitlines()
    number = next(i for i, line in enumerate(lines) if "give apple" in line)
    here = types.Position(number, lines[number].index("give apple") + 7)
    hover = await client.text_document_hover_async(types.HoverParams(named(client), here))
    assert hover is not None and "`apple` is 1 (reward)" in hover.contents.value
    places = await client.text_document_definition_async(
        types.DefinitionParams(named(client), here)
    )
    assert [p.range.start.line for p in places] == [3]
    found = await client.text_document_references_async(
        types.ReferenceParams(types.ReferenceContext(True), named(client), here)
    )
    assert {Path(p.uri).name for p in found or ()} == {"orchard.sj", "small.sj"}
    offered = await client.text_document_completion_async(
        types.CompletionParams(named(client), here)
    )
    assert "apple" in {item.label for item in offered.items}
    edit = await client.text_document_rename_async(types.RenameParams(named(client), here, "pear"))
    assert edit is not None and len(edit.document_changes or ()) == 2
    assert await client.text_document_document_symbol_async(
        types.DocumentSymbolParams(named(client))
    )
    edits = await client.text_document_formatting_async(
        types.DocumentFormattingParams(named(client), types.FormattingOptions(2, True))
    )
    assert edits is not None


@asked
async def test_a_new_name_that_is_taken_is_refused_with_a_message(client: LanguageClient) -> None:
    change(client, ORCHARD)
    with pytest.raises(JsonRpcException, match="already stands in"):
        await client.text_document_rename_async(
            types.RenameParams(named(client), types.Position(3, 9), "regrow")
        )


@asked
async def test_the_messages_about_a_closed_text_are_taken_back(client: LanguageClient) -> None:
    change(client, "sj 1")
    await messages(client, ["SJ002"])
    client.text_document_did_close(types.DidCloseTextDocumentParams(named(client)))
    await messages(client, [])
    client.text_document_did_open(
        types.DidOpenTextDocumentParams(types.TextDocumentItem(client.uri, "sj", 0, ORCHARD))
    )


def test_without_pygls_the_command_says_what_to_install() -> None:
    program = "import sys; sys.modules['pygls'] = None; sys.argv = ['sjdsl', 'lsp']; from sjdsl.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "pip install 'sjdsl[editor]'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("asked_for", [True, False])
def test_the_exit_status_is_the_protocols(asked_for: bool) -> None:
    """0 after `shutdown` and `exit`; 1 for `exit` alone; nothing is written to standard error."""
    server = subprocess.Popen(
        COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert server.stdin is not None and server.stdout is not None

    def say(**message: object) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        server.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        server.stdin.flush()

    def hear() -> dict:
        length = int(server.stdout.readline().split(b":")[1])
        while server.stdout.readline().strip():
            pass
        return json.loads(server.stdout.read(length))

    say(id=1, method="initialize", params={"processId": None, "rootUri": None, "capabilities": {}})
    assert hear()["id"] == 1
    say(method="initialized", params={})
    if asked_for:
        say(id=2, method="shutdown")
        assert hear() == {"id": 2, "jsonrpc": "2.0", "result": None}
    say(method="exit")
    _, complaints = server.communicate(timeout=PATIENCE)
    assert (server.returncode, complaints) == (0 if asked_for else 1, b"")
