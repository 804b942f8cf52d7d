"""Schelling diagrams: plays k = 0 .. N cooperators among defectors, and writes whether the game is
a dilemma.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sjdsl.experiments.diagram import Diagram, report_of, returns_of
from sjdsl.experiments.folder import DIAGRAM, record_experiment, require_same, write_compact_json
from sjdsl.experiments.lineups import cooperating
from sjdsl.experiments.pictures import draw_diagram, picture_bytes
from sjdsl.experiments.playing import (
    Experiment,
    Tell,
    check_episodes,
    find_pools,
    open_talks,
    play_experiment,
)
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.usage import by_wording
from sjdsl.files import write_whole
from sjdsl.models import Limits
from sjdsl.runtime.policy import Policy
from sjdsl.trainers.environment import Environment

FORMATS = ("png", "svg")


def schelling_diagram(
    env: Environment,
    cooperators: str | Path | Policy,
    defectors: str | Path | Policy,
    *,
    episodes: int = 30,
    seed: int = 0,
    folder: Path | str | None = None,
    limits: Limits | None = None,
    tell: Tell = lambda _: None,
) -> Diagram:
    """Plays k cooperators with N - k defectors for k = 0 .. N.

    Episode e has the same start and the same order of slots for every k; the agents in the first k
    of them cooperate. Seed i of one pool plays with seed i of the other: see `pair_pools`.

    Args:
      env: one environment of N agents, at least two.
      cooperators, defectors: policies as `find_pool` takes them.
      episodes: the number for each k and replicate.
      seed: the seed of the episodes.
      folder: where `schelling.json`, `.png` and `.svg` are written: a new or empty folder, or one
        of the same experiment. None: nothing is written.
      limits: of the calls of models.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: something doesn't fit. OSError: the disk is full.
      ModelError: a model can't be asked, or a limit is reached.
    """
    experiment = plan_diagram(env, cooperators, defectors, episodes, seed)
    return play_diagram(experiment, folder, tell, limits)


def play_diagram(
    experiment: Experiment, folder: Path | str | None, tell: Tell, limits: Limits | None = None
) -> Diagram:
    """Plays a plan of `plan_diagram`; see `schelling_diagram`."""
    description = describe_diagram(experiment)
    path = None if folder is None else Path(folder)
    if path is not None:
        require_same(path, description)
    with open_talks(experiment, path, description, limits, tell) as talks:
        parts = play_experiment(experiment, tell, talks)
    returns = returns_of(parts, experiment.env.num_agents, experiment.replicates)
    earned = by_wording(experiment, parts)
    diagram = Diagram(experiment, returns, talks.account.by_policy(), earned)
    if path is not None:
        write_diagram(diagram, path, description)
    return diagram


def describe_diagram(experiment: Experiment) -> dict[str, Any]:
    """Returns everything that the results depend on, as JSON values."""
    return {"experiment": "schelling", **experiment.describe()}


def plan_diagram(
    env: Environment,
    cooperators: str | Path | Policy,
    defectors: str | Path | Policy,
    episodes: int,
    seed: int,
) -> Experiment:
    """Plans `schelling_diagram`, and raises the same errors."""
    check_episodes(episodes)
    slots = env.num_agents
    if slots < 2:
        raise ExperimentError(
            f"a Schelling diagram needs at least two agents, and {env.name} has one here; "
            "ask for more with --agents"
        )
    pools = find_pools((cooperators, defectors), env)
    lineups = tuple(cooperating(k, slots) for k in range(slots + 1))
    return Experiment(env, pools, lineups, episodes, seed, permuted=True)


def write_diagram(diagram: Diagram, folder: Path, description: Mapping[str, Any]) -> None:
    """Writes the description of the experiment, `schelling.png`, `schelling.svg` and
    `schelling.json`.

    Each file is written atomically. The last one marks the experiment as complete.
    """
    pictures = {ending: picture_bytes(draw_diagram(diagram), ending) for ending in FORMATS}
    record_experiment(folder, description)
    for ending, picture in pictures.items():
        write_whole(folder / f"schelling.{ending}", picture)
    write_compact_json(folder / DIAGRAM, report_of(diagram))
