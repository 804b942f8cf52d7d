"""What one step of a game costs on a GPU that is not there: XLA compiles for a described card, and what it made is counted (gpu_cost.py).

`make gpu-model` makes the environment for it: JAX with its plug-in for CUDA, 5.5 GB, no GPU needed. Nothing runs on a GPU, and no figure is a
measurement. Compiling takes seconds to a minute for each row, so rows are kept in gpu_model.json, and a program that is there already is not
compiled again. With --suite CHECKOUT the suite's own environments are compiled as well, from a checkout of its repository:

    build/gpu-model/.venv/bin/python bench/gpu_model.py --suite SocialJax
"""

import argparse
import contextlib
import dataclasses
import hashlib
import json
import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

# ruff: noqa: E402
os.environ |= {"JAX_SKIP_CUDA_CONSTRAINTS_CHECK": "1", "CUDA_VISIBLE_DEVICES": "-1", "JAX_PLATFORMS": "cpu,cuda"}  # read while JAX loads
import jax

jax.config.update("jax_platforms", "cpu")  # the plug-in is known, and nothing is placed on it
import jax.numpy as jnp
import socialjax_original
from gpu_cost import GPUS, Gpu, cost_of
from jax.experimental import topologies
from paper import published  # bench/paper, beside this script

import sjdsl
from sjdsl.bench.loop import game_task
from sjdsl.bench.markdown import markdown_table, write_section
from sjdsl.bench.tables import Table
from sjdsl.library.substrates import substrates
from sjdsl.runtime.env import Environment
from sjdsl.runtime.forms import forced

NINE = published.suite()
TEN = (  # of Melting Pot's substrates: one of each family of rules
    "allelopathic_harvest__open",
    "chemistry__two_metabolic_cycles",
    "collaborative_cooking__cramped",
    "daycare",
    "fruit_market__concentric_rivers",
    "hidden_agenda",
    "paintball__king_of_the_hill",
    "predator_prey__open",
    "running_with_scissors_in_the_matrix__arena",
    "territory__rooms",
)
SUITE = {  # the suite's environments of the same games: module and class, and as many agents as ours have
    "coins": ("coin_game.coin_game:CoinGame", 2),
    "harvest_open": ("common_harvest.harvest_open:Harvest_open", 7),
    "clean_up": ("cleanup.clean_up:Clean_up", 7),
    "coop_mining": ("coop_mining.coop_mining:CoopMining", 6),
    "gift_refinement": ("gift.gift:Gift", 5),
    "mushrooms": ("mushrooms.mushrooms:Mushrooms", 5),
    "pd_arena": ("pd_arena.pd_arena:PD_Arena", 4),
}
PAGE, ROWS = Path(__file__).parents[1] / "docs/performance.md", Path(__file__).with_suffix(".json")
SECTION = "gpu model"


@dataclasses.dataclass(frozen=True)
class Row:
    """One compiled program: a step of `envs` environments. `of`: `ours` or `suite`; bytes and operations are those of one environment.

    program: a digest of what XLA was given. kernels, waits: of one step of all environments. steps_per_s: the estimate, low and high.
    """

    of: str
    name: str
    envs: int
    gpu: str
    agents: int
    program: str
    kernels: int
    waits: int
    bytes: float
    least_bytes: float
    operations: float
    steps_per_s: tuple[float, float]

    @property
    def key(self) -> tuple[str, str, int, str]:
        return self.of, self.name, self.envs, self.gpu


@dataclasses.dataclass(frozen=True)
class Program:
    """Something to be compiled: a function of shapes, whose first argument's memory is used again."""

    of: str
    name: str
    envs: int
    gpu: str
    agents: int
    function: Callable[..., Any]
    shapes: tuple[Any, ...]


