"""As many random programs as one likes: what is accepted, what is refused and why, what goes wrong; every new fault is shrunk and kept.

`python -m tests.fuzz.campaign --examples 2000 --seed 0`, or `make fuzz EXAMPLES=2000 SEED=0`.
"""

import argparse
import gc
import signal
import time
from collections import Counter
from contextlib import suppress
from functools import partial
from pathlib import Path
from random import Random

import jax

from sjdsl.library.factory import load_module
from tests.fuzz.coverage import Grammar, rule_parts_used, table
from tests.fuzz.judge import Verdict, judge
from tests.fuzz.kept import RUNS, keep
from tests.fuzz.programs import Program, program


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--examples", type=int, default=200)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--steps", type=int, default=50)
    options.add_argument("--jit", action="store_true", help="run on JAX as well")
    options.add_argument(
        "--coverage", action="store_true", help="end with what of the language was used"
    )
    options.add_argument(
        "--no-trace", action="store_true", help="do not trace with JAX's strict dtypes"
    )
    options.add_argument(
        "--shrink",
        type=int,
        default=300,
        help="tries to make a failing program small; 0: keep it as it is",
    )
    options.add_argument(
        "--into", type=Path, default=RUNS, help="where failing programs are written"
    )
    given = options.parse_args()
    counts: Counter[str] = Counter()
    sorts: dict[str, list[int]] = {}
    parts: Counter[str] = Counter()
    grammar = Grammar()
    begun = time.process_time()
    for stop in (
        signal.SIGINT,
        signal.SIGTERM,
    ):  # also where the shell has it run in the background, without interrupts
        signal.signal(stop, signal.default_int_handler)
    with suppress(KeyboardInterrupt):  # a campaign that is stopped tells what it has seen
        for number in range(given.seed, given.seed + given.examples):
            made = program(Random(number))
            for verdict in judge(made, number, given.steps, given.jit, not given.no_trace):
                count(verdict, counts)
                if verdict.fault:
                    sorts.setdefault(verdict.sort, []).append(number)
                    if len(sorts[verdict.sort]) == 1:
                        report(made, verdict, number, given)
                elif verdict.accepted and verdict.game is not None and given.coverage:
                    parts += rule_parts_used(verdict.game)
            if given.coverage:
                grammar.read(made)
            if number % 10 == 9:
                forget()
                print(
                    f"{number + 1 - given.seed} programs, {time.process_time() - begun:.0f} s: {dict(counts)}",
                    flush=True,
                )
    if given.coverage:
        print(*table(grammar, parts), sep="\n")
    for sort, numbers in sorts.items():
        print(f"{len(numbers)} times {sort}: seeds {numbers[:10]}")


def count(verdict: Verdict, counts: Counter[str]) -> None:
    counts["all"] += 1
    counts["accepted"] += verdict.accepted
    counts["faults"] += bool(verdict.fault)
    counts["steps"] += verdict.steps
    counts.update(verdict.codes)


def report(made: Program, verdict: Verdict, number: int, given: argparse.Namespace) -> None:
    """Prints and writes down the first program with a fault of a sort, made small."""
    print(f"seed {number} {'+'.join(verdict.variants)}: {verdict.fault}", flush=True)
    again = partial(judge, seed=number, steps=given.steps, jit=given.jit, strict=not given.no_trace)
    print(
        keep(made, verdict, f"seed_{number}", again, given.shrink, given.into).read_text("utf-8"),
        flush=True,
    )


def forget() -> None:
    """JAX and the loader keep what they have compiled; programs here are never met again."""
    jax.clear_caches()
    load_module.cache_clear()
    gc.collect()


if __name__ == "__main__":
    main()
