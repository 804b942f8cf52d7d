"""Measures the figures of Melting Pot itself that our games are tested against, and writes them as TOML.

It runs in a Python of its own, with nothing of sjdsl; bench/meltingpot_original.py says how that is made:

    original/bin/python bench/meltingpot_figures.py dm-meltingpot-2.4.1 tests/meltingpot/original.toml

Steps are counted from 1; "after" is the number of steps from that of the cause. Random play takes most of the time, some minutes.
"""

import argparse
import statistics
from collections.abc import Callable
from typing import Any

import numpy as np
from original_play import Play, find_melting_pot
from original_scenes import (
    INTERACT,
    ZAP,
    Figures,
    boat_race,
    drying,
    hidden_agenda,
    machines,
    meetings,
    paintball,
    predators,
    set_parts,
    sowing,
    zaps,
)

EPISODES, STEPS = 10, 1000  # of random play
ENDING = "StochasticIntervalEpisodeEnding"


def endings() -> Figures:
    """Returns for each substrate the first step in which it may end by chance, and of one the step after that."""
    from meltingpot.configs import substrates

    found: Figures = {}
    for name in sorted(substrates.SUBSTRATES):
        config = substrates.get_config(name)
        roles = config.default_player_roles
        settings = config.lab2d_settings_builder(roles=roles, config=config)
        if set_parts(settings, ENDING) and settings["maxEpisodeLengthFrames"] > 1000:  # others are cut off before it can happen
            found[name] = ends(name)
    again = ends("coins", minimumFramesPerEpisode=found["coins"] + 1) - found["coins"]
    return {"first_ending": found, "period": again}


def ends(name: str, **values: Any) -> int:
    """Returns the step in which an episode ends if it does so as soon as it may."""

    def change(settings: Any) -> None:
        set_parts(settings, ENDING, probabilityTerminationPerInterval=1.0, **values)
        settings["spriteSize"] = 1

    play = Play(name, change=change, places=False)
    steps = play.steps_until(lambda p: p.seen.last(), most=5000)
    play.env.close()
    return steps


def names() -> Figures:
    """Returns what each substrate lets a player observe, in its order, without the picture."""
    from meltingpot.configs import substrates

    return {
        name: [n for n in substrates.get_config(name).individual_observation_names if n != "RGB"] for name in sorted(substrates.SUBSTRATES)
    }


PLAYED = ("coins", "commons_harvest__open", "externality_mushrooms__dense", "predator_prey__open", "territory__rooms")


USES = dict.fromkeys(
    ("allelopathic_harvest__open", "clean_up", "commons_harvest__closed", "commons_harvest__open", "commons_harvest__partnership",
     "externality_mushrooms__dense", "paintball__capture_the_flag", "paintball__king_of_the_hill", "territory__open"), ZAP,
) | {"coop_mining": {"mine": 1}, "gift_refinements": {"refineAndGift": 1}, "prisoners_dilemma_in_the_matrix__arena": INTERACT}  # fmt: skip


def ready() -> Figures:
    """Returns READY_TO_SHOOT in the step in which a player uses its beam and in the steps after it, up to the first 1."""
    found: Figures = {}
    for name, action in USES.items():
        play = Play(name, places=False).step(action)
        found[name] = [round(play.told("READY_TO_SHOOT"), 3)]
        while found[name][-1] < 1:
            found[name].append(round(play.step().told("READY_TO_SHOOT"), 3))
    return found


def starts() -> Figures:
    """Returns the rows and columns of the starts of Territory: Open."""
    from meltingpot.configs import substrates

    rows = substrates.get_config("territory__open").layout.ascii_map.strip("\n").split("\n")
    return {"territory__open": [[r, c] for r, row in enumerate(rows) for c, letter in enumerate(row) if letter == "P"]}


def random_play(name: str, episodes: int = EPISODES) -> Figures:
    """Returns the mean reward of all players together in the first thousand steps of random play, and its standard error."""
    random, returns = np.random.default_rng(0), []
    for _ in range(episodes):
        play = Play(name, change=lambda s: s.update(spriteSize=1), places=False)
        choices, total = [spec.num_values for spec in play.env.action_spec()], 0.0
        for _ in range(STEPS):
            seen = play.env.step(random.integers(choices).tolist())
            total += float(np.sum(seen.reward))
            if seen.last():
                break
        returns.append(total)
        play.env.close()
    return _mean_of(returns, 3)


def one_shot() -> Figures:
    """Returns the mean length of the one_shot episodes under random play, and its standard error."""
    random, lengths = np.random.default_rng(0), []
    for _ in range(10 * EPISODES):
        play = Play("running_with_scissors_in_the_matrix__one_shot", change=lambda s: s.update(spriteSize=1), places=False)
        choices, steps = [spec.num_values for spec in play.env.action_spec()], 0
        ended = False
        while not ended:
            ended = play.env.step(random.integers(choices).tolist()).last()
            steps += 1
        lengths.append(steps)
        play.env.close()
    return _mean_of(lengths, 1)


def _mean_of(values: list[float], digits: int) -> Figures:
    error = statistics.stdev(values) / len(values) ** 0.5
    return {"episodes": len(values), "mean": round(statistics.mean(values), digits), "error": round(error, digits)}


def main() -> None:
    """Writes the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("source", help="the unpacked source archive of dm-meltingpot")
    parser.add_argument("out", help="the file to write; the Lua of the substrates prints to standard output")
    parser.add_argument("sections", nargs="*", default=[*ALL], help="all by default")
    asked = parser.parse_args()
    find_melting_pot(asked.source)
    with open(asked.out, "w", encoding="utf-8") as file:
        print(HEAD, file=file)
        for title in asked.sections:
            lines = [f"{name} = {written(value)}" for name, value in ALL[title]().items()]
            print(f"\n[{title}]", *lines, sep="\n", file=file, flush=True)


HEAD = """\
# Figures of Melting Pot itself, measured by bench/meltingpot_figures.py, that tests/meltingpot/test_original.py asserts of our games.
# dm-meltingpot 2.4.1 (commit 81ee2e7), dmlab2d 1.0.2, Python 3.11. `starts` and `observations` were read from its configurations; all else
# was run, on its own maps and on small ones, with scripted or random players.
# Steps count from 1; a figure that is not said to be a step is the number of steps after that of the cause."""
ALL: dict[str, Callable[[], Figures]] = {
    "endings": endings,
    "zaps": zaps,
    "waits": lambda: {"sowing": sowing(), "drying": drying(), "paintball_back": paintball()},
    "meetings": meetings,
    "hidden_agenda": hidden_agenda,
    "boat_race": boat_race,
    "factory_commons": lambda: {"released": machines()},
    "predator_prey": predators,
    "starts": starts,
    "observations": names,
    "ready_to_shoot": ready,
    "returns_of_random_play": lambda: {name: random_play(name) for name in PLAYED},
    "length_of_random_play": one_shot,
}


def written(value: Any) -> str:
    """Returns a value as TOML; numbers without a fraction as integers."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {written(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    if isinstance(value, float) and value.is_integer():
        return str(int(value))
    return f'"{value}"' if isinstance(value, str) else str(value)


if __name__ == "__main__":
    main()
