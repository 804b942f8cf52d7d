"""Programs compiled in one process, in any order and beside faulty ones, are those of a fresh process, letter by letter."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path
from random import Random

import pytest

from sjdsl.compiler import compile_source
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from tests.fuzz.judge import written
from tests.fuzz.programs import program
from tests.games.environments import NINE
from tests.laws.corpus import source_of

RANDOM = range(12)
VARIANTS = ("", "meltingpot")
Task = tuple[str, str]


def tasks() -> list[Task]:
    """Returns games with a variant, and random programs by seed, among them some that are refused."""
    return [(name, variant) for name in NINE for variant in VARIANTS] + [
        (str(seed), "") for seed in RANDOM
    ]


def compiled(task: Task) -> str:
    """Returns a hash of the module, or of what is wrong with the program."""
    name, variant = task
    variants = (variant,) if variant else ()
    try:
        if name in NINE:
            text = compile_source(source_of(name), variants)
        else:
            with written(program(Random(int(name)))) as source:
                text = compile_source(source)
    except CompileError as refused:
        text = "\n".join(f"{d.code} {d.span.start} {d.message}" for d in refused.diagnostics)
    return hashlib.sha256(text.encode()).hexdigest()


def fresh(hash_seed: int) -> dict[Task, str]:
    """Returns what a process of its own makes of all tasks, with another order of sets."""
    code = "from tests.laws.test_compile_order import compiled, tasks\nfor t in tasks(): print(*t, compiled(t), sep=',')"
    there = {
        **os.environ,
        "PYTHONHASHSEED": str(hash_seed),
        "PYTHONPATH": os.pathsep.join(sys.path),
    }
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env=there,
        cwd=root,
        check=True,
    )
    return {
        (name, variant): digest
        for name, variant, digest in (line.split(",") for line in done.stdout.splitlines())
    }


@pytest.mark.thorough
def test_any_order() -> None:
    wanted = fresh(1)
    order = [*tasks(), *tasks()]
    Random(0).shuffle(order)
    assert len(wanted) == len(order) // 2
    differing = [task for task in order if compiled(task) != wanted[task]]
    assert not differing
    assert len(set(wanted.values())) > len(wanted) - 8  # some variants of the harvests are one game
