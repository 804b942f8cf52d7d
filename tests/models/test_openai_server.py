"""Models on a server, through the real package: what is sent, what is retried, and where the key is
(nowhere)."""

import json
import os
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any

import pytest

from sjdsl.models import Message, Model, ModelError, load_models
from sjdsl.models import files as model_files

from .server import Server, serving

KEY = "sk-abc-very-secret"
ASKED = Message("the rules", "what is seen", ("stay", "forward", "zap"), ("stay", "forward"))
FORWARD = '{"why": "it is free", "goal": "", "note": {"op": "none"}, "action": "forward"}'


def model(server: Server, **fields: object) -> Model:
    os.environ["TEST_KEY"] = KEY
    settings = {"name": "luna", "url": server.url, "model": "luna", "key": "TEST_KEY"}
    return Model(**{**settings, "retries": 2, **fields})  # type: ignore[arg-type]


def test_what_is_sent_and_read() -> None:
    with serving(Server(lambda _: FORWARD)) as server:
        luna = model(server, extra={"reasoning_effort": "low"}, max_tokens=77)
        reply = luna.decide(0, ASKED)
    assert (reply.action, reply.why, reply.is_valid) == ("forward", "it is free", True)
    answer = reply.answer
    assert answer is not None
    assert (answer.text, answer.reasoning, answer.model) == (FORWARD, "thinking", "luna-2026")
    assert (answer.input, answer.cached, answer.output) == (100, 60, 10)
    (request,) = server.requests
    schema = request.pop("response_format")["json_schema"]
    assert request == {
        "model": "luna",
        "messages": [
            {"role": "system", "content": "the rules"},
            {"role": "user", "content": "what is seen"},
        ],
        "max_completion_tokens": 77,
        "reasoning_effort": "low",
    }
    assert schema["strict"] is True
    # All actions, so that it is the same at each step.
    assert schema["schema"]["properties"]["action"]["enum"] == ["stay", "forward", "zap"]
    assert server.keys == [KEY]


@pytest.mark.parametrize(
    "sent",
    [
        {"choices": [{"index": 0}]},
        {"choices": ["text"]},
        {"choices": "text"},
        {"choices": [{"message": {"content": [{"type": "text", "text": FORWARD}]}}]},
    ],
)
def test_an_answer_of_another_form_counts_as_stay(sent: dict[str, Any]) -> None:
    with serving(Server(lambda _: FORWARD, faults=[sent])) as server:
        reply = model(server).decide(0, ASKED)
    assert (reply.action, reply.is_valid) == ("stay", False)


def test_what_no_file_can_hold_is_replaced() -> None:
    """Half a character, once in what the model wrote and once in what the server says of it."""
    halved = FORWARD.replace("it is free", "\\ud83d free")
    sent = {"model": "luna-\ud83d", "usage": {"prompt_tokens": "many", "completion_tokens": -3}}
    with serving(Server(lambda _: halved, faults=[sent])) as server:
        reply = model(server).decide(0, ASKED)
    assert (reply.action, reply.why) == ("forward", "? free")
    assert reply.answer is not None
    assert (reply.answer.model, reply.answer.input, reply.answer.output) == ("luna-?", 0, 0)


@pytest.mark.parametrize(
    ("fields", "form"),
    [({"schema": "json"}, {"type": "json_object"}), ({"schema": "none"}, None)],
)
def test_other_ways_to_ask_for_the_form(fields: dict[str, str], form: object) -> None:
    with serving(Server(lambda _: FORWARD)) as server:
        model(server, limit="max_tokens", notebook=False, **fields).decide(0, ASKED)
    assert server.requests[0].get("response_format") == form
    assert server.requests[0]["max_tokens"] == 4000


@pytest.mark.parametrize("faults", [[429, 503], [500, "cut"], ["slow"]])
def test_what_passes_is_retried(faults: list[int | str]) -> None:
    with serving(Server(lambda _: FORWARD, list(faults))) as server:
        reply = model(server, timeout=0.3).decide(0, ASKED)
    assert reply.action == "forward"
    assert len(server.requests) == len(faults) + 1


@pytest.mark.parametrize(
    ("faults", "calls", "problem"),
    [
        ([400], 1, "the server refuses the request with 400"),
        ([401], 1, "the server refuses the request with 401"),
        ([404], 1, "the server refuses the request with 404"),
        ([429] * 3, 3, "the server refuses the request with 429"),
        (["slow"] * 3, 3, "no answer within 3 attempts"),
    ],
)
def test_what_does_not_pass_stops(faults: list[int | str], calls: int, problem: str) -> None:
    server = Server(lambda _: FORWARD, list(faults))
    with serving(server), pytest.raises(ModelError, match=problem) as raised:
        model(server, timeout=0.3).decide(0, ASKED)
    assert len(server.requests) == calls
    printed = "".join(traceback.format_exception(raised.value))
    assert KEY not in printed
    assert "luna at http://127.0.0.1" in printed


def test_a_server_that_cannot_be_reached() -> None:
    nowhere = Server(lambda _: "", url="http://127.0.0.1:9/v1")
    with pytest.raises(ModelError, match="no answer within 1 attempts: Connection error"):
        model(nowhere, retries=0).decide(0, ASKED)


