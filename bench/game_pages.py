"""Writes the tables, texts and pictures of the bundled games between the marks of docs/games.md and docs/meltingpot.md, or finds what is old.

    python -m bench.game_pages [--check]

What belongs to rules that have not changed is kept: pictures, and the figures of a random policy in docs/games.json. To make one of them
again, delete it.
"""

import argparse
import json
import math
import sys
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jax
from PIL import Image

from sjdsl.bench.markdown import replace_section
from sjdsl.compiler import Build, build, ir
from sjdsl.compiler.ir.hash import game_hash, picture_hash
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import Written, read_written
from sjdsl.doc.actions import action_rows
from sjdsl.doc.numbers import parameters
from sjdsl.doc.wording import code, joined, number, plain, table
from sjdsl.files import write_whole
from sjdsl.library.factory import make
from sjdsl.library.games_folder import find_game, main_games
from sjdsl.library.substrates import Substrate, written_substrates
from sjdsl.render import make_painter, save_png
from sjdsl.trainers import evaluate, random_policy, summarise
from website.boards import played

DOCS = Path(__file__).parents[1] / "docs"
PAGES = ("games", "meltingpot")
SEED = 0
EPISODES = 200  # of the figures
DIGITS = 6  # significant ones that are kept
STEPS = 60  # before the picture
SHOWN = "sjdsl:shown"  # the key of its digest in a picture's file
OURS = "our_"

# Of a game: the hash of its rules, `episodes`, `seed`, and `values`, each a mean with its 95 % interval; None if it is not always defined.
Figures = dict[str, Any]


def main() -> int:
    """Writes the pages, or with --check prints what is not up to date and returns 1 if there is anything."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="write nothing; exit with 1 if a page is not up to date",
    )
    if parser.parse_args().check:
        problems = [problem for page in PAGES for problem in page_problems(DOCS / f"{page}.md")]
        print(
            "\n".join(
                [*problems, "`make docs` brings everything up to date"]
                if problems
                else ["the pages are up to date"]
            )
        )
        return int(bool(problems))
    write_games(DOCS / "games.md")
    write_melting_pot(DOCS / "meltingpot.md")
    return 0


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
    write_whole(path, games_page(path.read_text("utf-8"), figures))


def write_melting_pot(path: Path) -> None:
    """Writes the page of Melting Pot's substrates."""
    games = {
        substrate.name: (substrate.game, substrate.variant) for substrate in written_substrates()
    }
    draw_pictures(path.parent / "pictures/meltingpot", games)
    write_whole(path, melting_pot_page(path.read_text("utf-8")))


def page_problems(path: Path) -> list[str]:
    """Returns what is out of date of `games.md` and its figures, or of `meltingpot.md`: text, figures, pictures."""
    text = path.read_text("utf-8")
    if path.stem == "meltingpot":
        pictures, rules, wanted, found = (
            path.parent / "pictures/meltingpot",
            substrate_rules(),
            melting_pot_page(text),
            [],
        )
    else:
        pictures, rules = (
            path.parent / "pictures",
            {name: written.game for name, written in game_texts().items()},
        )
        kept = read_figures(path.with_suffix(".json"))
        wanted = games_page(text, kept)
        found = [f"{name}: no figures" for name in rules if name not in kept]
        found += [
            f"{name}: the figures are of other rules"
            for name in rules
            if name in kept and kept[name]["hash"] != game_hash(rules[name])
        ]
        found += [f"{name}: figures of no game" for name in kept if name not in rules]
    drawn, there = (
        {pictures / f"{name}.png": game for name, game in rules.items()},
        set(pictures.glob("*.png")),
    )
    found += [f"{picture}: missing" for picture in sorted(drawn.keys() - there)]
    found += [f"{picture}: of no game" for picture in sorted(there - drawn.keys())]
    found += [
        f"{picture}: of other rules or looks"
        for picture in sorted(drawn.keys() & there)
        if not is_picture_of(picture, drawn[picture])
    ]
    return found if text == wanted else [*found, f"{path}: not what the games say"]


