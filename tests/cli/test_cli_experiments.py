"""`sjdsl crossplay` and `sjdsl schelling` on a small game: what they print and write, and what they refuse before anything is played."""

import json
from pathlib import Path

from command_line import Sjdsl

DIAGRAM = "schelling orchard.sj --cooperators stay --defectors random --episodes 3 --variant rich"


def test_a_diagram(sjdsl: Sjdsl, folder: Path) -> None:
    shown = sjdsl(f"{DIAGRAM} --param length=4")
    assert shown.status == 0, shown.text
    assert "cooperators stay, defectors random; 3 episodes, of these policies only" in shown.out
    for line in (
        "others who cooperate  C: cooperating",
        "contrasts, with intervals that hold at 95 % together",
        "verdict: ",
    ):
        assert line in shown.out
    assert [line for line in shown.err.splitlines() if line.startswith("playing")] == [
        f"playing 3 episodes of line-up {number} of 3" for number in (1, 2, 3)
    ]
    assert shown.out.splitlines()[-1] == (
        "orchard_schelling/: schelling.json, schelling.png, schelling.svg"
    )
    stored = json.loads((folder / "orchard_schelling/schelling.json").read_text())
    assert (stored["cooperators"], stored["defectors"], stored["episodes"]) == ("stay", "random", 3)
    assert stored["C"]["mean"] == [0.0, 0.0], "who stays eats nothing"

    again = sjdsl(f"{DIAGRAM} --param length=4")
    assert (again.status, again.out) == (0, shown.out)
    other = sjdsl(f"{DIAGRAM} --param length=5")
    assert other.status == 1
    assert (
        "orchard_schelling holds another experiment: game params length 4 there, 5 here"
        in other.err
    )


def test_cross_play_of_pairs(sjdsl: Sjdsl, folder: Path) -> None:
    shown = sjdsl("crossplay orchard.sj --policies stay random --mix pairs --episodes 3 -o pairs")
    assert shown.status == 0, shown.text
    assert "1 x stay, 1 x random" in shown.out
    assert {path.name for path in (folder / "pairs").iterdir() if path.is_file()} == {
        *("experiment.json", "crossplay.csv", "crossplay.json", "matrix.png")
    }
