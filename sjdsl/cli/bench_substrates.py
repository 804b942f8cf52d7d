"""`sjdsl bench --substrates` measures Melting Pot's substrates; the page and the file are written after each of them."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import click

from sjdsl.cli.bench_everything import Stored
from sjdsl.cli.stages import stages
from sjdsl.near_names import meant
from sjdsl.substrates import Substrate, written_substrates

if TYPE_CHECKING:
    from sjdsl.bench.stored import Found
    from sjdsl.cli.bench_output import Outputs

RACED = (1, 128, 1024)  # environments


def chosen(names: Sequence[str]) -> list[Substrate]:
    """Returns the substrates of these names, or all. Raises UsageError for a name that Melting Pot does not have."""
    known = {entry.name: entry for entry in written_substrates()}
    for name in names:
        if name not in known:
            raise click.UsageError(f"Melting Pot has no substrate `{name}`{meant(name, list(known))}")
    return [known[name] for name in names or known]


def measure_all(
    names: Sequence[str],
    envs: Sequence[int] | None,
    repeats: int,
    steps: int | None,
    outputs: "Outputs",
    keep: "Callable[[Found], None]",
    command: str,
) -> None:
    """Measures the substrates and shows the table. Raises UsageError and ClickException before anything is measured."""
    import jax

    from sjdsl.bench.substrates import Substrates, measure_substrates, short_steps, substrate_tasks

    entries, section = chosen(names), f"substrates {jax.default_backend()}"
    outputs.check(section)

    def store(found: Substrates) -> None:
        keep(found)
        left = len(entries) - len(found.compilations)
        notes = (f"the run was stopped before the last {left} of {len(entries)} substrates",) if left else ()
        outputs.write(Stored(section, found, command, notes))

    with stages("compiling") as tell:
        taken = measure_substrates(
            substrate_tasks(entries), envs or RACED, repeats, store, lambda number: steps or short_steps(number), tell
        )
    outputs.show(Stored(section, taken, command, ()))