@cache
def game_texts() -> dict[str, Written]:
    """Returns the games of `games/` itself, by name."""
    return {name: read_written(read_source(find_game(name))) for name in main_games()}


@cache
def build_of(substrate: Substrate) -> Build:
    """Returns a written substrate built, with its warnings. Raises CompileError."""
    return build(
        read_source(find_game(substrate.game)),
        substrate.variant.split("+") if substrate.variant else (),
    )


def substrate_rules() -> dict[str, ir.Game]:
    """Returns the rules of the substrates that have been written, by name. Raises CompileError."""
    return {s.name: build_of(s).game for s in written_substrates()}


def draw_pictures(folder: Path, games: Mapping[str, tuple[str, str]]) -> None:
    """Draws pictures of games after some steps of their files' policies, in turn, on the interpreter, which needs no compilation by XLA.

    games: name of the picture -> the game and its variant; a picture of the same rules is kept.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, (game, variant) in games.items():
        path = folder / f"{name}.png"
        env = make(game, variant=variant or None)
        if path.is_file() and is_picture_of(path, env.game):
            continue
        *_, before, last = played(env.game, STEPS)
        picture = make_painter(env, [last.snapshot]).draw(
            last.snapshot, last.actions, before.snapshot
        )
        save_png(picture, path, {SHOWN: picture_hash(env.game)})


def is_picture_of(path: Path, game: ir.Game) -> bool:
    """Returns whether a picture has been drawn from these rules and looks."""
    with Image.open(path) as image:
        return image.info.get(SHOWN) == picture_hash(game)


def measure(name: str, episodes: int = EPISODES, seed: int = SEED) -> Figures:
    """Returns the figures of a bundled game under the policy that draws every action with equal probability."""
    env = make(name)
    found = summarise(evaluate(env, random_policy(env), jax.random.key(seed), episodes))
    wanted = figure_names(env.game)
    values = {
        shown: {end: _rounded(getattr(found[key], end)) for end in ("mean", "low", "high")}
        for key, shown in wanted.items()
    }
    return {"hash": env.hash, "episodes": episodes, "seed": seed, "values": values}


def figure_names(game: ir.Game) -> dict[str, str]:
    """Returns the figures that a page shows: their names in an evaluation -> their names on the page."""
    names = {
        "collective return": "return, summed over agents",
        "equality": "equality of returns (1 - Gini)",
    }
    for event in game.events:
        for _, name in counts_of(event):
            names[f"event {name}"] = f"`{name}`, in an episode" + (
                ", all agents" if event.per_agent else ""
            )
    for measured in game.measures:
        sort = "mean" if measured.mean else "final"
        names[f"{sort} {measured.name}"] = (
            f"`{measured.name}`, {'mean over steps' if measured.mean else 'at the end'}"
        )
    return names


def _rounded(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None


def read_figures(path: Path) -> dict[str, Figures]:
    """Returns the figures that a file keeps, by game; none if there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def figures_text(figures: Mapping[str, Figures]) -> str:
    """Returns figures as the text of their file."""
    return json.dumps(figures, indent=1, ensure_ascii=False) + "\n"


def games_page(page: str, figures: Mapping[str, Figures]) -> str:
    """Returns the page with what is between its marks: all games, and each game with its figures."""
    games = game_texts()
    said = dict.fromkeys(
        key for written in games.values() for key, _ in written.game.about if key != "summary"
    )
    keys = sorted(said, key=lambda key: key.startswith(OURS))
    head = ("game", "agents", "map", "actions", *(key.replace("_", " ") for key in keys))

    def row(name: str, game: ir.Game) -> tuple[str, ...]:
        about, actions = dict(game.about), str(len(game.agents.actions))
        return (
            f"[{plain(game.title)}](#{name})",
            str(game.agents.number),
            _size(game),
            actions,
            *(plain(about.get(k, "")) for k in keys),
        )

    overview = table(head, [row(name, written.game) for name, written in games.items()])
    each = [
        line
        for name, written in games.items()
        if name in figures
        for line in _game(name, written, figures[name])
    ]
    return replace_sections(page, {"games": [*overview, "", *each[:-1]]})


