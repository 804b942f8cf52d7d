"""Schelling diagrams: plays k = 0 .. N cooperators with defectors, and writes what that says of a dilemma."""

from pathlib import Path

from sjdsl.experiments.diagram import Diagram, report_of, returns_of
from sjdsl.experiments.folder import open_folder
from sjdsl.experiments.lineups import cooperating
from sjdsl.experiments.pictures import draw_diagram, picture_bytes
from sjdsl.experiments.playing import Experiment, Tell, check_episodes, find_pools, play_experiment
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.result_files import write_compact_json
from sjdsl.files import write_whole
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
    tell: Tell = lambda _: None,
) -> Diagram:
    """Plays k cooperators with N - k defectors for k = 0 .. N.

    Episode e begins alike and gives the slots in the same order for every k; the first k of them cooperate. Of two pools seed i of one
    plays with seed i of the other: see `pair_pools`.

    Args:
      env: one environment of N agents, two at least.
      cooperators, defectors: policies as `find_pool` takes them.
      episodes: of each k and replicate.
      seed: of the episodes.
      folder: where what is played is kept, and looked for first; then `schelling.json`, `.png` and `.svg`. None: nothing is written.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: what does not fit. OSError: the disk is full; what was played stays.
    """
    return play_diagram(plan_diagram(env, cooperators, defectors, episodes, seed), folder, tell)


def play_diagram(experiment: Experiment, folder: Path | str | None, tell: Tell) -> Diagram:
    """Plays what `plan_diagram` planned; see `schelling_diagram`."""
    asked = {"experiment": "schelling", **experiment.describe()}
    with open_folder(None if folder is None else Path(folder), asked) as kept:
        parts = play_experiment(experiment, kept, tell)
        found = Diagram(experiment, returns_of(parts, experiment.env.num_agents, experiment.replicates))
        if kept is not None:
            write_diagram(found, kept.path)
    return found


def plan_diagram(
    env: Environment, cooperators: str | Path | Policy, defectors: str | Path | Policy, episodes: int, seed: int
) -> Experiment:
    """Returns what would be played. Raises as `schelling_diagram` does."""
    check_episodes(episodes)
    slots = env.num_agents
    if slots < 2:
        raise ExperimentError(f"a Schelling diagram needs two agents at least, and {env.name} has one here; ask for more with --agents")
    pools = find_pools((cooperators, defectors), env)
    return Experiment(env, pools, tuple(cooperating(k, slots) for k in range(slots + 1)), episodes, seed, permuted=True)


def write_diagram(found: Diagram, folder: Path) -> None:
    """Writes `schelling.json`, `schelling.png` and `schelling.svg`, each whole or not at all."""
    write_compact_json(folder / "schelling.json", report_of(found))
    for ending in FORMATS:
        write_whole(folder / f"schelling.{ending}", picture_bytes(draw_diagram(found), ending))
