"""Writes docs/games.md and docs/meltingpot.md, the pages of the bundled games, with their pictures, and finds what of them is not up to date.

    python -m bench.game_pages [--check] [--fresh]

What belongs to rules that have not changed is kept: pictures, and the figures of a random policy in docs/games.json.
"""

import argparse
import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jax
from PIL import Image

from sjdsl.compiler import Build, build, ir
from sjdsl.compiler.ir.hash import game_hash, picture_hash
from sjdsl.compiler.ir.queries import counts_of
from sjdsl.compiler.lower import token_planes
from sjdsl.compiler.syntax.read import read_source
from sjdsl.doc import Written, read_written
from sjdsl.doc.actions import action_names
from sjdsl.doc.numbers import parameters
from sjdsl.doc.wording import code, codes, number, plain, table
from sjdsl.files import write_whole
from sjdsl.interop.socialjax_table import NOT_HERE, Entry, channels_of, differences, entries
from sjdsl.library.factory import make
from sjdsl.library.games_folder import find_game, main_games
from sjdsl.library.substrates import Substrate, substrates, written_substrates
from sjdsl.render import make_painter, save_png
from sjdsl.runtime.planes import channel_names
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
GAMES = """These games come with sjdsl. Each is a text of about eighty lines in [games/](../games), and this page is generated from them with
`make docs`. `sjdsl doc GAME` prints all the rules of a game in plain English, and `sjdsl diff GAME --variants A B`
prints what a variant changes. Melting Pot's other games are on the page [meltingpot.md](meltingpot.md).

Paradigm, long term impact, multi task and difficulty are those of the SocialJax paper (ICLR 2026), for the games it has. Columns that begin
with `our` are our own judgement; a comment in the game's file gives the reason."""
VARIANT = "socialjax"
HEADINGS = ("agent: self", "agent: other same heading", "agent: other turned right", "agent: other opposite", "agent: other turned left")
OWN_HEADING = tuple(f"agent.heading: {way}" for way in ("north", "east", "south", "west"))  # in the table's row on windows
RELEASED = """Each game of the paper has a variant `socialjax` with the rules and the observation of the released code. Things that look alike
to its agents look alike here too. This table lists all remaining differences. The first rows come from comparing the observations' channels."""
MELTING_POT = """Each substrate of Melting Pot 2 is a bundled game, or a variant of one. Where [sjdsl already has the game](games.md) (Clean Up,
Coins, ...), the substrate is its variant `meltingpot`; otherwise it has its own file in [games/meltingpot/](../games/meltingpot).
`make docs` generates this page from [games/meltingpot.toml](../games/meltingpot.toml)."""
USE = """Make one with `sjdsl.make("GAME", variant="VARIANT")`, or by the substrate's own name with [`sjdsl.interop.dm_env`](interop/dm_env.md):

```python
from sjdsl.interop.dm_env import build, get_config

config = get_config("territory__rooms")
env = build("territory__rooms", config.default_player_roles)
```"""
EVERYWHERE = (
    "Observations are planes of tokens, not pictures of 8 × 8 pixels a cell; `sjdsl.interop.dm_env` gives pictures. "
    "In the original, a player sees 11 × 11 cells as 88 × 88 pixels in three colours: 23,232 bytes. "
    "Here, such a window has 121 bytes a plane of tokens, and a game 2 to 16 planes; one-hot observations have 121 floats a channel, 11 to 106 channels.",
    "Random draws differ.",
    "All agents act at once on the state before the step; in the original, they act in a random order within it.",
    "Waits, pauses and periods are as long as in the original: tests compare them with "
    "[figures measured there](../tests/meltingpot/original.toml).",
    "Starting places are visible, except in games that hide them; in the original, they look like floor.",
    "A player who comes back can fire in the next step; in some games of the original, only after a full waiting time.",
    "`sjdsl.interop.dm_env` gives the observations that a substrate lists in addition to its picture, except `MY_OFFER`, `OFFERS`, `HUNGER`, "
    "`NUM_OTHERS_WHO_CLEANED_THIS_STEP` and `MISMATCHED_COIN_COLLECTED_BY_PARTNER`.",
)


# Of a game: the hash of its rules, `episodes`, `seed`, and `values`, each a mean with its 95 % interval; None if it is not always defined.
Figures = dict[str, Any]


