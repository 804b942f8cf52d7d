"""Repairs one fault of SocialJax at a time in a copy of its code, and prints what that changes for its trained policies.

    git clone https://github.com/cooperativex/SocialJax && git -C SocialJax checkout 9df972d
    .venv/bin/python -m bench.socialjax_repairs SocialJax --episodes 48

These are faults that our variants `socialjax` don't have.
"""

import argparse
import shutil
import sys
import tempfile
from pathlib import Path

import jax

from bench.socialjax_games import BRIDGES, Figures
from bench.socialjax_rules import play_suite, print_heading, print_rows, trained_policy

FILES = {
    "clean_up": "cleanup/clean_up.py",
    "harvest_open": "common_harvest/harvest_open.py",
    "territory": "territory/territory_env.py",
}
RESPAWNED = "state = state.replace(reborn_locs=new_re_locs)\n"
MOVED = """left = state.grid.at[new_locs[:, 0], new_locs[:, 1]].set(jnp.int16(Items.empty))
            state = state.replace(grid=left.at[new_re_locs[:, 0], new_re_locs[:, 1]].set(self._agents))
            state = state.replace(agent_locs=new_re_locs)
"""
BARE = "grid_apple[apple_locs[0], apple_locs[1]] == Items.empty"
BARE_OR_MARKED = "jnp.isin(grid_apple[apple_locs[0], apple_locs[1]], jnp.array([0, 2, 9]))"
Change = tuple[str, str]  # text of the suite's code, and what replaces it

# By what is right then: the changes of a game's file, and the games.
REPAIRS: dict[str, tuple[list[Change], list[str]]] = {
    "all four headings": ([("maxval=3", "maxval=4")], [*FILES]),
    "who is hit is sent off at once": ([(RESPAWNED, RESPAWNED + " " * 12 + MOVED)], [*FILES]),
    "dirt falls on all clean cells alike": ([("* 1e-4", "* 0.1")], ["clean_up"]),
    "apples grow under marks": ([(BARE, BARE_OR_MARKED)], ["clean_up"]),
}


def main() -> None:
    """Prints a table of each repair."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("checkout", type=Path, help="a checkout of SocialJax")
    add("--repairs", nargs="*", default=[*REPAIRS], help="by their names")
    add("--games", nargs="*", default=[*FILES], help="of ours")
    add("--episodes", type=int, default=48, help="with and without each repair")
    add("--seed", type=int, default=1)
    asked = parser.parse_args()
    print_heading("suite", "repaired")
    for game in asked.games:
        before = play_trained(asked.checkout, game, asked.episodes, asked.seed)
        for name in asked.repairs:
            changes, games = REPAIRS[name]
            if game in games:
                with tempfile.TemporaryDirectory() as folder:
                    copy = Path(folder) / "suite"
                    copy_repaired(asked.checkout, copy, FILES[game], changes)
                    after = play_trained(copy, game, asked.episodes, asked.seed + 1)
                print_rows(f"`{game}`, {name}", before, after)


def copy_repaired(checkout: Path, copy: Path, file: str, changes: list[Change]) -> None:
    """Copies a checkout, with these changes in one file of its games.

    Raises:
      ValueError: the file hasn't the text of a change.
    """
    shutil.copytree(checkout, copy, ignore=shutil.ignore_patterns(".git"))
    path = copy / "socialjax" / "environments" / file
    movement = path.parent.parent / "movement.py"
    for old, new in changes:
        text = path.read_text()
        if old not in text:
            raise ValueError(f"{path} has no text `{old}`; check out commit 9df972d")
        path.write_text(text.replace(old, new))
        movement.write_text(movement.read_text().replace(f"dir_{old}", f"dir_{new}"))


def play_trained(checkout: Path, game: str, episodes: int, seed: int) -> Figures:
    """Returns the figures of episodes of the game's trained policy in the suite's code, `[E]`."""
    for name in list(sys.modules):  # of another copy of the suite
        if name.startswith("socialjax."):
            del sys.modules[name]
    bridge = BRIDGES[game](checkout)
    policy = trained_policy(checkout / "checkpoints" / bridge.checkpoint)
    return play_suite(bridge, policy, episodes, jax.random.key(seed), stepwise=False)[0]


if __name__ == "__main__":
    main()
