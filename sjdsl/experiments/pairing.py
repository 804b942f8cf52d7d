"""Which seed of a pool plays with which of another: those of one number, so that a seed that diverged in one pool shifts nobody."""

import warnings
from collections.abc import Sequence
from dataclasses import replace

from sjdsl.experiments.players import Pool
from sjdsl.experiments.refusals import ExperimentError

Places = dict[int, int]  # of each seed that a pool was trained with, left out or not


def pair_pools(pools: Sequence[Pool]) -> tuple[Pool, ...]:
    """Returns pools whose players at one place play together; a seed that has nobody to play with is left out, with a note.

    Seeds of one number play together. Where no number is in all trained pools, as with seeds 0 to 4 and 5 to 9, those of one rank do,
    counted before any is left out.

    Raises:
      ExperimentError: the pools have different numbers of seeds, or too few are left to play.
    """
    trained = [pool for pool in pools if pool.is_trained]
    if len(trained) < 2:
        return tuple(pools)
    places = _places(trained)
    _check_equal(places)
    common = set.intersection(*({own[seed] for seed in pool.seeds} for pool, own in places.items()))
    _check_enough(trained, len(common))
    return tuple(_paired(pool, common, places) if pool.is_trained else pool for pool in pools)


def _places(pools: Sequence[Pool]) -> dict[Pool, Places]:
    """Returns the number of each seed as its place, or its rank where no number is in all pools."""
    seeds = {pool: sorted({*pool.seeds, *pool.diverged}) for pool in pools}
    if set.intersection(*(set(numbers) for numbers in seeds.values())):
        return {pool: {seed: seed for seed in numbers} for pool, numbers in seeds.items()}
    return {pool: {seed: rank for rank, seed in enumerate(numbers)} for pool, numbers in seeds.items()}


def _check_equal(places: dict[Pool, Places]) -> None:
    """Raises ExperimentError for pools of which one was trained with more seeds, unless the surplus has diverged somewhere."""
    diverged = {own[seed] for pool, own in places.items() for seed in pool.diverged}
    numbers = [len(own) for own in places.values()]
    if len(set(numbers)) > 1 and len({len(set(own.values()) - diverged) for own in places.values()}) > 1:
        listed = ", ".join(f"{pool.name} has {number}" for pool, number in zip(places, numbers, strict=True))
        raise ExperimentError(
            f"pools must have equally many seeds, for a seed of one plays with a seed of the other: {listed}; name single seeds, "
            "such as RUN/seed_0, or train as many of each"
        )


def _check_enough(pools: Sequence[Pool], left: int) -> None:
    """Raises ExperimentError where nobody is left, or only one of pools of several: then seeds would no longer be the samples."""
    if left >= min(2, *(len(pool.players) for pool in pools)):
        return
    listed = "; ".join(f"{pool.name} has {', '.join(map(str, pool.seeds))}" for pool in pools)
    raise ExperimentError(
        f"seeds of one number play together, and {'only one is' if left else 'none is'} left in all pools: {listed}; "
        "name single seeds, such as RUN/seed_0, or train more"
    )


def _paired(pool: Pool, common: set[int], places: dict[Pool, Places]) -> Pool:
    """Returns a pool without the seeds that are not in all others, and says of each why."""
    left_out = [seed for seed in pool.seeds if places[pool][seed] not in common]
    if not left_out:
        return pool
    notes = tuple(_reason(pool, seed, places) for seed in left_out)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    players = tuple(player for player in pool.players if player.seed not in left_out)
    return replace(pool, players=players, notes=(*pool.notes, *notes))


def _reason(pool: Pool, seed: int, places: dict[Pool, Places]) -> str:
    """Returns which other pool has nobody for a seed to play with."""
    place = places[pool][seed]
    other = next(other for other, own in places.items() if place not in {own[left] for left in other.seeds})
    partner = next((number for number, of_other in places[other].items() if of_other == place), None)
    if partner is None:
        return f"seed {seed} of {pool.name} is left out: {other.name} has no seed {seed}"
    return f"seed {seed} of {pool.name} is left out, as seed {partner} of {other.name} is, which it would play with"
