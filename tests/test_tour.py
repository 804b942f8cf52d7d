"""The notebook of the tour runs from its first cell to its last, and is kept without outputs."""

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

TOUR = Path(__file__).parents[1] / "examples/tour.ipynb"


@pytest.fixture(scope="module")
def executed() -> nbformat.NotebookNode:
    """Returns the notebook with its outputs. Its process compiles as quickly as the tests do: it has their variables."""
    notebook = nbformat.read(TOUR, as_version=4)
    assert os.environ["JAX_COMPILATION_CACHE_DIR"]
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(TOUR.parent)}}).execute()
    return notebook


def printed(notebook: nbformat.NotebookNode, start: str) -> str:
    """Returns what the cell printed or showed whose code begins so."""
    (cell,) = (cell for cell in notebook.cells if cell.cell_type == "code" and cell.source.startswith(start))
    return "".join(
        output.get("text") or output.get("data", {}).get("text/markdown") or output["data"]["text/plain"] for output in cell.outputs
    )


@pytest.mark.thorough
def test_what_the_tour_shows(executed: nbformat.NotebookNode) -> None:
    assert "orchard" in printed(executed, "rules =")
    assert printed(executed, "observation, state").startswith("((2,")
    assert printed(executed, "def rollout").count("steps a second") == 2
    assert "regrow" in printed(executed, "from sjdsl.cli")
    assert printed(executed, "from sjdsl.trainers import evaluate").count("reward, seed") == 4
    assert any(word in printed(executed, "from sjdsl.experiments") for word in ("dilemma", "undecided"))
    assert "| orchard |" in printed(executed, "from sjdsl.report")
    pictures = [output for cell in executed.cells for output in cell.get("outputs", ()) if "image/png" in output.get("data", {})]
    assert len(pictures) == 3


def test_the_notebook_is_kept_without_outputs() -> None:
    kept = nbformat.read(TOUR, as_version=4)
    nbformat.validate(kept)
    assert [cell for cell in kept.cells if cell.cell_type == "code" and (cell.outputs or cell.execution_count)] == []
