"""All laws on as many random programs as one likes, and on every variant of the nine games.

`python -m tests.laws.campaign --examples 500 --seed 0`; `--games`: the nine games in every variant first; `--jit`: batches as well.
"""

import argparse
import gc
import time
from collections import Counter
from collections.abc import Callable, Iterator
from random import Random

import jax

from sjdsl.compiler import ast, ir
from sjdsl.compiler.syntax.parse import parse
from sjdsl.library.factory import load_module
from tests.games.environments import NINE
from tests.laws.corpus import game_of, random_text, source_of
from tests.laws.extremes import first_parting
from tests.laws.obeyed import Tried, obeyed
from tests.laws.symmetry import renamed, turns
from tests.laws.test_batch import parts as parts_of_batch
from tests.laws.test_rule_added import added_to_random_program


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--examples", type=int, default=200)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--games", action="store_true")
    options.add_argument("--steps", type=int, default=8)
    options.add_argument("--jit", action="store_true")
    given = options.parse_args()
    counts: Counter[str] = Counter()
    begun = time.process_time()
    for number, (name, game) in enumerate(programs(given.examples, given.seed, given.games)):
        for law, holds in laws(name, game, given.steps, given.jit):
            try:
                fault = holds(counts)
            except Exception as error:
                fault = f"{type(error).__name__}: {error}"
            counts[law] += 1
            if fault:
                counts["faults"] += 1
                print(f"{name}, {law}: {fault[:1000]}", flush=True)
        if number % 10 == 9:
            jax.clear_caches()
            load_module.cache_clear()
            gc.collect()
            print(
                f"{number + 1} programs, {time.process_time() - begun:.0f} s: {dict(counts)}",
                flush=True,
            )
    print(f"all, {time.process_time() - begun:.0f} s: {dict(counts)}")


def programs(examples: int, seed: int, games: bool) -> Iterator[tuple[str, ir.Game]]:
    """Yields the games and the random programs, each with its name or seed."""
    for name in NINE if games else ():
        yield name, game_of(name)
        for variant in (
            v.name.text for v in parse(source_of(name)).game.sections if isinstance(v, ast.Variant)
        ):
            yield f"{name} {variant}", game_of(name, variant)
    for number in range(seed, seed + examples):
        made = random_text(number)
        if made is not None:
            yield str(number), made[1].game


def laws(
    name: str, game: ir.Game, steps: int, jit: bool
) -> Iterator[tuple[str, Callable[[Counter[str]], str]]]:
    """Yields each law with the function that says where the game breaks it."""
    random = Random(name)
    for look in (renamed(game, random), *turns(game)):
        law = "turning" if look.mirror or look.quarters else "renaming"
        yield (
            law,
            lambda counts, look=look: counted(
                obeyed(game, look, random, steps, compiled=True), counts
            ),
        )
    for probability, law in ((0, "impossible"), (1, "certain")):
        yield law, lambda counts, p=probability, law=law: _branches(game, p, random, law, counts)
    if name.isdigit():
        yield "rule added", lambda _: added_to_random_program(int(name), game) or ""
    if jit:
        yield "batch", lambda _: parts_of_batch(game, random)


def counted(tried: Tried, counts: Counter[str]) -> str:
    counts.update({"steps": tried.steps, "words": tried.drawn, "left out": tried.left_out})
    return tried.fault


def _branches(
    game: ir.Game, probability: int, random: Random, law: str, counts: Counter[str]
) -> str:
    found, tried = first_parting(game, probability, random)
    counts[f"branches {law}"] += tried
    return found


if __name__ == "__main__":
    main()
