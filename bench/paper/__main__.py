"""Writes the sections of docs/results.md and their files from docs/results/data, after adding new
results to the data if some are named.

python -m bench.paper                        # from the data as they are python -m bench.paper
runs/new speed.json    # adds folders of results, JSON of benchmarks, and docs/games.json python -m
bench.paper --check                # writes nothing; lists what is out of date

JSON of benchmarks: of `sjdsl bench --json`, or of `python -m bench.speed race` or `training` with
`--json`.
"""

import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from bench.paper import sections as compared
from bench.paper.contents import games_of, under_the_papers_rules
from bench.paper.speeds import FILES, hours, read_speeds, speed
from sjdsl.bench.markdown import replace_section
from sjdsl.files import read_json, write_whole
from sjdsl.results.loading import CURVES, RESULTS, load_both, write_frame
from sjdsl.results.page import ENDINGS, FIGURES, Section, body_text, drawn, file_texts
from sjdsl.results.refusals import ResultsWarning
from sjdsl.results.sections import cross_play, learning_curves

DATA, PAGE = Path("docs/results/data"), Path("docs/results.md")
RANDOM = "return, summed over agents"  # the name of a figure in docs/games.json


def main(arguments: Sequence[str]) -> int:
    """Writes the page, or checks it; returns 1 if it is out of date."""
    check = "--check" in arguments
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        data = read_data([Path(name) for name in arguments if name != "--check"])
    _tell(
        [
            f"note: {warning.message}"
            for warning in caught
            if issubclass(warning.category, ResultsWarning)
        ]
    )  # about the named folders
    sections = sections_of(data)
    made = tuple(sections.values())
    texts = {f"{PAGE.stem}/data/{name}": write_frame(frame) for name, frame in data.items()}
    texts |= {f"{PAGE.stem}/{name}": text for name, text in file_texts(made).items()}
    texts[PAGE.name] = made_page(PAGE.read_text(encoding="utf-8"), sections)
    pictures = [
        f"{PAGE.stem}/{FIGURES}/{picture.name}.{ending}"
        for section in made
        for picture in section.pictures
        for ending in ENDINGS
    ]
    if check:
        return _tell(
            [
                *_other(texts),
                *(f"{name}: missing" for name in pictures if not (PAGE.parent / name).is_file()),
            ]
        )
    for name, text in texts.items():
        write_whole(PAGE.parent / name, text)
    for name, content in drawn(made).items():
        write_whole(PAGE.parent / PAGE.stem / name, content)
    kept = {*texts, *pictures}
    for path in (*DATA.parent.glob("tables/*"), *DATA.parent.glob(f"{FIGURES}/*")):
        if path.relative_to(PAGE.parent).as_posix() not in kept:
            path.unlink()
    return 0


def read_data(sources: Sequence[Path]) -> dict[str, pd.DataFrame]:
    """Returns the tables of the data, with more sources added, by the name of their file."""
    files = [path for path in sources if path.suffix == ".json"]
    catalogues = [path for path in files if "sort" not in read_json(path)]
    random = [row for path in catalogues for row in random_of(path)]
    results, curves = load_both([DATA, *(path for path in sources if path not in files)], random)
    speeds = read_speeds(DATA, [path for path in files if path not in catalogues])
    return {
        RESULTS: results,
        CURVES: curves,
        **{FILES[name]: frame for name, frame in speeds.items()},
    }


def random_of(catalogue: Path) -> list[dict[str, Any]]:
    """Returns the returns of a random policy in the bundled games, from docs/games.json."""
    rows = []
    for game, entry in read_json(catalogue).items():
        figure = entry["values"][RANDOM]
        found = {
            "collective_return": figure["mean"],
            "low": figure["low"],
            "high": figure["high"],
            "episodes": entry["episodes"],
        }
        rows.append({"record": "random", "game": game, "hash": entry["hash"], **found})
    return rows


def sections_of(data: dict[str, pd.DataFrame]) -> dict[str, Section]:
    """Returns what the page has between the marks of each name."""
    frame = under_the_papers_rules(data[RESULTS])
    games = games_of(frame)
    return {
        "findings": compared.findings(games, frame),
        "own and common": compared.own_and_common(games, frame),
        "learning curves": learning_curves(frame, data[CURVES]),
        "sharing": compared.sharing(games),
        "mappo": compared.mappo(games),
        "exchange": compared.exchange(games),
        "svo": compared.svo(games),
        "metrics": compared.metrics(games),
        "over games": compared.over_games(games, frame),
        "schelling": compared.diagrams(frame),
        "cross-play": cross_play(frame),
        "speed": speed(data[FILES["speeds"]]),
        "hours": hours(data[FILES["updates"]]),
    }


def made_page(page: str, sections: Mapping[str, Section]) -> str:
    """Returns the page with the sections between their marks."""
    for name, section in sections.items():
        page = replace_section(page, name, body_text(section, f"{PAGE.stem}/") + "\n")
    return page


def _other(texts: dict[str, str]) -> list[str]:
    """Returns the files that are out of date."""
    paths = {name: PAGE.parent / name for name in texts}
    return [
        f"{path}: {'out of date' if path.is_file() else 'missing'}"
        for name, path in paths.items()
        if not path.is_file() or path.read_text(encoding="utf-8") != texts[name]
    ]


def _tell(lines: Sequence[str]) -> int:
    for line in lines:
        print(line, file=sys.stderr)
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