def main() -> None:
    """Compiles what is not known yet of the games and cards that the page shows, and writes its section."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", type=Path, help="a checkout of the suite's repository: its environments as well")
    asked = parser.parse_args()
    rows = read_rows()
    for program in programs(asked.suite):
        row = compiled(program, rows)
        rows[row.key] = row
        ROWS.write_text("[\n" + ",\n".join(json.dumps(dataclasses.asdict(rows[key])) for key in sorted(rows)) + "\n]\n", encoding="utf-8")
        rate = f"{row.bytes / 1e3:.1f} kB ({row.bytes / row.least_bytes:.1f} times the least), {millions(row)} M steps/s"
        print(f"{row.of} {row.name}, {row.envs} envs, {row.gpu}: {row.kernels} kernels, {row.waits} waits, {rate}", flush=True)
    write_section(PAGE, SECTION, page(rows))


def target_of(gpu: Gpu) -> Any:
    """Returns where arrays lie on a card that is only described."""
    topology = topologies.get_topology_desc(platform="cuda", target_config=gpu.description, topology="1x1x1")
    return jax.sharding.NamedSharding(topologies.make_mesh(topology, (1,), ("d",)), jax.sharding.PartitionSpec())


def programs(suite: Path | None) -> Iterator[Program]:
    for name in NINE:
        for envs, gpu in ((4096, "h100"), (65_536, "h100"), (4096, "a100")):
            yield step_of(name, sjdsl.make(name), envs, gpu)
    for name in TEN:
        substrate = substrates()[name]
        yield step_of(name, sjdsl.make(substrate.game, substrate.variant or None), 4096, "h100")
    for name in SUITE if suite is not None else ():
        yield suite_step(name, suite, 4096, "a100")


def shaped(tree: Any, envs: int, gpu: str) -> Any:
    target = target_of(GPUS[gpu])
    return jax.tree.map(lambda x: jax.ShapeDtypeStruct((envs, *x.shape), x.dtype, sharding=target), tree)


def step_of(name: str, env: Environment, envs: int, gpu: str) -> Program:
    """Returns `env.step` of many environments, with resets, as `sjdsl bench` plays it."""
    task = game_task(env)
    actions = jax.ShapeDtypeStruct((env.num_agents,), jnp.int32)
    shapes = (jax.eval_shape(task.reset), actions, jax.ShapeDtypeStruct((2,), jnp.uint32))

    def step(state: Any, actions: Any, key: Any) -> Any:
        return jax.vmap(lambda s, a, k: task.step(s, a, jax.random.wrap_key_data(k)))(state, actions, key)

    return Program("ours", name, envs, gpu, env.num_agents, step, shaped(shapes, envs, gpu))


def suite_step(name: str, checkout: Path, envs: int, gpu: str) -> Program:
    """Returns a step of the suite's own environment, with its resets."""
    where, agents = SUITE[name]
    with newer_jax():
        env = socialjax_original.load(checkout, where)(num_agents=agents, shared_rewards=False)
    key = jax.ShapeDtypeStruct((2,), jnp.uint32)
    state = jax.eval_shape(lambda k: jax.tree.map(jnp.asarray, env.reset(k)[1]), key)
    one = socialjax_original.stepping(env)

    def step(state: Any, actions: Any, key: Any) -> Any:
        with newer_jax():
            return jax.vmap(lambda s, a, k: one(k, s, a))(state, actions, key)

    shapes = (state, jax.ShapeDtypeStruct((agents,), jnp.int32), key)
    return Program("suite", name, envs, gpu, agents, step, shaped(shapes, envs, gpu))


@contextlib.contextmanager
def newer_jax() -> Iterator[None]:
    """Lets code that was written for JAX 0.4 call `jnp.clip` as it did."""
    clip = jnp.clip

    def older(x: Any, a_min: Any = None, a_max: Any = None, **bounds: Any) -> Any:
        return clip(x, bounds.get("min", a_min), bounds.get("max", a_max))

    jnp.clip = older  # type: ignore[assignment]
    try:
        yield
    finally:
        jnp.clip = clip


