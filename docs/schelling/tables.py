"""Writes the tables of docs/schelling.md and docs/research/schelling.md again, from the diagrams in the folders beside this file; with
`--pictures` also their pictures."""

import json
import sys
import tomllib
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from sjdsl.bench.markdown import replace_section
from sjdsl.compiler import build
from sjdsl.compiler.syntax.read import read_source
from sjdsl.experiments.contrasts import Returns
from sjdsl.experiments.diagram import Diagram
from sjdsl.experiments.pictures import draw_diagram, picture_bytes
from sjdsl.library.games_folder import find_game
from sjdsl.library.titles import title_of
from sjdsl.trainers.policies.estimates import Estimate

HERE = Path(__file__).parent
PAGES = {  # each with the way from it to this folder
    HERE.with_suffix(".md"): "schelling",
    HERE.parent / "research" / "schelling.md": "../schelling",
}
PUBLISHED = tomllib.loads((HERE.parents[1] / "games/published.toml").read_text(encoding="utf-8"))[
    "schelling"
]["games"]


def main(check: bool) -> int:
    """Writes the pages, or with `check` only says whether they are up to date: 0 if they are, else 1.

    Raises ValueError if the marks of a diagram are on no page.
    """
    stale = False
    missing = set(sections(""))
    for path, folder in PAGES.items():
        page = path.read_text(encoding="utf-8")
        found = page
        for name, text in sections(folder).items():
            if f"<!-- {name} -->\n" in page:
                found = replace_section(found, name, text)
                missing.discard(name)
        if not check:
            path.write_text(found, encoding="utf-8")
        stale |= found != page
    if missing:
        raise ValueError(f"no page has the marks of {', '.join(sorted(missing))}")
    return int(check and stale)


def draw_again() -> None:
    """Draws the picture of each diagram from its stored returns."""
    for path in HERE.glob("*/schelling.json"):
        stored = json.loads(path.read_text(encoding="utf-8"))
        returns = (
            np.array(stored["returns"][who], float)
            for who in ("cooperators", "defectors", "everybody")
        )
        title = build(read_source(find_game(stored["game"]["name"]))).game.title
        of = SimpleNamespace(title=title, replicates=stored["units"], episodes=stored["units"])
        path.with_suffix(".svg").write_bytes(
            picture_bytes(draw_diagram(Diagram(of, Returns(*returns))), "svg")
        )


def sections(folder: str) -> dict[str, str]:
    """Returns the texts of all sections, by name. folder: the way from the page to the diagrams."""
    diagrams = {
        path.parent.name: json.loads(path.read_text(encoding="utf-8"))
        for path in sorted(HERE.glob("*/schelling.json"))
    }
    trained = [name for name in diagrams if name.endswith("_trained")]
    ours = [name for name, diagram in diagrams.items() if diagram["game"]["name"] not in PUBLISHED]
    scripted = [name for name in diagrams if name not in (*trained, *ours)]
    verdicts = {"scripted": scripted, "ours": ours, "trained": trained}
    return {
        **{f"diagram {name}": lines_table(f"{folder}/{name}", d) for name, d in diagrams.items()},
        **{name: verdicts_table([diagrams[d] for d in of]) for name, of in verdicts.items()},
    }


def verdicts_table(diagrams: list[dict[str, Any]]) -> str:
    """Returns a row for each diagram: the published shape, the verdict, the contrasts."""
    rows = [
        ("game", "published", "here", "A", "B", "fear", "greed"),
        ("---", "---", "---", "--:", "--:", "--:", "--:"),
    ]
    for diagram in diagrams:
        published, verdict = PUBLISHED.get(diagram["game"]["name"], {}), diagram["verdict"]
        contrasts = (bounds(diagram["contrasts"][name]) for name in ("A", "B", "fear", "greed"))
        shape = (
            f"dilemma, {verdict['shape']}"
            if verdict["outcome"] == "dilemma"
            else verdict["outcome"]
        )
        rows.append(
            (
                title(diagram),
                ", ".join(published[key] for key in ("shape", "type") if key in published),
                shape,
                *contrasts,
            )
        )
    return table(rows)


def lines_table(folder: str, diagram: dict[str, Any]) -> str:
    """Returns the picture, which lies in the folder, and both lines over the number of other cooperators."""
    others = range(diagram["game"]["num_agents"])
    rows = [("other cooperators", *map(str, others)), ("---", *("--:" for _ in others))]
    rows += [(line, *rounded_means(diagram[line])) for line in ("C", "D")]
    rows.append(("preferred", *diagram["D-C"]["preferred"]))
    return f"![Schelling diagram of {title(diagram)}]({folder}/schelling.svg)\n\n{table(rows)}"


def title(diagram: dict[str, Any]) -> str:
    return title_of(find_game(diagram["game"]["name"]).read_text(encoding="utf-8"))


def bounds(figure: dict[str, float]) -> str:
    return str(Estimate(figure["mean"], figure["low"], figure["high"]))


def rounded_means(line: dict[str, list[float]]) -> list[str]:
    """Returns the means of a line, each with as many digits as its interval warrants."""
    intervals = zip(line["mean"], line["low"], line["high"], strict=True)
    return [str(Estimate(*interval)).partition(" [")[0] for interval in intervals]


def table(rows: list[tuple[str, ...]]) -> str:
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


if __name__ == "__main__":
    if "--pictures" in sys.argv[1:]:
        draw_again()
    sys.exit(main("--check" in sys.argv[1:]))
