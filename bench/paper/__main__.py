"""Writes docs/results.md and its files from docs/results/data, with more results taken into the data where some are named.

python -m bench.paper                        # what the data say
python -m bench.paper runs/new speed.json    # takes in folders of results, files of `sjdsl bench --json` and docs/games.json
python -m bench.paper --check                # writes nothing; says what is not up to date
"""

import sys
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from bench.paper import sections
from bench.paper.contents import games_of, method, rivals, under_the_papers_rules
from bench.paper.speeds import FILES, hours, read_speeds, speed
from sjdsl.files import read_json, write_whole
from sjdsl.results.loading import CURVES, RESULTS, load_both, write_frame
from sjdsl.results.page import ENDINGS, FIGURES, Section, drawn, file_texts, page_text
from sjdsl.results.refusals import ResultsWarning
from sjdsl.results.report import METHOD
from sjdsl.results.sections import cross_play, learning_curves
from sjdsl.stored_hashes import current_hash

DATA, PAGE = Path("docs/results/data"), Path("docs/results.md")
RANDOM = "return, summed over agents"  # a figure's name in docs/games.json


def main(arguments: Sequence[str]) -> int:
    """Writes the page, or checks it; returns 1 where it is not up to date."""
    check = "--check" in arguments
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ResultsWarning)
        data = read_data([Path(name) for name in arguments if name != "--check"])
    _tell([f"note: {warning.message}" for warning in caught if issubclass(warning.category, ResultsWarning)])  # of folders of this machine
    notes: list[str] = []
    made = sections_of(data, notes)
    texts = {f"{PAGE.stem}/data/{name}": write_frame(frame) for name, frame in data.items()}
    texts |= {f"{PAGE.stem}/{name}": text for name, text in file_texts(made).items()}
    texts[PAGE.name] = made_page(data, made, notes)
    pictures = [f"{PAGE.stem}/{FIGURES}/{picture.name}.{ending}" for section in made for picture in section.pictures for ending in ENDINGS]
    if check:
        return _tell([*_other(texts), *(f"{name}: missing" for name in pictures if not (PAGE.parent / name).is_file())])
    for name, text in texts.items():
        write_whole(PAGE.parent / name, text)
    for name, content in drawn(made).items():
        write_whole(PAGE.parent / PAGE.stem / name, content)
    _tell([f"note: {note}" for note in notes])
    kept = {*texts, *pictures}
    for path in (*DATA.parent.glob("tables/*"), *DATA.parent.glob(f"{FIGURES}/*")):
        if path.relative_to(PAGE.parent).as_posix() not in kept:
            path.unlink()
    return 0


def read_data(sources: Sequence[Path]) -> dict[str, pd.DataFrame]:
    """Returns the tables of the data by the name of their file, those of more sources taken in."""
    files = [path for path in sources if path.suffix == ".json"]
    catalogues = [path for path in files if "sort" not in read_json(path)]
    random = [row for path in catalogues for row in random_of(path)]
    results, curves = load_both([DATA, *(path for path in sources if path not in files)], random)
    speeds = read_speeds(DATA, [path for path in files if path not in catalogues])
    return {RESULTS: results, CURVES: curves, **{FILES[name]: frame for name, frame in speeds.items()}}


def random_of(catalogue: Path) -> list[dict[str, Any]]:
    """Returns what a random policy earns in the bundled games, by the file that the catalogue keeps it in."""
    rows = []
    for game, entry in read_json(catalogue).items():
        figure = entry["values"][RANDOM]
        found = {"collective_return": figure["mean"], "low": figure["low"], "high": figure["high"], "episodes": entry["episodes"]}
        rows.append({"record": "random", "game": game, "hash": current_hash(entry["hash"]), **found})
    return rows


def sections_of(data: dict[str, pd.DataFrame], notes: list[str]) -> list[Section]:
    """Returns the sections of the page, and adds what is to be noted of them."""
    frame = under_the_papers_rules(data[RESULTS])
    games = games_of(frame)
    notes += rivals(games)
    return [
        sections.findings(games, frame),
        sections.own_and_common(games, frame),
        learning_curves(frame, data[CURVES]),
        sections.sharing(games),
        sections.exchange(games),
        sections.svo(games),
        sections.metrics(games),
        sections.over_games(games, frame),
        sections.diagrams(frame),
        cross_play(frame),
        speed(data[FILES["speeds"]]),
        hours(data[FILES["updates"]]),
    ]


def made_page(data: dict[str, pd.DataFrame], made: Sequence[Section], notes: Sequence[str]) -> str:
    """Returns the text of the page."""
    seen = f"{PAGE.stem}/data"
    how = [
        METHOD[0],
        "How many seeds stand behind a published figure is not known. So nothing is tested against one: "
        "the difference is given, and whether theirs lies in our interval.",
        *method(games_of(under_the_papers_rules(data[RESULTS]))),
        f"All that the page is made of is in [{seen}]({seen}): more rows there, and the same command, make it again.",
    ]
    by = "Written by `make results`; what is changed here by hand is lost when it is written again."
    return page_text("Results", by, made, how, notes, f"{PAGE.stem}/")


def _other(texts: dict[str, str]) -> list[str]:
    """Returns the files that are not as they would be written."""
    paths = {name: PAGE.parent / name for name in texts}
    return [
        f"{path}: {'not what its results say' if path.is_file() else 'missing'}"
        for name, path in paths.items()
        if not path.is_file() or path.read_text(encoding="utf-8") != texts[name]
    ]


def _tell(lines: Sequence[str]) -> int:
    for line in lines:
        print(line, file=sys.stderr)
    return int(bool(lines))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