def compiled(program: Program, rows: Mapping[Any, Row]) -> Row:
    """Returns the row of a program: the one that is known, if XLA would be given the same."""
    with forced("gpu"):
        lowered = jax.jit(program.function, donate_argnums=0).lower(*program.shapes)
    digest = hashlib.sha256(f"{jax.__version__} {lowered.as_text()}".encode()).hexdigest()[:16]
    known = rows.get((program.of, program.name, program.envs, program.gpu))
    if known is not None and known.program == digest:
        return known
    cost, envs = cost_of(lowered.compile().as_text()), program.envs
    moved = [*jax.tree.leaves(program.shapes), *jax.tree.leaves(jax.eval_shape(program.function, *program.shapes))]
    least = sum(
        math.prod(leaf.shape) * jnp.dtype(leaf.dtype).itemsize for leaf in moved if not jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)
    )
    low, high = (envs / seconds for seconds in reversed(cost.seconds(GPUS[program.gpu])))
    figures = (cost.launches, cost.waits, cost.bytes / envs, least / envs, cost.operations / envs, (low, high))
    return Row(program.of, program.name, envs, program.gpu, program.agents, digest, *figures)


def read_rows() -> dict[Any, Row]:
    stored = [Row(**{**row, "steps_per_s": tuple(row["steps_per_s"])}) for row in json.loads(ROWS.read_text("utf-8"))]
    return {row.key: row for row in stored}


def millions(row: Row) -> str:
    low, high = (rate / 1e6 for rate in row.steps_per_s)
    return f"{low:.2g} to {high:.2g}" if high < 10 else f"{low:.0f} to {high:.0f}"


def page(rows: Mapping[Any, Row]) -> str:
    """Returns the tables of the page, from all rows."""
    tables = [step_table("one step of a game", NINE, rows), step_table("one step of a substrate", TEN, rows), checked_table(rows)]
    parts = [f"{table.title[0].upper()}{table.title[1:]}:\n\n{markdown_table(table)}" for table in tables]
    return f"`make gpu-model`, JAX {jax.__version__}. Nothing here was measured.\n\n" + "\n\n".join(parts) + "\n"


def step_table(title: str, names: Sequence[str], rows: Mapping[Any, Row]) -> Table:
    """Returns a table with a row a game; figures for several numbers of environments stand side by side."""
    figures: list[tuple[str, Callable[[Row], str]]] = [
        ("kernels", lambda row: str(row.kernels)),
        ("waits", lambda row: str(row.waits)),
        ("kB an env", lambda row: f"{row.bytes / 1e3:.1f}"),
        ("times the least", lambda row: f"{row.bytes / row.least_bytes:.1f}"),
        ("1,000 operations an env", lambda row: f"{row.operations / 1e3:.0f}"),
        ("million steps/s, estimated", millions),
    ]
    batches = sorted({row.envs for row in rows.values() if row.name in names and row.gpu == "h100"})
    lines = []
    for name in names:
        own = [rows["ours", name, envs, "h100"] for envs in batches]
        lines.append((name, str(own[0].agents), *(" / ".join(map(said, own)) for _, said in figures)))
    envs = " / ".join(f"{envs:,}" for envs in batches)
    return Table(f"{title}, tokens, H100, {envs} environments", ("game", "agents", *(heading for heading, _ in figures)), tuple(lines))


def checked_table(rows: Mapping[Any, Row]) -> Table:
    """Returns the estimates for an A100 beside what the paper measured on one."""
    lines = []
    for name in SUITE:
        ours, suite = rows["ours", name, 4096, "a100"], rows["suite", name, 4096, "a100"]
        measured = published.speed(name, crowd=False)[4096]
        low, high = (rate / measured for rate in suite.steps_per_s)
        ratio = math.sqrt(math.prod(ours.steps_per_s) / math.prod(suite.steps_per_s))
        row = (
            name,
            f"{ours.kernels} / {suite.kernels}",
            f"{ours.bytes / 1e3:.1f} / {suite.bytes / 1e3:.1f}",
            millions(ours),
            millions(suite),
        )
        lines.append((*row, f"{measured / 1e6:.2g}", f"{low:.1f} to {high:.1f}", f"{ratio:.1f}"))
    headings = ("game", "kernels, ours / the suite's", "kB an env", "ours, estimated", "the suite's, estimated", "measured, paper")
    headings += ("estimated to measured", "ours to the suite's")
    return Table("an A100 at 4,096 environments, million steps a second, beside what the suite's paper measured", headings, tuple(lines))


if __name__ == "__main__":
    main()
