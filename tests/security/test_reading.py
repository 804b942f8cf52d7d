"""Commands that read games run nothing of theirs, and pages show their texts as texts."""

import builtins
import json
import os
import re
import subprocess
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from test_generated_text import NAMES, written

import sjdsl
from sjdsl.cli import run, studio
from sjdsl.editor.session import Session
from sjdsl.render import make_page
from sjdsl.render.playing import first_moment
from sjdsl.replay import EpisodePlayer
from sjdsl.results.page import inert, page_text
from sjdsl.studio.folder import Folder
from sjdsl.trainers import PolicyError
from sjdsl.trainers.policies.policy_file import policy_path
from sjdsl.trainers.runs.run_state import run_state
from sjdsl.trainers.settings.policy_names import split_name

TITLES = [
    "</script><script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "{{ 7 * 7 }}",
    "\\\"'`&lt;",
    "]]> --> <!--",
    "\U0001f352é",
]


def _refused(*_: object, **__: object) -> Any:
    raise AssertionError("code is run")


@pytest.mark.parametrize("command", ["check", "fmt", "doc", "diff"])
def test_commands_that_read_run_nothing(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    game = written("tiny.sj", tmp_path)
    arguments = [command, str(game), *([str(game)] if command == "diff" else [])]
    assert run(arguments) == 0  # all that is imported is there by now
    for module, name in ((builtins, "exec"), (builtins, "eval"), (subprocess, "Popen")):
        monkeypatch.setattr(module, name, _refused)
    assert run(arguments) == 0


def test_the_language_server_runs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    game = written("tiny.sj", tmp_path)
    Session().open(game.as_uri(), game.read_text())
    for module, name in ((builtins, "exec"), (builtins, "eval"), (subprocess, "Popen")):
        monkeypatch.setattr(module, name, _refused)
    session = Session()
    session.open(game.as_uri(), game.read_text().replace("ripe", "rotten"))
    assert session.documents.is_open(game.as_uri())


class Elements(HTMLParser):
    """Gathers the elements of a page, and the text of each script."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.handlers: list[str] = []
        self.scripts: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.handlers += [name for name, _ in attrs if name.startswith("on")]
        self.scripts += [""] * (tag == "script")

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1] == "script":
            self.scripts[-1] += data


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Elements:
    return Elements(page_of(written("plain.sj", tmp_path_factory.mktemp("plain"))))


def page_of(path: Path) -> str:
    env = sjdsl.make(path)
    return make_page(env.game, [first_moment(env, EpisodePlayer(env, 0).state)]).text


@pytest.mark.parametrize("title", TITLES)
def test_a_page_has_no_more_elements_for_any_title(
    title: str, tmp_path: Path, plain: Elements
) -> None:
    path = written("tiny.sj", tmp_path, title.replace("\\", "\\\\").replace('"', '\\"'))
    found = Elements(page_of(path))
    assert (found.tags, found.handlers, len(found.scripts)) == (plain.tags, [], 2)
    assert json.loads(found.scripts[0])["title"] == title
    assert found.scripts[1] == plain.scripts[1]


@pytest.mark.parametrize("name", NAMES)
def test_the_studio_reads_and_writes_a_file_of_any_name(name: str, tmp_path: Path) -> None:
    """Those that JSON or a page cannot show are refused in words and not listed."""
    text = written(name, tmp_path).read_text()
    folder = Folder(tmp_path.resolve())
    assert folder.games() == [name] * name.isprintable()
    if name.isprintable():
        assert folder.read(name)[0] == text
    json.dumps(folder.games())


def test_the_studio_listens_on_this_machine_alone() -> None:
    with studio._listen(0) as listening:
        assert listening.getsockname()[0] == "127.0.0.1"
    options = {option.name for option in studio.command.params}
    known = {"game", "port", "slots", "variant", "agents", "allow_code", "browser"}
    assert options == known | {"parallel", "budget", "calls"}  # none names a host


def test_a_name_that_no_page_can_show_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    written(os.fsdecode(b"\xff.sj"), tmp_path)
    assert run(["studio", os.fsdecode(b"\xff.sj"), "--no-browser"]) == 1
    assert r"`\udcff.sj` is not UTF-8, so no page can show it" in capsys.readouterr().err


def test_digits_that_are_no_numbers_in_names_of_files(tmp_path: Path) -> None:
    """`"²".isdigit()` is true, and `int("²")` raises."""
    for name in ("policies/²", "²"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / f"{name}.safetensors").touch()
        (tmp_path / f"{name}.json").write_text(json.dumps({"game": {"name": "coins"}}))
    assert split_name("run@²") == (Path("run"), "²")
    with pytest.raises(PolicyError, match="has no policy called last, but of ²"):
        policy_path(tmp_path, "last")
    assert run_state(tmp_path / "seed_²") is None


def test_a_report_shows_names_as_texts() -> None:
    for title in TITLES:
        assert not re.search(r"<[a-zA-Z/!?]", inert(title))
        assert not re.search(r"<[a-zA-Z/!?]", page_text("Results", [], ["Made."], [title]))
    assert inert("p < 0.05, a <= b") == "p < 0.05, a <= b"
