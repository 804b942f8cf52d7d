"""Writes the tables, pictures and figures of the bundled games, or checks whether they are current.

    python -m bench.game_pages [--check]

Tables go between the marks of docs/games.md and docs/meltingpot.md. Pictures, and the figures of
a random policy in docs/games.json, are kept while the rules of their game don't change. To make one
of them again, delete it. The site's gallery shows the figures, and the studio's list of games shows
small pictures of their boards.
"""

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import jax
from PIL import Image

from sjdsl.bench.markdown import replace_section
from sjdsl.compiler import Build, build, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.ir.hash import game_hash, picture_hash
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import Written, read_written
from sjdsl.doc.wording import code, plain, table
from sjdsl.files import write_whole
from sjdsl.library.factory import make
from sjdsl.library.games_folder import find_game, main_games
from sjdsl.library.substrates import Substrate, written_substrates
from sjdsl.render import make_painter, save_png
from sjdsl.render.board import draw_board
from sjdsl.render.look import make_look
from sjdsl.studio import tour
from sjdsl.studio.examples import examples, place_of
from sjdsl.trainers import evaluate, random_policy, summarise
from website.boards import played
from website.gallery import substrate_title
from website.random_play import Figures, read_figures

DOCS = Path(__file__).parents[1] / "docs"
PAGES = ("games", "meltingpot")
SEED = 0
EPISODES = 200  # of the figures
SIGNIFICANT_DIGITS = 6
STEPS_BEFORE_PICTURE = 60
DIGEST_KEY = "sjdsl:shown"  # in the text of a picture's file
PICTURE_WIDTH = 110  # pixels, in the table of games
THUMBNAILS = DOCS.parent / "sjdsl/studio/thumbnails"
THUMBNAIL_SIZE = (96, 72)  # pixels at most
THUMBNAIL_COLOURS = 64


def main() -> int:
    """Writes the pages; --check prints what is not up to date and returns 1 if anything is not."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; exit with 1 if a page is not up to date",
    )
    if parser.parse_args().check:
        return check_pages()
    write_games(DOCS / "games.md")
    write_melting_pot(DOCS / "meltingpot.md")
    draw_thumbnails(THUMBNAILS)
    return 0


def check_pages() -> int:
    """Prints what is out of date; returns the exit status, 1 if anything is."""
    problems = [problem for page in PAGES for problem in page_problems(DOCS / f"{page}.md")]
    if not problems:
        print("the pages are up to date")
        return 0
    print("\n".join(problems))
    print("`make docs` brings everything up to date")
    return 1


def write_games(path: Path) -> None:
    """Writes the page of the games in `games/`, and its file of figures."""
    figures = read_figures(path.with_suffix(".json"))
    for name, written in game_texts().items():
        if name not in figures or figures[name]["hash"] != game_hash(written.game):
            print(f"{name}: measuring")
            figures[name] = measure(name)
    figures = {name: figures[name] for name in game_texts()}
    draw_pictures(path.parent / "pictures", {name: (name, "") for name in figures})
    write_whole(path.with_suffix(".json"), figures_text(figures))
    write_whole(path, games_page(path.read_text("utf-8")))


def write_melting_pot(path: Path) -> None:
    """Writes the page of Melting Pot's substrates."""
    games = {
        substrate.name: (substrate.game, substrate.variant) for substrate in written_substrates()
    }
    draw_pictures(path.parent / "pictures/meltingpot", games)
    write_whole(path, melting_pot_page(path.read_text("utf-8")))


def page_problems(path: Path) -> list[str]:
    """Returns what is out of date: tables, figures or pictures of `games.md` or `meltingpot.md`."""
    page = path.read_text("utf-8")
    problems: list[str] = []
    if path.stem == "meltingpot":
        folder = path.parent / "pictures/meltingpot"
        games = substrate_games()
        current = melting_pot_page(page)
    else:
        folder = path.parent / "pictures"
        games = {name: written.game for name, written in game_texts().items()}
        figures = read_figures(path.with_suffix(".json"))
        current = games_page(page)
        problems += figure_problems(games, figures)
    problems += picture_problems(folder, games)
    if page != current:
        problems.append(f"{path}: not what the games say")
    return problems


