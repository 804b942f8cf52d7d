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
from sjdsl.results.page import ENDINGS, FIGURES, Section, body_text, draw_pictures, file_texts
from sjdsl.results.refusals import ResultsWarning
from sjdsl.results.sections import cross_play, learning_curves

DATA = Path("docs/results/data")
PAGE = Path("docs/results.md")
RETURN = "return, summed over agents"  # the name of a figure in docs/games.json


def main(arguments: Sequence[str]) -> int:
    """Writes the page, or checks it; returns 1 if it is out of date."""
    check = "--check" in arguments
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        data = read_data([Path(name) for name in arguments if name != "--check"])
    for warning in caught:  # about the named folders
        if issubclass(warning.category, ResultsWarning):
            print(f"note: {warning.message}", file=sys.stderr)
    by_mark = sections_of(data)
    sections = tuple(by_mark.values())
    texts = {f"{PAGE.stem}/data/{name}": write_frame(frame) for name, frame in data.items()}
    texts |= {f"{PAGE.stem}/{name}": text for name, text in file_texts(sections).items()}
    texts[PAGE.name] = fill_page(PAGE.read_text(encoding="utf-8"), by_mark)
    pictures = [
        f"{PAGE.stem}/{FIGURES}/{picture.name}.{ending}"
        for section in sections
        for picture in section.pictures
        for ending in ENDINGS
    ]
    if check:
        faults = _out_of_date(texts)
        faults += [f"{name}: missing" for name in pictures if not (PAGE.parent / name).is_file()]
        for fault in faults:
            print(fault, file=sys.stderr)
        return 1 if faults else 0
    for name, text in texts.items():
        write_whole(PAGE.parent / name, text)
    for name, content in draw_pictures(sections).items():
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
    random = [row for path in catalogues for row in random_rows(path)]
    results, curves = load_both([DATA, *(path for path in sources if path not in files)], random)
    speeds = read_speeds(DATA, [path for path in files if path not in catalogues])
    return {
        RESULTS: results,
        CURVES: curves,
        **{FILES[name]: frame for name, frame in speeds.items()},
    }


def random_rows(catalogue: Path) -> list[dict[str, Any]]:
    """Returns a row of results for a random policy in each bundled game, from docs/games.json."""
    rows = []
    for game, entry in read_json(catalogue).items():
        figure = entry["values"][RETURN]
        rows.append(
            {
                "record": "random",
                "game": game,
                "hash": entry["hash"],
                "collective_return": figure["mean"],
                "low": figure["low"],
                "high": figure["high"],
                "episodes": entry["episodes"],
            }
        )
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


def fill_page(page: str, sections: Mapping[str, Section]) -> str:
    """Returns the page with the sections between their marks."""
    for name, section in sections.items():
        page = replace_section(page, name, body_text(section, f"{PAGE.stem}/") + "\n")
    return page


def _out_of_date(texts: dict[str, str]) -> list[str]:
    """Returns a line for each file that is missing or has another text."""
    faults = []
    for name, text in texts.items():
        path = PAGE.parent / name
        if not path.is_file():
            faults.append(f"{path}: missing")
        elif path.read_text(encoding="utf-8") != text:
            faults.append(f"{path}: out of date")
    return faults


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
