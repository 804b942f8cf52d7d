"""The first paragraphs of a report: how its tables are read, how long was trained, and what common reward is in it."""

import json
from collections import defaultdict
from collections.abc import Iterable, Set

from sjdsl.report import published
from sjdsl.report.cells import short
from sjdsl.report.contents import Contents
from sjdsl.report.evidence import Run
from sjdsl.report.ways import NAMES


def opening(contents: Contents, command: str, data: str) -> list[str]:
    """Returns the paragraphs. `command`: the call that makes the report; `data`: the folder of what it is made of, as seen from the page."""
    return [
        f"Written by `{command}`; what is changed here by hand is lost when it is written again.",
        "A cell is the mean over training seeds with its 95 % interval by Student's t, in brackets. One seed has no interval. "
        "A cell with a seed whose loss was not finite has failed, and has no mean. "
        "Returns are summed over agents, and are means over the episodes in which the last policy of a seed was evaluated.",
        "How many seeds stand behind a published figure is not known. So nothing is tested against one: "
        "the difference is given, and whether theirs lies in our interval.",
        *_length(contents),
        *_common_reward([run for game in contents.games if game.setting is not None for run in contents.index.runs(game.setting)]),
        f"All that the page is made of is in [{data}]({data}): more rows there, and the same command, make it again.",
    ]


def _length(contents: Contents) -> list[str]:
    """Returns how many environment steps the seeds here and those of the paper have learnt from; nothing where no game is of the paper."""
    settings = [game.setting for game in contents.games if game.setting is not None and game.name in published.suite()]
    runs = [run for setting in settings for run in contents.index.runs(setting)]
    steps = [seed.steps for run in runs for seed in contents.index.seeds(run) if seed.status != "unfinished"]
    if not steps:
        return []
    fewest, most = short(min(steps)), short(max(steps))
    ours = fewest if fewest == most else f"{fewest} to {most}"
    return [
        f"A seed here has learnt from {ours} environment steps, one of the paper from {published.length()}. "
        "So a difference from a published figure can be one of the length of training as well as of anything else."
    ]


def _common_reward(runs: Iterable[Run]) -> list[str]:
    """Returns which ways of training have the mean of all rewards as common reward and which the sum; nothing where none has either."""
    names: dict[str, set[str]] = defaultdict(set)
    for run in runs:
        if run.reward == "common":
            kind = "sum" if run.algorithm == "vdn" else json.loads(run.settings).get("common_reward", "sum")  # VDN's values are of the sum
            names[kind].add(NAMES.get(run.algorithm, run.algorithm))
    if not names:
        return []
    both = names["mean"] & names["sum"]
    said = [f"their {kind} in {', '.join(_some(name, both) for name in sorted(names[kind]))}" for kind in ("mean", "sum") if names[kind]]
    return [f"Common reward is made of all agents' rewards: {'; '.join(said)}; in the paper their sum."]


def _some(algorithm: str, both: Set[str]) -> str:
    return f"some runs of {algorithm}" if algorithm in both else algorithm
