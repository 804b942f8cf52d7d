"""`sjdsl bench`: measures the speed of games, beside a hand-written game in the same process."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from sjdsl.cli.bench_devices import check_devices, divide_cpu
from sjdsl.cli.bench_games import choose_tasks
from sjdsl.cli.bench_options import OBSERVATIONS, Agents, Counts, Words
from sjdsl.cli.bench_output import compile_everything_anew, print_tables
from sjdsl.cli.game_file import variant_option
from sjdsl.cli.stages import stages
from sjdsl.games_folder import main_games

if TYPE_CHECKING:
    from sjdsl.runtime.env import Encoding

RACED = (1, 128, 1024, 4096)  # environments


@click.command("bench")
@click.argument("games", nargs=-1, metavar="[GAME...]")
@click.option("--envs", type=Counts(), help="Numbers of environments at once: 1,128,1024,4096 unless others are asked for.")
@click.option(
    "--observation",
    "observations",
    type=Words(OBSERVATIONS),
    default="tokens",
    show_default=True,
    help="Forms of observations: tokens, onehot, or tokens,onehot.",
)
@click.option("--agents", type=Agents(), default="own", show_default=True, help="Numbers of agents, such as own,20.")
@click.option(
    "--devices",
    type=click.IntRange(min=1),
    metavar="N",
    default=1,
    show_default=True,
    help="Split the environments over N devices: GPUs, or parts of the CPU with a core each.",
)
@click.option("--repeats", type=click.IntRange(min=1), metavar="N", default=5, show_default=True, help="Rounds of timings.")
@click.option(
    "--steps", type=click.IntRange(min=1), metavar="N", help="Steps of one timing; by default about 40,000 environment steps in all."
)
@click.option("--json", "json_file", metavar="FILE", help="Write the figures to a file as well.")
@variant_option
@click.pass_context
def command(
    context: click.Context,
    /,
    games: tuple[str, ...],
    envs: tuple[int, ...] | None,
    observations: "tuple[Encoding, ...]",
    agents: tuple[int | None, ...],
    devices: int,
    repeats: int,
    steps: int | None,
    json_file: str | None,
    variant: str | None,
) -> None:
    """Measures environment steps a second under random actions: the games of games/ itself, or the GAMEs named.

    Beside each game runs the yardstick, a step of Commons Harvest written by hand. The speed of a machine
    varies over time; the ratio to the yardstick, taken round by round, does not.
    """
    divide_cpu(devices)
    compile_everything_anew()
    raced = envs or tuple(number for number in RACED if number % devices == 0)
    check_devices(context, devices, raced)
    tasks, refused = choose_tasks(games or main_games(), variant, observations, agents)
    from sjdsl.bench import measure
    from sjdsl.bench.loop import steps_for
    from sjdsl.bench.stored import write_found
    from sjdsl.bench.tables import memory_note, speed_tables

    with stages("compiling") as tell:
        found = measure(tasks, raced, repeats, lambda number: steps or steps_for(number), tell, devices=devices)
    if json_file:
        write_found(Path(json_file), found)
    print_tables(speed_tables(found), found.machine, [*refused, *memory_note(found)])
