"""The notebooks run from their first cell to their last with what `pip install 'sjdsl[pictures,plots]'` brings, and are kept with their outputs."""

import re
import resource
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

REPOSITORY = Path(__file__).parents[2]
EXAMPLES = REPOSITORY / "examples"
NOTEBOOKS = sorted(path.stem for path in EXAMPLES.glob("*.ipynb"))
URL = "https://github.com/sjdsl/sjdsl"


def executed(name: str) -> nbformat.NotebookNode:
    """Returns a notebook with its outputs. Its process compiles as quickly as the tests do: it has their variables."""
    notebook = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    NotebookClient(
        notebook,
        timeout=600,
        kernel_name="python3",
        resources={"metadata": {"path": str(EXAMPLES)}},
    ).execute()
    return notebook


def printed(notebook: nbformat.NotebookNode, start: str) -> str:
    """Returns what the cell printed or showed whose code begins so."""
    (cell,) = (
        cell
        for cell in notebook.cells
        if cell.cell_type == "code" and cell.source.startswith(start)
    )
    return "".join(
        output.get("text")
        or output.get("data", {}).get("text/markdown")
        or output["data"]["text/plain"]
        for output in cell.outputs
    )


def shown(notebook: nbformat.NotebookNode, kind: str) -> list[str]:
    """Returns everything of a media type that the notebook shows."""
    data = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", ())]
    return [each[kind] for each in data if kind in each]


@pytest.mark.thorough
def test_the_code_of_a_dilemma_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """In this process and without Jupyter: what is printed, and what the last cell shows."""
    _, _, *cells = nbformat.read(EXAMPLES / "write_a_dilemma.ipynb", as_version=4).cells
    names: dict[str, object] = {}
    for cell in (cell for cell in cells if cell.cell_type == "code"):
        exec(compile(cell.source, "write_a_dilemma", "exec"), names)
    said = capsys.readouterr()
    assert "did you mean `wood`" in said.out + said.err and "no problems" in said.out
    before, after = (
        _numbers(line) for line in said.out.splitlines() if line.startswith("keepers, then idlers:")
    )
    assert max(before[:2]) < min(before[2:])
    assert min(after[:2]) > 1.5 * max(before[:2])
    assert "+     tally fed for agent  give 6 to agent" in said.out


@pytest.mark.thorough
def test_a_dilemma_is_written_and_changed() -> None:
    """Two keep the fire and two sit by it: the idlers earn more, until a log pays."""
    notebook = executed("write_a_dilemma")
    mistakes = printed(notebook, "mistaken =")
    assert (
        "did you mean `wood`" in mistakes and "expected a reward, found a probability" in mistakes
    )
    assert "no problems" in printed(notebook, 'command(["check", str(rules)])')
    before, after = (
        _numbers(printed(notebook, cell).splitlines()[0]) for cell in ("def returns", "again =")
    )
    assert max(before[:2]) < min(before[2:])
    assert min(after[:2]) > 1.5 * max(before[:2])
    assert after[2:] == before[2:]  # the idlers' walks and draws are the same
    assert "+     tally fed for agent  give 6 to agent" in printed(notebook, "thankful =")
    pages = shown(notebook, "text/html")
    assert len(pages) == 2 and all(page.startswith("<iframe") for page in pages)
    assert len(shown(notebook, "image/png")) == 1


@pytest.mark.thorough
def test_what_the_tour_shows() -> None:
    """And that it is a tour: two minutes at most of a processor, which other work on the machine does not prolong."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    notebook = executed("tour")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    assert 1 < used < 120, used  # less than a second would not be the kernel's
    assert "orchard" in printed(notebook, "rules =")
    assert printed(notebook, "observation, state").startswith("((2,")
    assert printed(notebook, "def rollout").count("steps a second") == 2
    assert "regrow" in printed(notebook, "from sjdsl.cli")
    assert printed(notebook, "from sjdsl.trainers import evaluate").count("reward, seed") == 4
    assert any(
        word in printed(notebook, "from sjdsl.experiments") for word in ("dilemma", "undecided")
    )
    assert "| orchard |" in printed(notebook, "from sjdsl.results")
    assert len(shown(notebook, "image/png")) == 3


@pytest.mark.thorough
def test_schelling_diagrams_tell_a_dilemma_from_none() -> None:
    notebook = executed("schelling")
    assert "dilemma - the lower bounds of A, B and greed are above 0" in printed(
        notebook, "env = sjdsl.make"
    )
    assert printed(notebook, "for others in").count("others cooperate") == 4
    verdicts = printed(notebook, "coins = sjdsl.make")
    assert "harm -2.0: dilemma" in verdicts and "harm 0.0: no dilemma" in verdicts
    assert len(shown(notebook, "image/png")) == 3


@pytest.mark.thorough
def test_a_payoff_is_swept_in_one_program() -> None:
    notebook = executed("sweep")
    assert "17 payoffs, 24 episodes each; compiled programs: 1" in printed(notebook, "def episode")
    verdicts = printed(notebook, "is_dilemma")
    assert "harm -2.0: a dilemma" in verdicts and "harm  0.0: no dilemma" in verdicts
    assert len(shown(notebook, "image/png")) == 1


@pytest.mark.thorough
def test_models_play_and_go_on_where_they_stopped() -> None:
    notebook = executed("models")
    assert "YOUR AIM" in printed(notebook, "env = sjdsl.make")
    assert "YOUR ACTIONS NOW" in printed(notebook, "class Reader")
    said = printed(notebook, "roles =")
    assert "100 calls were made" in said
    assert said.count(": 180 calls, 0 unusable") == 2


def _numbers(text: str) -> list[int]:
    return [int(number) for number in re.findall(r"-?\d+", text)]


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_it_is_kept_as_it_ran(name: str) -> None:
    """With the outputs of one run from top to bottom, without a mistake, and without the name of a folder of that machine."""
    kept = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    nbformat.validate(kept)
    code = [cell for cell in kept.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert re.search(rf"%pip install .*'sjdsl\[[a-z,]+\] @ git\+{URL}'", code[0].source)
    outputs = [output for cell in code for output in cell.outputs]
    texts = [output.text for output in outputs if output.output_type == "stream"]
    assert re.findall(r"\d\.\d{7,}", "".join(texts)) == [], "figures are rounded"
    assert any("image/png" in output.get("data", {}) for output in outputs)
    assert [output for output in outputs if output.output_type == "error"] == []
    assert [
        output for output in outputs if output.output_type == "stream" and "/tmp/" in output.text
    ] == []