def figure_problems(games: Mapping[str, ir.Game], figures: Mapping[str, Figures]) -> list[str]:
    """Returns a line for each game without current figures, and for figures of no game."""
    problems = [f"{name}: no figures" for name in games if name not in figures]
    for name, kept in figures.items():
        if name not in games:
            problems.append(f"{name}: figures of no game")
        elif kept["hash"] != game_hash(games[name]):
            problems.append(f"{name}: the figures are of other rules")
    return problems


def picture_problems(folder: Path, games: Mapping[str, ir.Game]) -> list[str]:
    """Returns a line for each game without a current picture, and for each picture of no game."""
    game_of = {folder / f"{name}.png": game for name, game in games.items()}
    pictures = set(folder.glob("*.png"))
    problems = [f"{picture}: missing" for picture in sorted(game_of.keys() - pictures)]
    for picture in sorted(pictures):
        if picture not in game_of:
            problems.append(f"{picture}: of no game")
        elif not is_picture_of(picture, game_of[picture]):
            problems.append(f"{picture}: of other rules or looks")
    return problems


@cache
def game_texts() -> dict[str, Written]:
    """Returns the games of `games/` itself, by name."""
    return {name: read_written(read_source(find_game(name))) for name in main_games()}


@cache
def build_of(substrate: Substrate) -> Build:
    """Returns a written substrate built, with its warnings. Raises CompileError."""
    variants = substrate.variant.split("+") if substrate.variant else ()
    return build(read_source(find_game(substrate.game)), variants)


def substrate_games() -> dict[str, ir.Game]:
    """Returns the substrates that have been written, by name. Raises CompileError."""
    return {substrate.name: build_of(substrate).game for substrate in written_substrates()}


def draw_pictures(folder: Path, games: Mapping[str, tuple[str, str]]) -> None:
    """Draws a picture of each game after some steps, unless there is one of the same rules.

    games: name of the picture -> the game and its variant. The policies of the game's file play in
    turn, on the interpreter, which needs no compilation by XLA.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, (game, variant) in games.items():
        path = folder / f"{name}.png"
        env = make(game, variant=variant or None)
        if path.is_file() and is_picture_of(path, env.game):
            continue
        *_, before, last = played(env.game, STEPS_BEFORE_PICTURE)
        picture = make_painter(env, [last.snapshot]).draw(
            last.snapshot, last.actions, before.snapshot
        )
        save_png(picture, path, {DIGEST_KEY: picture_hash(env.game)})


def draw_thumbnails(folder: Path) -> None:
    """Draws the board with which each game in the studio's list begins, unless it is there.

    A base of other games, which has no map to play on, has none.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for path in (*examples(), *tour.games()):
        home, name = place_of(path, folder)
        try:
            game = build(read_source(home / name)).game
        except CompileError:
            continue
        thumbnail = folder / f"{Path(name).stem}.png"
        if thumbnail.is_file() and is_picture_of(thumbnail, game):
            continue
        start = next(played(game, 0))
        picture = Image.fromarray(draw_board(make_look(game), start.snapshot))
        picture.thumbnail(THUMBNAIL_SIZE, Image.Resampling.LANCZOS)
        save_png(picture.quantize(THUMBNAIL_COLOURS), thumbnail, {DIGEST_KEY: picture_hash(game)})


def is_picture_of(path: Path, game: ir.Game) -> bool:
    """Returns whether a picture has been drawn from these rules and looks."""
    with Image.open(path) as image:
        return image.info.get(DIGEST_KEY) == picture_hash(game)