def replace_sections(page: str, sections: Mapping[str, Sequence[str]]) -> str:
    """Returns the page with the lines of each section between its marks."""
    for name, lines in sections.items():
        page = replace_section(page, name, "\n".join(lines) + "\n")
    return page


def _size(game: ir.Game) -> str:
    return f"{len(game.rows)} × {len(game.rows[0])}"


def _game(name: str, written: Written, figures: Figures) -> list[str]:
    game = written.game
    summary = dict(game.about).get("summary", "")
    lines = [
        f'<a id="{name}"></a>',
        "",
        f"## {plain(game.title)}",
        "",
        f"![{plain(game.title)}](pictures/{name}.png)",
        "",
    ]
    lines += [plain(summary), ""] if summary else []
    lines += [*_facts(name, written), "", "Numbers:", "", *parameters(written)]
    title = f"A random policy, {figures['episodes']} episodes from seed {figures['seed']}, means with their 95 % confidence intervals:"
    return [
        *lines,
        title,
        "",
        *table(
            ("", "mean", "interval"),
            [(name, *_figure(**f)) for name, f in figures["values"].items()],
        ),
        "",
    ]


def _facts(name: str, written: Written) -> list[str]:
    game = written.game
    rows = [
        ("agents", str(game.agents.number)),
        (
            "map",
            f"{len(game.rows)} rows of {len(game.rows[0])} cells"
            + (", edges joined" if game.wraps else ""),
        ),
        ("actions", joined(name for _, name, _ in action_rows(game))),
        ("window", _window(game.window)),
        *((key.replace("_", " "), plain(text)) for key, text in game.about if key != "summary"),
        ("sources", "; ".join(map(plain, game.cites))),
        ("all the rules", code(f"sjdsl doc {name}")),
    ]
    rows += [(f"variant {code(variant)}", plain(title)) for variant, title in written.variants]
    return table(("", ""), [row for row in rows if row[1]])


def _window(window: ir.Window) -> str:
    """Returns how far agents see; of several windows each, the usual one first."""
    sides = [
        f"{x.ahead} ahead, {x.behind} behind, {x.left} left, {x.right} right"
        for x in (window.views or (window,))[::-1]
    ]
    return sides[0] + "".join(f"; of some agents {other}" for other in sides[1:])


def _figure(mean: float | None, low: float | None, high: float | None) -> tuple[str, str]:
    if mean is None or low is None or high is None:
        return "not defined", "some returns are negative, or all are 0"
    short = [number(float(f"{value:.4g}")) for value in (mean, low, high)]
    return short[0], f"{short[1]} to {short[2]}"


def melting_pot_page(page: str) -> str:
    """Returns the page with what is between its marks: all substrates, and their pictures."""
    rules, written = substrate_rules(), written_substrates()
    rows = [
        (
            code(e.name),
            code(e.game),
            code(e.variant) if e.variant else "",
            str(rules[e.name].agents.number),
            _size(rules[e.name]),
        )
        for e in written
    ]
    pictures = [
        f"### {code(e.name)}\n\n![{plain(rules[e.name].title)}](pictures/meltingpot/{e.name}.png)\n"
        for e in written
    ]
    table_of_all = table(("substrate", "game", "variant", "agents", "map"), rows)
    return replace_sections(
        page, {"substrates": table_of_all, "pictures": [*pictures[:-1], pictures[-1].rstrip("\n")]}
    )


if __name__ == "__main__":
    sys.exit(main())
