"""The page of Melting Pot's substrates: for each the game and variant it is here, what differs, and what cannot be said."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from sjdsl.compiler import ir
from sjdsl.compiler.ir.hash import picture_hash
from sjdsl.doc.figures import SHOWN
from sjdsl.doc.wording import code, plain, table
from sjdsl.interpreter.threefry import Threefry
from sjdsl.substrates import Substrate

PICTURES = "pictures/meltingpot"
STEPS = 20  # of random play before the picture
SEED = 0
INTRODUCTION = """Each substrate of Melting Pot 2 is a bundled game in one of its variants. Families that are also among
[the games of sjdsl](games.md) are variants there. All others are files of [games/meltingpot/](../games/meltingpot).
This page is generated from [games/meltingpot.toml](../games/meltingpot.toml) by `sjdsl doc --all`. The code that
`sjdsl compile --all` writes, and the page of the games, are those of the games in `games/` itself."""
USE = """`sjdsl.make("GAME", variant="VARIANT")` makes one, and `sjdsl.interop.dm_env` takes the substrate's own name:

```python
from sjdsl.interop.dm_env import build, get_config

config = get_config("territory__rooms")
env = build("territory__rooms", config.default_player_roles)
```"""
EVERYWHERE = (
    "Observations are planes of tokens, not pictures of 8 × 8 pixels; `sjdsl.interop.dm_env` gives pictures. "
    "There, a player sees 11 × 11 cells as 88 × 88 pixels in three colours: 23,232 bytes. "
    "Here, such a window has 121 bytes a plane of tokens; a game has 2 to 16 planes. One-hot observations have 121 floats a channel, 11 to 106 channels.",
    "Random numbers are others.",
    "All agents act at once on the state before the step; there, they act in a random order within it.",
    "Waits, pauses and periods last as long as there. [Figures of the original](../tests/meltingpot/original.toml), which "
    "[a script](../bench/meltingpot_figures.py) measures, are tested against ours.",
    "Starting places are visible here, except in games that hide them; in the original they look like floor.",
    "Who comes back can fire in the next step; there, in some games, only after a whole pause.",
    "`sjdsl.interop.dm_env` gives the observations that a substrate lists beside its picture, but for `MY_OFFER`, `OFFERS`, `HUNGER`, "
    "`NUM_OTHERS_WHO_CLEANED_THIS_STEP` and `MISMATCHED_COIN_COLLECTED_BY_PARTNER`.",
)


def melting_pot_page(entries: Sequence[Substrate], rules: Mapping[str, ir.Game]) -> str:
    """Returns the page as Markdown.

    Args:
      entries: all substrates.
      rules: the rules of those that have been written, by the substrate's name.
    """
    written = [e for e in entries if e.name in rules]
    missing = [e for e in entries if e.name not in rules]
    lines = ["# Melting Pot", "", INTRODUCTION, "", USE, "", "What differs everywhere:", "", *(f"* {text}" for text in EVERYWHERE), ""]
    lines += [*table(("substrate", "game", "variant", "agents", "map"), [_row(e, rules[e.name]) for e in written]), ""]
    lines += ["## What differs", "", "Without a substrate named, a sentence is about all of the game's.", ""]
    lines += [*table(("game", "what differs, and why", "what cannot be said, and the construct it would want"), _by_game(written)), ""]
    if missing:
        lines += ["Not written yet:", "", *(f"* {code(e.name)}" for e in missing), ""]
    lines += ["## Pictures", "", f"Each shows a game after {STEPS} steps of random play, drawn by `sjdsl doc --all`.", ""]
    for e in written:
        lines += [f"### {code(e.name)}", "", f"![{plain(rules[e.name].title)}]({PICTURES}/{e.name}.png)", ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def _row(e: Substrate, game: ir.Game) -> tuple[str, ...]:
    size = f"{len(game.rows)} × {len(game.rows[0])}"
    return (code(e.name), code(e.game), code(e.variant) if e.variant else "", str(game.agents.number), size)


def _by_game(written: Sequence[Substrate]) -> list[tuple[str, ...]]:
    """Returns for each game what is said of its substrates: once what is said of all, else with the names."""
    games = dict.fromkeys(e.game for e in written)
    members = {game: [e for e in written if e.game == game] for game in games}
    told = [(code(game), _told({e.name: e.differs for e in m}), _told({e.name: e.wanting for e in m})) for game, m in members.items()]
    return [row for row in told if row[1] or row[2]]


def _told(texts: Mapping[str, tuple[str, ...]]) -> str:
    """Returns the sentences in the order in which they first appear. texts: by substrate."""
    found = []
    for text in dict.fromkeys(text for several in texts.values() for text in several):
        names = [name for name, several in texts.items() if text in several]
        found.append(text if len(names) == len(texts) else f"{', '.join(map(code, names))}: {text}")
    return " ".join(found)


def draw_start(e: Substrate, path: Path) -> None:
    """Writes a picture of a substrate after some steps of random play, taken by the interpreter, which needs no compilation by XLA."""
    import jax
    import numpy as np

    from sjdsl.factory import make
    from sjdsl.interpreter.state import default_params
    from sjdsl.interpreter.step import reset, step
    from sjdsl.render import make_painter, save_png, take_snapshot
    from sjdsl.testing.states import compiled_state

    env = make(e.game, variant=e.variant or None)
    chosen = np.random.default_rng(SEED)
    params = default_params(env.game)
    world = reset(env.game, params, Threefry(SEED, 0))
    returns = np.zeros(env.num_agents)
    for number in range(1, STEPS + 1):
        actions = chosen.integers(env.num_actions, size=env.num_agents).tolist()
        world, outcome = step(env.game, world, actions, params, Threefry(SEED, number))
        returns = returns + np.asarray(outcome.reward)
    state = compiled_state(env, jax.device_get(env.module.initial_state()), world)
    path.parent.mkdir(parents=True, exist_ok=True)
    save_png(make_painter(env).draw(take_snapshot(env, state, returns)), path, {SHOWN: picture_hash(env.game)})
