"""Hunts counterexamples of checks that are proved: random games, each proof against thousands of worlds of the compiled game.

`python -m tests.properties.hunt --verdicts 10000 --seed 0`

It shares no rule with the proofs. `always`, `once` and `monotone` are computed as compiled, under JAX, in random worlds with parameters
and fields at the ends of their ranges, and in other sizes of the game. `conserved` is looked at along play, and `symmetric` by a step
beside the same step of agents with other numbers, under the very same rules (modules played on NumPy), also with other numbers of agents.
For each random game there are some of numbers that float32 rounds; there `always` is computed again after a step from random worlds, as a
range of a field is a proof of the rules that write it.
"""

import argparse
import gc
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from random import Random
from types import SimpleNamespace
from typing import Any

import jax
import numpy as np

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.lower import NotSupported
from sjdsl.library.factory import load_module
from sjdsl.properties import GameFamily
from sjdsl.properties.compiled_values import lower_checks
from sjdsl.properties.verify_properties import decide_statically
from tests.fuzz import numpy_jax
from tests.fuzz.judge import written
from tests.fuzz.programs import Program, program
from tests.fuzz.together import OnNumPy, on_numpy, random_play
from tests.properties.random_checks import REMOVABLE, many_checks, without
from tests.properties.random_numbers import numbers_game
from tests.properties.random_worlds import ALIKE, Worlds, encoded, random_params, random_worlds
from tests.properties.unchanged_rules import asymmetry

CHECKS, EVEN = 200, 2  # in a game; games with no checks but symmetries, as few games are symmetric
NUMBERS, FIELDS = (
    4,
    8,
)  # games of numbers that float32 rounds, and fields with a guard of their own in each
SIZES, TRIES = 1, 2  # other sizes of a game that are looked at; tries to find some
STATES = ("always", "once", "monotone")
PLAYS, STEPS = 2, 6  # in which `conserved` is looked at
STEPPED = 256  # worlds from which a step is taken


@dataclass
class Hunted:
    """How many proofs were hunted, by sort, and the counterexamples found: the check, where, and the text of the game."""

    proofs: Counter[str] = field(default_factory=Counter)
    worlds: int = 0
    found: list[tuple[str, str, str]] = field(default_factory=list)


def random_family(seed: int, checks: int = CHECKS) -> GameFamily | None:
    """Returns a random game with many checks; None if its rules are refused. Checks that are refused are left out."""
    made = program(Random(seed), many_checks(checks))
    for _ in range(20):
        with written(made) as source:
            try:
                return GameFamily(source)
            except CompileError as error:
                lines = {
                    d.span.line
                    for d in error.diagnostics
                    if d.severity == "error" and d.span.file == source.name
                }
        text = without(made.text, lines) if lines else ""
        if not text:
            return None
        made = Program(text, made.files, made.variants)
    return None


def numbers_family(seed: int) -> GameFamily | None:
    """Returns a random game of numbers that float32 rounds, without what is refused; None if it is all refused."""
    text = numbers_game(Random(seed), FIELDS)
    for _ in range(20):
        try:
            return GameFamily(Source("numbers.sj", text, None))
        except CompileError as error:
            lines = {d.span.line for d in error.diagnostics if d.severity == "error"}
            text = without(text, lines, (*REMOVABLE, "when"))
    return None


def proved(family: GameFamily) -> list[int]:
    """Returns the numbers of the checks that are proved."""
    verdicts = [decide_statically(family, number) for number in range(len(family.own.checks))]
    return [
        number
        for number, verdict in enumerate(verdicts)
        if verdict is not None and verdict.how == "proved"
    ]


def hunt(family: GameFamily, seed: int, worlds: int, hunted: Hunted, stepped: int = 0) -> None:
    """Looks for counterexamples of all that is proved of a game. `stepped`: the worlds from which a step is taken."""
    random, numbers = Random(seed), proved(family)
    by_sort = {
        sort: [n for n in numbers if family.own.checks[n].kind == sort]
        for sort in (*STATES, "conserved", "symmetric")
    }
    of_states = [n for sort in STATES for n in by_sort[sort]]
    try:
        games = (family.own, *_other_sizes(family, random))
        for game in games:
            _hunt_states(game, of_states, random, worlds, hunted, family, stepped)
        _hunt_conserved(family.own, by_sort["conserved"], random, hunted, family)
        compared = {
            number: [asymmetry(game, game.checks[number], random) for game in games]
            for number in by_sort["symmetric"]
        }
    except NotSupported:
        return
    counted = [*of_states, *by_sort["conserved"]]
    for number, results in compared.items():
        steps = sum(taken for taken, _ in results)
        counted += [number] if steps else []
        hunted.worlds += steps
        _note(next((where for _, where in results if where), ""), number, family, hunted)
    hunted.proofs.update(family.own.checks[number].kind for number in counted)


