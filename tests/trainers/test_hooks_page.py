"""The lines of docs/own_algorithms.md on hooks run as they stand: in Coins, and quickly in a game of one step that has its words."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from probes import Probe, matching

import sjdsl

PAGE = Path(__file__).parents[2] / "docs" / "own_algorithms.md"


class LikeCoins(Probe):
    """`matching` with those words of Coins that the page uses."""

    @property
    def action_names(self) -> tuple[str, ...]:
        return ("stay", "forward")

    def step_env(self, *given: Any, **named: Any) -> tuple[Any, ...]:
        *played, info = super().step_env(*given, **named)
        events = {
            "other_coins": info["events"]["second_action"],
            "own_coins": info["events"]["second_action"],
        }
        return *played, info | {"events": events}


@pytest.mark.thorough
@pytest.mark.parametrize("game", ["stand_in", pytest.param("coins", marks=pytest.mark.slow)])
def test_the_hooks_do_what_the_page_says(
    game: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each is ten lines at most, but for the first, which all share."""
    page = PAGE.read_text(encoding="utf-8")
    section = page[page.index("## Hooks") : page.index("## A loss")]
    blocks = re.findall(r"```python\n(.*?)```", section, re.DOTALL)
    assert len(blocks) == 7
    monkeypatch.chdir(tmp_path)
    if game == "stand_in":
        monkeypatch.setattr(
            sjdsl,
            "make",
            lambda *_, **__: LikeCoins("coins", reward=matching().reward, show=matching().show),
        )
    names: dict[str, Any] = {"__name__": game}  # hooks of one name would be numbered
    for text in blocks:
        exec(text, names)
    assert max(len(text.strip().splitlines()) for text in blocks[1:]) <= 10
    read = {
        path.name: json.loads((path / "manifest.json").read_text())
        for path in Path("runs").iterdir()
    }
    assert {name: manifest["updates"] for name, manifest in read.items()} == dict.fromkeys(
        read, 2
    ) | {"tuned": 4}
    assert {name: manifest["status"] for name, manifest in read.items()} == dict.fromkeys(
        read, "finished"
    )
    assert read["attention"]["config"]["network"] == f"{game}:Attention"
    assert read["kind"]["config"]["reward"] == f"{game}:kind"
    assert read["with_stubborn"]["config"]["partners"] == [[1, f"{game}:stubborn"]]
    assert capsys.readouterr().out.startswith("32 ")