def main() -> int:
    """Writes the pages, or with --check prints what is not up to date and returns 1 if there is anything."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit with 1 if a page is not up to date")
    parser.add_argument("--fresh", action="store_true", help="measure and draw again, also where the rules have not changed")
    asked = parser.parse_args()
    if asked.check:
        problems = [problem for page in PAGES for problem in page_problems(DOCS / f"{page}.md")]
        print("\n".join([*problems, "`make docs` brings everything up to date"] if problems else ["the pages are up to date"]))
        return int(bool(problems))
    write_games(DOCS / "games.md", asked.fresh)
    write_melting_pot(DOCS / "meltingpot.md", asked.fresh)
    return 0


def write_games(path: Path, fresh: bool) -> None:
    """Writes the page of the games in `games/`, and its file of figures."""
    figures = {} if fresh else read_figures(path.with_suffix(".json"))
    for name, written in game_texts().items():
        if name not in figures or figures[name]["hash"] != game_hash(written.game):
            print(f"{name}: measuring")
            figures[name] = measure(name)
    figures = {name: figures[name] for name in game_texts()}
    draw_pictures(path.parent / "pictures", {name: (name, "") for name in figures}, fresh)
    write_whole(path.with_suffix(".json"), figures_text(figures))
    write_whole(path, games_page(figures))


def write_melting_pot(path: Path, fresh: bool) -> None:
    """Writes the page of Melting Pot's substrates."""
    games = {substrate.name: (substrate.game, substrate.variant) for substrate in written_substrates()}
    draw_pictures(path.parent / "pictures/meltingpot", games, fresh)
    write_whole(path, melting_pot_page())


def page_problems(path: Path) -> list[str]:
    """Returns what is out of date of `games.md` and its figures, or of `meltingpot.md`: text, figures, pictures."""
    if path.stem == "meltingpot":
        pictures, rules, text = path.parent / "pictures/meltingpot", substrate_rules(), melting_pot_page()
        found = []
    else:
        pictures, rules = path.parent / "pictures", {name: written.game for name, written in game_texts().items()}
        kept = read_figures(path.with_suffix(".json"))
        text = games_page(kept)
        found = [f"{name}: no figures" for name in rules if name not in kept]
        found += [
            f"{name}: the figures are of other rules" for name in rules if name in kept and kept[name]["hash"] != game_hash(rules[name])
        ]
        found += [f"{name}: figures of no game" for name in kept if name not in rules]
    wanted, there = {pictures / f"{name}.png": game for name, game in rules.items()}, set(pictures.glob("*.png"))
    found += [f"{picture}: missing" for picture in sorted(wanted.keys() - there)]
    found += [f"{picture}: of no game" for picture in sorted(there - wanted.keys())]
    found += [
        f"{picture}: of other rules or looks" for picture in sorted(wanted.keys() & there) if not is_picture_of(picture, wanted[picture])
    ]
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        found.append(f"{path}: not what the games say")
    return found


@cache
def game_texts() -> dict[str, Written]:
    """Returns the games of `games/` itself, by name."""
    return {name: read_written(read_source(find_game(name))) for name in main_games()}


@cache
def build_of(substrate: Substrate) -> Build:
    """Returns a written substrate built, with its warnings. Raises CompileError."""
    return build(read_source(find_game(substrate.game)), substrate.variant.split("+") if substrate.variant else ())


def substrate_rules() -> dict[str, ir.Game]:
    """Returns the rules of the substrates that have been written, by name. Raises CompileError."""
    return {s.name: build_of(s).game for s in written_substrates()}