def _note(where: str, number: int, family: GameFamily, hunted: Hunted) -> None:
    if where:
        texts = "\n".join(source.text for source in family.composition.sources.values())
        hunted.found.append((family.text_of(family.own.checks[number]), where, texts))


def _other_sizes(family: GameFamily, random: Random) -> list[ir.Game]:
    """Returns the game in a few other sizes that the file allows: all at one end of their limits, or each anywhere."""
    declared = {
        name: constant
        for name, constant in family.composition.constants.items()
        if constant.is_size
    }
    found: list[ir.Game] = []
    for where in ("high", "low", *("anywhere" for _ in range(TRIES))) if declared else ():
        sizes = {name: _size(constant, where, random) for name, constant in declared.items()}
        game = family.in_sizes({name: value for name, value in sizes.items() if value is not None})
        if game is not None and game.sizes not in (
            family.own.sizes,
            *(other.sizes for other in found),
        ):
            found.append(game)
    return random.sample(found, min(SIZES, len(found)))


def _size(size: ast.Constant, where: str, random: Random) -> int | None:
    match size.low, size.high:
        case ast.Int(value=low), ast.Int(value=high):
            pass
        case None, None:
            low, high = 0, 9
        case _:
            return None
    return {"low": low, "high": high}.get(where, random.randint(low, high))


def _hunt_states(
    game: ir.Game,
    numbers: Sequence[int],
    random: Random,
    many: int,
    hunted: Hunted,
    family: GameFamily,
    stepped: int,
) -> None:
    if not numbers:
        return
    values = [
        game.checks[n].values if game.checks[n].kind == "monotone" else game.checks[n].values[-1:]
        for n in numbers
    ]
    lowered = lower_checks(game, [e for some in values for e in some])
    env = on_numpy(game)
    worlds = random_worlds(env, game, random, many)
    table = _computed(lowered.values, worlds.state, worlds.params)
    hunted.worlds += many
    after = _after_a_step(env, worlds, random, stepped)
    table_after = _computed(lowered.values, after.state, after.params) if stepped else table[:0]
    hunted.worlds += stepped
    at = 0
    for number, some in zip(numbers, values, strict=True):
        columns, columns_after, at = (
            table[:, at : at + len(some)],
            table_after[:, at : at + len(some)],
            at + len(some),
        )
        check = game.checks[number]
        wrong = (
            _turns(columns, check.words[0] == "rising")
            if check.kind == "monotone"
            else np.flatnonzero(columns[:, 0] == 0)
        )
        if check.kind != "monotone" and not columns_after.all():
            at_step = int(np.flatnonzero(columns_after[:, 0] == 0)[0])
            state = {name: value[at_step].tolist() for name, value in after.state.items()}
            _note(
                f"sizes {[s.value for s in game.sizes]}, after a step: {state}",
                number,
                family,
                hunted,
            )
            continue
        if len(wrong):
            world = {
                name: value[wrong[0]].tolist()
                for name, value in (*worlds.params.items(), *worlds.state.items())
            }
            _note(
                f"sizes {[s.value for s in game.sizes]}, {columns[wrong[0]].tolist()}: {world}",
                number,
                family,
                hunted,
            )


def _after_a_step(env: OnNumPy, worlds: Worlds, random: Random, many: int) -> Worlds:
    """Returns so many of the worlds after a step with random actions, on NumPy."""
    states, first = [], env.module.initial_state()
    for world in range(many):
        params = {name: numpy_jax.as_array(value[world]) for name, value in worlds.params.items()}
        state = first.replace(
            **{name: numpy_jax.as_array(value[world]) for name, value in worlds.state.items()}
        )
        env.params = replace(env.params, **params)
        play = random_play(env.game, random.getrandbits(32), 1)
        with np.errstate(all="ignore"):
            states.append(env.advance(play.keys[0], state, play.actions[0])[0])
    after = (
        {
            name: np.stack([np.asarray(getattr(state, name)) for state in states])
            for name in worlds.state
        }
        if states
        else {}
    )
    return Worlds(after, {name: value[:many] for name, value in worlds.params.items()})


