"""Cross-play: plays line-ups or mixtures of policies, and writes what each policy earned in each of
them.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sjdsl.experiments.folder import CROSS_PLAY, record_experiment, require_same, write_compact_json
from sjdsl.experiments.lineups import all_mixtures, paired_mixtures
from sjdsl.experiments.mixtures import CrossPlay, Mix, report_of, table_of
from sjdsl.experiments.pictures import draw_matrix, picture_bytes
from sjdsl.experiments.playing import (
    Experiment,
    Tell,
    check_episodes,
    find_pools,
    open_talks,
    play_experiment,
)
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.files import write_whole
from sjdsl.models import Limits
from sjdsl.runtime.policy import Policy
from sjdsl.several import several
from sjdsl.trainers.environment import Environment


def cross_play(
    env: Environment,
    *,
    slots: str | Path | Policy | Sequence[str | Path | Policy] | None = None,
    policies: str | Path | Policy | Sequence[str | Path | Policy] | None = None,
    mix: Mix = "all",
    rotate: bool = False,
    episodes: int = 30,
    seed: int = 0,
    folder: Path | str | None = None,
    limits: Limits | None = None,
    tell: Tell = lambda _: None,
) -> CrossPlay:
    """Plays policies with each other.

    A run of several seeds is a pool, whose seed i plays with seed i of the other pools.

    Args:
      env: one environment of N agents.
      slots: N policies, one for each slot: a fixed line-up.
      policies: instead of `slots`: one policy, or P policies, whose mixtures are played; each
        episode draws who has which slot.
      mix: `all`: every mixture over N slots; `pairs`: one agent of a policy among N - 1 of another,
        and each with itself.
      rotate: of `slots`: in episode e slot i is played by policy (i + e) mod N.
      episodes: E, of each mixture and replicate.
      seed: the seed of the episodes. All mixtures have the same starts; those of a line-up are
        those of `evaluate` with `evaluation_key(seed)`.
      folder: where results are written: a new or empty folder, or one of the same experiment. None:
        nothing is written.
      limits: of the calls of models.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: something doesn't fit. OSError: the disk is full.
      ModelError: a model can't be asked, or a limit is reached.
    """
    in_slots = None if slots is None else several(slots)
    mixed = None if policies is None else several(policies)
    experiment = plan_cross_play(env, in_slots, mixed, mix, episodes, seed, rotate)
    return play_mixtures(experiment, mix if slots is None else None, folder, tell, limits)


def play_mixtures(
    experiment: Experiment,
    mix: Mix | None,
    folder: Path | str | None,
    tell: Tell,
    limits: Limits | None = None,
) -> CrossPlay:
    """Plays a plan of `plan_cross_play`; see `cross_play`. `mix`: None for a fixed line-up."""
    description = describe_cross_play(experiment, mix)
    path = None if folder is None else Path(folder)
    if path is not None:
        require_same(path, description)
    with open_talks(experiment, path, description, limits, tell) as talks:
        parts = play_experiment(experiment, tell, talks)
    results = CrossPlay(experiment, tuple(parts), mix, talks.account)
    if path is not None:
        write_cross_play(results, path, description)
    return results


def describe_cross_play(experiment: Experiment, mix: Mix | None) -> dict[str, Any]:
    """Returns everything that the results depend on, as JSON values."""
    return {
        "experiment": "crossplay",
        "mix": mix,
        "lineups": experiment.lineups,
        **experiment.describe(),
    }


def plan_cross_play(
    env: Environment,
    slots: Sequence[str | Path | Policy] | None,
    policies: Sequence[str | Path | Policy] | None,
    mix: Mix,
    episodes: int,
    seed: int,
    rotate: bool = False,
) -> Experiment:
    """Plans `cross_play`, and raises the same errors."""
    check_episodes(episodes)
    has_neither = slots is None and policies is None
    has_both = slots is not None and policies is not None
    if has_neither or has_both:
        raise ExperimentError(
            "give either slots, a policy for each agent, or policies, whose mixtures are played"
        )
    number = env.num_agents
    if number < 2:
        raise ExperimentError(
            f"cross-play needs at least two agents, and {env.name} has one here; ask for more with "
            "--agents, or see what one earns alone with `sjdsl evaluate`"
        )
    if slots is not None:
        if len(slots) != number:
            raise ExperimentError(
                f"{env.name} has {number} slots, but {len(slots)} policies are given; "
                "name one for each slot"
            )
        slot_pools = find_pools(slots, env)
        pools = tuple(dict.fromkeys(slot_pools))
        lineup = tuple(pools.index(pool) for pool in slot_pools)
        return Experiment(env, pools, (lineup,), episodes, seed, permuted=False, rotated=rotate)
    if rotate:
        raise ExperimentError("mixtures draw who has which slot; rotate goes with slots")
    if not policies:
        raise ExperimentError("name at least one policy")
    make_mixtures = all_mixtures if mix == "all" else paired_mixtures
    lineups = make_mixtures(len(policies), number)
    pools = find_pools(policies, env)
    for pool, count in Counter(pools).items():
        if count > 1:
            raise ExperimentError(
                f"`{pool.name}` is named twice; name it once, as its mixtures with itself are "
                "played anyway"
            )
    return Experiment(env, pools, lineups, episodes, seed, permuted=True)


def write_cross_play(results: CrossPlay, folder: Path, description: Mapping[str, Any]) -> None:
    """Writes the description of the experiment, `crossplay.csv`, `matrix.png` if it plays pairs,
    and `crossplay.json`.

    Each file is written atomically. The last one marks the experiment as complete.
    """
    matrix = picture_bytes(draw_matrix(results), "png") if results.mix == "pairs" else None
    record_experiment(folder, description)
    write_whole(folder / "crossplay.csv", table_of(results).encode())
    if matrix is not None:
        write_whole(folder / "matrix.png", matrix)
    write_compact_json(folder / CROSS_PLAY, report_of(results))