def draw_pictures(folder: Path, games: Mapping[str, tuple[str, str]], fresh: bool) -> None:
    """Draws pictures of games after some steps of their files' policies, in turn, on the interpreter, which needs no compilation by XLA.

    Args:
      games: name of the picture -> the game and its variant.
      fresh: whether pictures of unchanged rules are drawn again, too.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name, (game, variant) in games.items():
        path = folder / f"{name}.png"
        env = make(game, variant=variant or None)
        if not fresh and path.is_file() and is_picture_of(path, env.game):
            continue
        *_, before, last = played(env.game, STEPS)
        picture = make_painter(env, [last.snapshot]).draw(last.snapshot, last.actions, before.snapshot)
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
    values = {shown: {end: _rounded(getattr(found[key], end)) for end in ("mean", "low", "high")} for key, shown in wanted.items()}
    return {"hash": env.hash, "episodes": episodes, "seed": seed, "values": values}


def figure_names(game: ir.Game) -> dict[str, str]:
    """Returns the figures that a page shows: their names in an evaluation -> their names on the page."""
    names = {"collective return": "return, summed over agents", "equality": "equality of returns (1 - Gini)"}
    for event in game.events:
        for _, name in counts_of(event):
            names[f"event {name}"] = f"`{name}`, in an episode" + (", all agents" if event.per_agent else "")
    for measured in game.measures:
        sort = "mean" if measured.mean else "final"
        names[f"{sort} {measured.name}"] = f"`{measured.name}`, {'mean over steps' if measured.mean else 'at the end'}"
    return names


def _rounded(value: float) -> float | None:
    return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None


def read_figures(path: Path) -> dict[str, Figures]:
    """Returns the figures that a file keeps, by game; none if there is no such file."""
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def figures_text(figures: Mapping[str, Figures]) -> str:
    """Returns figures as the text of their file."""
    return json.dumps(figures, indent=1, ensure_ascii=False) + "\n"


def games_page(figures: Mapping[str, Figures]) -> str:
    """Returns the page as Markdown: all games, each game with its figures if there are any, and what the released suite shows otherwise."""
    games = game_texts()
    said = dict.fromkeys(key for written in games.values() for key, _ in written.game.about if key != "summary")
    keys = sorted(said, key=lambda key: key.startswith(OURS))
    head = ("game", "agents", "map", "actions", *(key.replace("_", " ") for key in keys))

    def row(name: str, game: ir.Game) -> tuple[str, ...]:
        about, actions = dict(game.about), str(len(game.agents.actions))
        return f"[{plain(game.title)}](#{name})", str(game.agents.number), _size(game), actions, *(plain(about.get(k, "")) for k in keys)

    overview = table(head, [row(name, written.game) for name, written in games.items()])
    lines = ["# The games", "", GAMES, "", *overview, ""]
    for name, written in games.items():
        lines += _game(name, written, figures.get(name))
    lines += released_section()
    return "\n".join(lines).rstrip("\n") + "\n"


def _size(game: ir.Game) -> str:
    return f"{len(game.rows)} × {len(game.rows[0])}"


def _game(name: str, written: Written, figures: Figures | None) -> list[str]:
    game = written.game
    summary = dict(game.about).get("summary", "")
    lines = [f'<a id="{name}"></a>', "", f"## {plain(game.title)}", "", f"![{plain(game.title)}](pictures/{name}.png)", ""]
    lines += [plain(summary), ""] if summary else []
    lines += [*_facts(name, written), "", "Numbers:", "", *parameters(written)]
    if figures is None:
        return [*lines, "The returns of a random policy have not been measured.", ""]
    title = f"A random policy, {figures['episodes']} episodes from seed {figures['seed']}, means with their 95 % confidence intervals:"
    return [*lines, title, "", *table(("", "mean", "interval"), [(name, *_figure(**f)) for name, f in figures["values"].items()]), ""]


def _facts(name: str, written: Written) -> list[str]:
    game = written.game
    rows = [
        ("agents", str(game.agents.number)),
        ("map", f"{len(game.rows)} rows of {len(game.rows[0])} cells" + (", edges joined" if game.wraps else "")),
        ("actions", codes(action_names(game.agents))),
        ("window", _window(game.window)),
        *((key.replace("_", " "), plain(text)) for key, text in game.about if key != "summary"),
        ("sources", "; ".join(map(plain, game.cites))),
        ("all the rules", code(f"sjdsl doc {name}")),
    ]
    rows += [(f"variant {code(variant)}", plain(title)) for variant, title in written.variants]
    return table(("", ""), [row for row in rows if row[1]])


def _window(window: ir.Window) -> str:
    """Returns how far agents see; of several windows each, the usual one first."""
    sides = [f"{x.ahead} ahead, {x.behind} behind, {x.left} left, {x.right} right" for x in (window.views or (window,))[::-1]]
    return sides[0] + "".join(f"; of some agents {other}" for other in sides[1:])


def _figure(mean: float | None, low: float | None, high: float | None) -> tuple[str, str]:
    if mean is None or low is None or high is None:
        return "not defined", "some returns are negative, or all are 0"
    return _short(mean), f"{_short(low)} to {_short(high)}"


def _short(value: float) -> str:
    """Returns four significant digits."""
    return number(float(f"{value:.4g}"))


def released_section() -> list[str]:
    """Returns the section of the page."""
    rows = [row for theirs, entry in entries().items() for row in _of_channels(theirs, entry)]
    for difference in differences():
        for theirs in difference.games or ("all",):
            rows.append((theirs, difference.what, difference.there, difference.here))
    together: dict[tuple[str, str, str], list[str]] = {}
    for theirs, *row in rows:
        together.setdefault((row[0], row[1], row[2]), []).append(theirs)
    found = [
        ("all" if theirs == ["all"] else ", ".join(code(entries()[name].game) for name in theirs), *map(plain, row))
        for row, theirs in together.items()
    ]
    heading = ['<a id="released"></a>', "", "## How observations in the released suite differ", "", RELEASED, ""]
    return [*heading, *table(("game", "what", "released", "here"), found), ""]


def _of_channels(theirs: str, entry: Entry) -> Iterator[tuple[str, str, str, str]]:
    """Yields what one of the two shows in some channel and the other in none."""
    for source in dict.fromkeys(s for s in [*entry.tiles, *entry.rest] if isinstance(s, str)):
        if source.startswith(NOT_HERE):
            yield theirs, source.removeprefix(NOT_HERE), "shown", "not shown"
    for name in unread(entry, released_game(entry.game)):
        yield theirs, name, "not shown", "shown"


def released_game(name: str) -> ir.Game:
    """Returns the rules of a game as released."""
    return read_written(read_source(find_game(name)), (VARIANT,)).game


def unread(entry: Entry, game: ir.Game) -> list[str]:
    """Returns our channels that say more than the released ones."""
    read = {name for source in [*entry.tiles, *entry.rest] for name in channels_of(source, game.agents.number)}
    read |= {name for layer in entry.layers for name in layer}
    known = {*read, *HEADINGS, *OWN_HEADING, "agent: none", *(f"content: {look}" for look in entry.plain)}
    return [name for name in channel_names(token_planes(game)) if name not in known]


def melting_pot_page() -> str:
    """Returns the page of all substrates as Markdown."""
    rules, written = substrate_rules(), written_substrates()
    missing = [e for e in substrates().values() if e.name not in rules]
    lines = [
        "# Melting Pot",
        "",
        MELTING_POT,
        "",
        USE,
        "",
        "Differences in every substrate:",
        "",
        *(f"* {text}" for text in EVERYWHERE),
        "",
    ]
    rows = [
        (code(e.name), code(e.game), code(e.variant) if e.variant else "", str(rules[e.name].agents.number), _size(rules[e.name]))
        for e in written
    ]
    lines += [*table(("substrate", "game", "variant", "agents", "map"), rows), ""]
    lines += ["## What differs", "", "A sentence applies to all substrates of its game, unless it names one.", ""]
    lines += [
        *table(
            ("game", "what differs from the original, and why", "what the language can't express, and what it would need"),
            _by_game(written),
        ),
        "",
    ]
    if missing:
        lines += ["Not written yet:", "", *(f"* {code(e.name)}" for e in missing), ""]
    lines += [
        "## Pictures",
        "",
        f"Each picture shows a game after {STEPS} steps, at most, of the policies of its file, in turn; or of random agents where it has none.",
        "",
    ]
    for e in written:
        lines += [f"### {code(e.name)}", "", f"![{plain(rules[e.name].title)}](pictures/meltingpot/{e.name}.png)", ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def _by_game(written: Sequence[Substrate]) -> list[tuple[str, ...]]:
    """Returns a row for each game: how its substrates differ, and what is missing, with their names unless it holds for all."""
    rows = []
    for game in dict.fromkeys(e.game for e in written):
        own = [e for e in written if e.game == game]
        rows.append((code(game), _merged({e.name: e.differs for e in own}), _merged({e.name: e.wanting for e in own})))
    return [row for row in rows if row[1] or row[2]]


def _merged(texts: Mapping[str, tuple[str, ...]]) -> str:
    """Returns all sentences once, in order, with the names of their substrates unless all have them. texts: by substrate."""
    found = []
    for text in dict.fromkeys(text for several in texts.values() for text in several):
        names = [name for name, several in texts.items() if text in several]
        found.append(text if len(names) == len(texts) else f"{', '.join(map(code, names))}: {text}")
    return " ".join(found)


if __name__ == "__main__":
    sys.exit(main())