def _computed(
    values: Any, state: dict[str, np.ndarray], params: dict[str, np.ndarray]
) -> np.ndarray:
    """Returns what expressions are in each world, `[worlds, expressions]` float32; before its step each is the world that precedes it."""
    before = {name: np.roll(value, 1, axis=0) for name, value in state.items()}
    one = jax.vmap(
        lambda state, params, before: values(
            SimpleNamespace(**state), SimpleNamespace(**params), SimpleNamespace(**before)
        )
    )
    return np.asarray(jax.jit(one)(state, params, before))


def _turns(columns: np.ndarray, rising: bool) -> np.ndarray:
    """Returns worlds whose first value goes the wrong way from another with the same parameters and a smaller second value."""
    value, argument = (
        columns[: len(columns) // ALIKE * ALIKE, i].reshape(-1, ALIKE) for i in (0, 1)
    )
    less = value[:, :, None] < value[:, None] if rising else value[:, :, None] > value[:, None]
    return np.flatnonzero((less & (argument[:, :, None] > argument[:, None])).any(-1).reshape(-1))


def _hunt_conserved(
    game: ir.Game, numbers: Sequence[int], random: Random, hunted: Hunted, family: GameFamily
) -> None:
    if not numbers:
        return
    lowered = lower_checks(game, [game.checks[n].values[0] for n in numbers])
    env = on_numpy(game)
    params = [encoded(game, random_params(game, random)) for _ in range(PLAYS)]
    trajectories = [_played(env, given, random) for given in params]
    states = {
        name: np.stack([np.asarray(getattr(s, name)) for t in trajectories for s in t])
        for name in vars(trajectories[0][0])
    }
    given = {
        name: np.stack([one[name] for one, t in zip(params, trajectories, strict=True) for _ in t])
        for name in params[0]
    }
    table = _computed(lowered.values, states, given)
    hunted.worlds += len(table)
    begun = np.cumsum([0, *map(len, trajectories)])
    for column, number in enumerate(numbers):
        for first, last in pairwise(begun):
            changed = np.flatnonzero(table[first:last, column] != table[first, column])
            if len(changed):
                _note(
                    f"{table[first, column]}, after step {changed[0] - 1} {table[first + changed[0], column]}",
                    number,
                    family,
                    hunted,
                )
                break


def _played(env: OnNumPy, params: dict[str, np.ndarray], random: Random) -> list[Any]:
    """Returns the states of an episode of random play, on NumPy."""
    env.params = replace(
        env.params, **{name: numpy_jax.as_array(value) for name, value in params.items()}
    )
    play = random_play(env.game, random.getrandbits(32), STEPS)
    with np.errstate(all="ignore"):  # what a guard protects is computed and not used
        states = [env.begin(play.start)]
        for words, actions in zip(play.keys, play.actions, strict=True):
            state, _, done, _ = env.advance(words, states[-1], actions)
            if done:
                break
            states.append(state)
    return states


def hunt_seeds(seeds: Iterator[int], verdicts: int, worlds: int) -> Hunted:
    """Returns what came of so many proofs in random games."""
    hunted = Hunted()
    for seed in seeds:
        if sum(hunted.proofs.values()) >= verdicts:
            break
        for family in (
            random_family(seed),
            *(random_family(seed + i * 2**32, 0) for i in range(1, 1 + EVEN)),
        ):
            if family is not None:
                hunt(family, seed, worlds, hunted)
        for family in (numbers_family(seed + i * 2**32) for i in range(NUMBERS)):
            if family is not None:
                hunt(family, seed, worlds, hunted, STEPPED)
        jax.clear_caches()
        load_module.cache_clear()
        gc.collect()
    return hunted


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--verdicts", type=int, default=10_000)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--worlds", type=int, default=2048)
    given = options.parse_args()
    begun, hunted, seed = time.process_time(), Hunted(), given.seed
    while sum(hunted.proofs.values()) < given.verdicts:
        one = hunt_seeds(iter([seed]), 1, given.worlds)
        hunted.proofs += one.proofs
        hunted.worlds += one.worlds
        for check, where, text in one.found:
            print(f"seed {seed}: {check}\n  {where[:2000]}", flush=True)
            hunted.found.append((check, where, text))
        seed += 1
        if seed % 10 == 0:
            print(
                f"{seed - given.seed} games, {sum(hunted.proofs.values())} proofs, {time.process_time() - begun:.0f} s",
                flush=True,
            )
    print(
        f"{seed - given.seed} games, {hunted.worlds} worlds, {dict(hunted.proofs)}: {len(hunted.found)} counterexamples"
    )


if __name__ == "__main__":
    main()