def measure(name: str, episodes: int = EPISODES, seed: int = SEED) -> Figures:
    """Returns the figures of a bundled game played by the random policy."""
    env = make(name)
    summary = summarise(evaluate(env, random_policy(env), jax.random.key(seed), episodes))
    values = {}
    for key, name_on_page in figure_names(env.game).items():
        estimate = summary[key]
        values[name_on_page] = {
            "mean": _rounded(estimate.mean),
            "low": _rounded(estimate.low),
            "high": _rounded(estimate.high),
        }
    return {"hash": env.hash, "episodes": episodes, "seed": seed, "values": values}


def figure_names(game: ir.Game) -> dict[str, str]:
    """Returns the figures of a page: their names in an evaluation -> their names on the page."""
    names = {
        "collective return": "return, summed over agents",
        "equality": "equality of returns (1 - Gini)",
    }
    for event in game.events:
        all_agents = ", all agents" if event.per_agent else ""
        for _, name in counts_of(event):
            names[f"event {name}"] = f"`{name}`, in an episode{all_agents}"
    for measure in game.measures:
        if measure.mean:
            names[f"mean {measure.name}"] = f"`{measure.name}`, mean over steps"
        else:
            names[f"final {measure.name}"] = f"`{measure.name}`, at the end"
    return names


def _rounded(value: float) -> float | None:
    """Returns a figure with its significant digits; None if it isn't defined."""
    return float(f"{value:.{SIGNIFICANT_DIGITS}g}") if math.isfinite(value) else None


def figures_text(figures: Mapping[str, Figures]) -> str:
    """Returns figures as the text of their file."""
    return json.dumps(figures, indent=1, ensure_ascii=False) + "\n"


def replace_sections(page: str, sections: Mapping[str, Sequence[str]]) -> str:
    """Returns the page with the lines of each section between its marks."""
    for name, lines in sections.items():
        page = replace_section(page, name, "\n".join(lines) + "\n")
    return page


def games_page(page: str) -> str:
    """Returns the page with its table of all games current."""
    return replace_sections(page, {"games": _games_table(game_texts())})


def _games_table(games: Mapping[str, Written]) -> list[str]:
    """Returns the lines of the table of all games, each with its picture and its file."""
    rows = [
        (
            f'<img src="pictures/{name}.png" width="{PICTURE_WIDTH}" alt="">',
            f"[{plain(written.game.title)}](../games/{name}.sj)",
            code(name),
            str(written.game.agents.number),
            _paradigm(dict(written.game.about)),
            plain(dict(written.game.about).get("summary", "")),
        )
        for name, written in games.items()
    ]
    return table(("", "game", "name", "agents", "paradigm", "what it is about"), rows)


def _paradigm(about: Mapping[str, str]) -> str:
    """Returns the paradigm that the paper gives a game, or ours, marked so."""
    if "paradigm" in about:
        return plain(about["paradigm"])
    return f"{plain(about['our_paradigm'])} (ours)"


def _size(game: ir.Game) -> str:
    return f"{len(game.rows)} × {len(game.rows[0])}"


def melting_pot_page(page: str) -> str:
    """Returns the page with its sections current: a table of all substrates, and their pictures."""
    games = substrate_games()
    rows = []
    pictures = []
    for substrate in written_substrates():
        game = games[substrate.name]
        title = substrate_title(substrate, plain(game.title))
        file = find_game(substrate.game).relative_to(DOCS.parent).as_posix()
        name = code(substrate.game)
        if substrate.variant:
            name += f"<br>{code(substrate.variant)}"
        rows.append(
            (
                f"[{title}](../{file})<br>{code(substrate.name)}",
                name,
                str(game.agents.number),
                _size(game),
            )
        )
        pictures.append(f"### {title}\n\n![{title}](pictures/meltingpot/{substrate.name}.png)")
    sections = {
        "substrates": table(("game, substrate", "name, variant", "agents", "map"), rows),
        "pictures": ["\n\n".join(pictures)],
    }
    return replace_sections(page, sections)


if __name__ == "__main__":
    sys.exit(main())