@pytest.mark.parametrize("fault", ["empty", "ok"])
def test_what_is_no_reply_is_stay(fault: str) -> None:
    with serving(Server(lambda _: '{"action": "forw', [fault])) as server:
        reply = model(server).decide(0, ASKED)
    assert (reply.action, reply.is_valid) == ("stay", False)


def test_an_echoed_key_is_not_kept(tmp_path: Path) -> None:
    """A reply of a server that says the key."""
    file = tmp_path / "key"
    file.write_text(f"{KEY}\n")
    echo = json.dumps({"why": f"you sent {KEY}", "action": "forward"})
    with serving(Server(lambda _: echo)) as server:
        luna = model(server, key={"file": str(file)})
        reply = luna.decide(0, ASKED)
    assert server.keys == [KEY]
    assert reply.why == "you sent [key]"
    assert KEY not in repr((reply, luna, luna._policy, luna.settings()))
    assert "TEST_KEY" not in json.dumps(model(server).settings())


def test_without_a_key_that_of_openai_is_not_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    with serving(Server(lambda _: FORWARD)) as server:
        model(server, key="").decide(0, ASKED)
    assert server.keys == ["none"]


def test_a_request_has_nothing_of_this_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("OPENAI_ORG_ID", "OPENAI_PROJECT_ID"):
        monkeypatch.setenv(name, "of_mine")
    monkeypatch.setenv("OPENAI_CUSTOM_HEADERS", "X-Mine: of_mine")
    with serving(Server(lambda _: FORWARD)) as server:
        model(server, key="").decide(0, ASKED)
    sent = "\n".join(server.headers).lower()
    assert "of_mine" not in sent
    assert "x-stainless-os" not in sent
    assert "user-agent: sjdsl" in sent


def test_no_request_goes_to_another_server() -> None:
    other = Server(lambda _: FORWARD)
    server = Server(lambda _: FORWARD, [307])
    with serving(other), serving(server):
        server.elsewhere = f"{other.url}/chat/completions"
        with pytest.raises(ModelError, match="refuses the request with 307"):
            model(server).decide(0, ASKED)
    assert not other.requests


def test_a_key_that_no_request_can_carry_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ODD_KEY", "kéy")
    nowhere = Server(lambda _: "", url="http://127.0.0.1:9/v1")
    with pytest.raises(ModelError, match="luna: its key has characters"):
        model(nowhere, key="ODD_KEY").decide(0, ASKED)


def test_a_missing_key_is_named(tmp_path: Path) -> None:
    server = Server(lambda _: "", url="http://127.0.0.1:9/v1")
    with pytest.raises(ModelError, match="the environment variable NO_KEY isn't set"):
        model(server, key="NO_KEY").decide(0, ASKED)
    with pytest.raises(ModelError, match=r"luna: the key file .* can't be read"):
        model(server, key={"file": str(tmp_path / "none")}).decide(0, ASKED)


TABLES = """
[luna]
url = "https://api.openai.com/v1"
model = "gpt-6-luna"
key = "OPENAI_API_KEY"
price = { input = 0.5, cached = 0.05, output = 5 }

[fake]
kind = "fake"
"""


def test_a_file_of_models(tmp_path: Path) -> None:
    path = tmp_path / "models.toml"
    path.write_text(TABLES)
    models = load_models(path)
    assert models["luna"] == Model(
        name="luna",
        url="https://api.openai.com/v1",
        model="gpt-6-luna",
        key="OPENAI_API_KEY",
        price=model_files.Price(0.5, 5, 0.05),
    )
    assert models["fake"].kind == "fake"
    in_role = model_files.find_model(f"{path}:luna+cooperator")
    assert in_role == models["luna"].as_role("cooperator")
    with pytest.raises(ModelError, match="has no model `lune`; did you mean `luna`"):
        model_files.find_model(f"{path}:lune")


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        (f'key = "{KEY}"', "key: .* the name of an environment variable"),
        ('url = "file:///etc/passwd"', "url: .* the address of a server"),
        (f'url = "https://me:{KEY}@host/"', "url: .* without a password"),
        (f'keey = "{KEY}"', "keey: Unexpected keyword argument"),
        ("max_tokens = 0", "max_tokens: .* greater than 0"),
        ("extra = { n = 3 }", "extra: .* fields other than `n`, which sjdsl sets itself"),
        ("extra = { since = 2026-01-01 }", "extra: .* what JSON can carry"),
        ('model = ""', "luna needs a `url` and a `model`"),
    ],
)
def test_a_wrong_table_is_refused_without_a_key(table: str, problem: str, tmp_path: Path) -> None:
    path = tmp_path / "models.toml"
    fields = {"url": 'url = "http://localhost/"', "model": 'model = "m"'}
    fields[table.partition(" ")[0]] = table
    path.write_text("[luna]\n" + "\n".join(fields.values()))
    with pytest.raises(ModelError, match=problem) as raised:
        load_models(path)
    assert KEY not in "".join(traceback.format_exception(raised.value))


def test_a_missing_package_is_named() -> None:
    """Without `openai`, all of the module but asking works."""
    code = """if 1:
        import sys
        sys.modules["openai"] = None
        from sjdsl.models import Message, Model
        from sjdsl.extras import MissingExtra
        luna = Model(url="http://localhost/v1", model="m")
        try:
            luna.decide(0, Message("", "", ("stay", "go"), ("stay", "go")))
        except MissingExtra as error:
            print(error)
    """
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'sjdsl[models]'" in ran.stdout
