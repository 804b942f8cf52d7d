"""What one step of a game costs on a GPU that is not there: XLA compiles for a described card, and what it made is counted (gpu_cost.py).

`make gpu-model` makes the environment for it: JAX with its plug-in for CUDA, 5.5 GB, no GPU needed. Nothing runs on a GPU, and no figure is a
measurement. Compiling takes seconds to a minute for each row, so rows are kept in a JSON file, and a program that is there already is not
compiled again. With --suite CHECKOUT the suite's own environments are compiled as well, from a checkout of its repository:

    build/gpu-model/.venv/bin/python bench/gpu_model.py coins harvest_open --envs 1024,4096 --suite SocialJax --json runs/gpu_model.json
"""

import argparse
import contextlib
import dataclasses
import hashlib
import json
import math
import os
import re
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

# ruff: noqa: E402
os.environ |= {
    "JAX_SKIP_CUDA_CONSTRAINTS_CHECK": "1",
    "CUDA_VISIBLE_DEVICES": "-1",
    "JAX_PLATFORMS": "cpu,cuda",
}  # read while JAX loads
import jax

jax.config.update("jax_platforms", "cpu")  # the plug-in is known, and nothing is placed on it
import jax.numpy as jnp
import socialjax_original
from gpu_cost import GPUS, Gpu, Kernel, cost_of
from jax.experimental import topologies
from paper import published  # bench/paper, beside this script

import sjdsl
from sjdsl.bench.loop import game_task
from sjdsl.bench.markdown import markdown_table, write_section
from sjdsl.bench.tables import Table
from sjdsl.library.substrates import substrates
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
TWENTY = (
    *(f"{game}+crowd" for game in NINE if game not in ("coins", "pd_arena")),
    "pd_arena*20",
)  # coins is for two
GROUPS = {"nine": NINE, "ten": TEN, "twenty": TWENTY}
SECTION = "gpu model"


@dataclasses.dataclass(frozen=True)
class Row:
    """One compiled program. `of`: `ours`, `suite`, or `update` of a trainer; bytes and operations are those of one environment step.

    program: a digest of what XLA was given. kernels, waits: of one step of all environments (of an update: of all of it). steps_per_s:
    the estimate, low and high. memory: bytes that the program needs on the card. compile_seconds: of processor time.
    """

    of: str
    name: str
    observation: str
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
    memory: int
    compile_seconds: float
    made_of: dict[str, int]

    @property
    def key(self) -> tuple[str, str, str, int, str]:
        return self.of, self.name, self.observation, self.envs, self.gpu


@dataclasses.dataclass(frozen=True)
class Program:
    """Something to be compiled: a function of shapes, whose first argument's memory is used again. `env_steps`: that one call plays."""

    of: str
    name: str
    observation: str
    envs: int
    agents: int
    function: Callable[..., Any]
    shapes: tuple[Any, ...]
    env_steps: int


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "games",
        nargs="*",
        help="games, GAME+VARIANT, GAME*AGENTS, substrates, `nine`, `ten`, `twenty`; none: only tables",
    )
    parser.add_argument("--gpu", choices=GPUS, default="h100")
    parser.add_argument(
        "--envs", type=numbers, default=(4096,), help="environments side by side, such as 1024,4096"
    )
    parser.add_argument(
        "--observation", default="tokens", help="tokens, onehot, or both with a comma"
    )
    parser.add_argument(
        "--suite",
        type=Path,
        help="a checkout of the suite's repository: its environments of these games as well",
    )
    parser.add_argument("--only-suite", action="store_true", help="leave out ours")
    parser.add_argument(
        "--update",
        default="",
        help="networks (mlp, cnn) of one update of IPPO with the preset `paper`, instead of steps",
    )
    parser.add_argument("--json", type=Path, required=True, help="where rows are kept")
    parser.add_argument("--hlo", type=Path, help="a folder for the compiled programs")
    parser.add_argument(
        "--kernels",
        action="store_true",
        help="list the kernels of each program, and the functions that they come from",
    )
    parser.add_argument(
        "--markdown", type=Path, help="a page whose section is written anew from all rows"
    )
    asked = parser.parse_args()
    rows = read_rows(asked.json)
    target = target_of(GPUS[asked.gpu])
    for program in programs(asked, target):
        row = compiled(program, asked.gpu, rows, asked.hlo, asked.kernels)
        rows = read_rows(asked.json) | {row.key: row}  # another process may have added some
        write_rows(asked.json, rows)
        print(line_of(row), flush=True)
    if asked.markdown:
        write_section(asked.markdown, SECTION, page(rows))


def numbers(text: str) -> tuple[int, ...]:
    return tuple(map(int, text.split(",")))


def target_of(gpu: Gpu) -> Any:
    """Returns where arrays lie on a card that is only described."""
    topology = topologies.get_topology_desc(
        platform="cuda", target_config=gpu.description, topology="1x1x1"
    )
    return jax.sharding.NamedSharding(
        topologies.make_mesh(topology, (1,), ("d",)), jax.sharding.PartitionSpec()
    )


def programs(asked: argparse.Namespace, target: Any) -> Iterator[Program]:
    for name in (name for word in asked.games for name in GROUPS.get(word, (word,))):
        for envs in asked.envs:
            if asked.update:
                yield from (update_of(name, network, target) for network in asked.update.split(","))
                break
            if not asked.only_suite:
                yield from (
                    step_of(name, observation, envs, target)
                    for observation in asked.observation.split(",")
                )
            if asked.suite is not None and name in SUITE:
                yield suite_step(name, asked.suite, envs, target)


def shaped(tree: Any, target: Any, batch: tuple[int, ...] = ()) -> Any:
    return jax.tree.map(
        lambda x: jax.ShapeDtypeStruct((*batch, *x.shape), x.dtype, sharding=target), tree
    )


def make(name: str, observation: str) -> Any:
    """Returns the environment of a game, of a variant, of a game with more agents, or of a substrate."""
    if name in TEN or ("__" in name and name in substrates()):
        substrate = substrates()[name]
        return sjdsl.make(substrate.game, substrate.variant or None, observation=observation)
    game, _, agents = name.partition("*")
    game, _, variant = game.partition("+")
    return sjdsl.make(
        game, variant or None, num_agents=int(agents) if agents else None, observation=observation
    )


def step_of(name: str, observation: str, envs: int, target: Any) -> Program:
    """Returns `env.step` of many environments, with resets, as `sjdsl bench` plays it."""
    env = make(name, observation)
    task = game_task(env)
    actions = jax.ShapeDtypeStruct((env.num_agents,), jnp.int32)
    shapes = (jax.eval_shape(task.reset), actions, jax.ShapeDtypeStruct((2,), jnp.uint32))

    def step(state: Any, actions: Any, key: Any) -> Any:
        return jax.vmap(lambda s, a, k: task.step(s, a, jax.random.wrap_key_data(k)))(
            state, actions, key
        )

    return Program(
        "ours", name, observation, envs, env.num_agents, step, shaped(shapes, target, (envs,)), envs
    )


def suite_step(name: str, checkout: Path, envs: int, target: Any) -> Program:
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
    return Program(
        "suite", name, "its own", envs, agents, step, shaped(shapes, target, (envs,)), envs
    )


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


def update_of(name: str, network: str, target: Any) -> Program:
    """Returns one update of IPPO, a rollout and what is learnt from it, as the preset `paper` has it."""
    from sjdsl.trainers import make_train
    from sjdsl.trainers.settings.preset import load_preset

    env = make(name, "tokens")
    config = load_preset("paper", {"algorithm": "ippo", "network": network}, name).config
    train = make_train(env, config)
    state = jax.eval_shape(lambda: train.init(jax.random.key(0)))
    return Program(
        "update",
        name,
        network,
        config.num_envs,
        env.num_agents,
        train.update,
        shaped((state,), target),
        config.steps_per_update,
    )


def compiled(
    program: Program, gpu: str, rows: dict[Any, Row], hlo: Path | None, kernels: bool
) -> Row:
    """Returns the row of a program: the one that is known, if XLA would be given the same and its kernels aren't to be listed."""
    with forced("gpu"):
        lowered = jax.jit(program.function, donate_argnums=0).lower(*program.shapes)
    digest = hashlib.sha256(f"{jax.__version__} {lowered.as_text()}".encode()).hexdigest()[:16]
    known = rows.get((program.of, program.name, program.observation, program.envs, gpu))
    if known is not None and known.program == digest and not kernels and hlo is None:
        return known
    began = processor_time()
    made = lowered.compile()
    seconds = processor_time() - began
    text = made.as_text()
    if hlo is not None:
        hlo.mkdir(parents=True, exist_ok=True)
        (
            hlo
            / f"{program.of}_{program.name}_{program.observation}_{program.envs}_{gpu}.hlo".replace(
                " ", "_"
            )
        ).write_text(text)
    cost = cost_of(text)
    if kernels:
        print("\n".join(map(line_of_kernel, cost.kernels)))
    moved = [
        *jax.tree.leaves(program.shapes),
        *jax.tree.leaves(jax.eval_shape(program.function, *program.shapes)),
    ]
    least = sum(
        math.prod(leaf.shape) * jnp.dtype(leaf.dtype).itemsize
        for leaf in moved
        if not jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)
    )
    said = made.memory_analysis()
    memory = (
        0
        if said is None
        else said.argument_size_in_bytes
        + said.temp_size_in_bytes
        + said.output_size_in_bytes
        - said.alias_size_in_bytes
    )
    each = program.env_steps
    low, high = (each / seconds for seconds in reversed(cost.seconds(GPUS[gpu])))
    counted = Counter(kernel.op for kernel in cost.kernels)
    return Row(
        *(program.of, program.name, program.observation, program.envs, gpu, program.agents, digest),
        *(
            cost.launches,
            cost.waits,
            cost.bytes / each,
            least / each,
            cost.operations / each,
            (low, high),
        ),
        *(int(memory), seconds, dict(counted.most_common())),
    )


def processor_time() -> float:
    """Returns the seconds that processors have spent on this process and on those that XLA has started, which it compiles with."""
    return sum(os.times()[:4])


def read_rows(path: Path) -> dict[Any, Row]:
    if not path.exists():
        return {}
    stored = [
        Row(**{**row, "steps_per_s": tuple(row["steps_per_s"])})
        for row in json.loads(path.read_text("utf-8"))
    ]
    return {row.key: row for row in stored}


def write_rows(path: Path, rows: dict[Any, Row]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    ordered = [dataclasses.asdict(rows[key]) for key in sorted(rows)]
    path.write_text(
        "[\n" + ",\n".join(json.dumps(row) for row in ordered) + "\n]\n", encoding="utf-8"
    )


def line_of_kernel(kernel: Kernel) -> str:
    times = f"{kernel.times} times " if kernel.times > 1 else ""
    size = f"{kernel.bytes / 1e6:.2f} MB, {kernel.operations / 1e6:.1f} M operations"
    return f"{times}{kernel.name}: {re.sub(r'{.*?}', '', kernel.shape)}, {size}; {', '.join(kernel.made_by)}"


def line_of(row: Row) -> str:
    return (
        f"{row.of} {row.name} {row.observation}, {row.envs} envs, {row.gpu}: {row.kernels} kernels, {row.waits} wait, {row.bytes / 1e3:.1f} kB "
        f"({row.bytes / row.least_bytes:.1f} times the least), {row.operations / 1e3:.0f}k operations, {millions(row)} M steps/s, "
        f"{row.memory / 1e9:.2f} GB, compiled in {row.compile_seconds:.0f} s of processor time"
    )


def millions(row: Row) -> str:
    low, high = (rate / 1e6 for rate in row.steps_per_s)
    return f"{low:.2g} to {high:.2g}" if high < 10 else f"{low:.0f} to {high:.0f}"


def page(rows: dict[Any, Row]) -> str:
    """Returns the tables of the page, from all rows."""
    found = list(rows.values())
    steps = [
        ("ours", "tokens", "tokens"),
        ("ours", "onehot", "one-hot observations"),
        ("suite", "its own", "the suite's own environments"),
    ]
    tables = [
        step_table(f"one step of a game, {title}", names, of, observation, found)
        for of, observation, title in steps
        for names in [NINE]
    ]
    tables += [
        step_table("one step of a game with 20 agents, tokens", TWENTY, "ours", "tokens", found)
    ]
    tables += [
        step_table(f"one step of a substrate, {title}", TEN, of, observation, found)
        for of, observation, title in steps[:2]
    ]
    tables += [checked_table(found), update_table(found)]
    parts = [
        f"{table.title[0].upper()}{table.title[1:]}:\n\n{markdown_table(table)}"
        for table in tables
        if table.rows
    ]
    return (
        f"`make gpu-model`, JAX {jax.__version__}. Nothing here was measured.\n\n"
        + "\n\n".join(parts)
        + "\n"
    )


def step_table(
    title: str, names: tuple[str, ...], of: str, observation: str, rows: list[Row]
) -> Table:
    """Returns a table with a row a game; figures for several numbers of environments stand side by side."""
    mine = [
        row
        for row in rows
        if (row.of, row.observation, row.gpu) == (of, observation, "h100") and row.name in names
    ]
    batches = sorted({row.envs for row in mine})
    figures: list[tuple[str, Callable[[Row], str]]] = [
        ("kernels", lambda row: str(row.kernels)),
        ("waits", lambda row: str(row.waits)),
        ("kB an env", lambda row: f"{row.bytes / 1e3:.1f}"),
        ("times the least", lambda row: f"{row.bytes / row.least_bytes:.1f}"),
        ("1,000 operations an env", lambda row: f"{row.operations / 1e3:.0f}"),
        ("million steps/s, estimated", millions),
        ("seconds to compile", lambda row: f"{row.compile_seconds:.0f}"),
    ]
    by_key = {(row.name, row.envs): row for row in mine}
    lines = []
    for name in names:
        own = [by_key.get((name, envs)) for envs in batches]
        if any(own):
            agents = next(str(row.agents) for row in own if row is not None)
            lines.append(
                (
                    name,
                    agents,
                    *(
                        " / ".join("" if row is None else said(row) for row in own)
                        for _, said in figures
                    ),
                )
            )
    envs = " / ".join(f"{envs:,}" for envs in batches)
    return Table(
        f"{title}, H100, {envs} environments",
        ("game", "agents", *(heading for heading, _ in figures)),
        tuple(lines),
    )


def checked_table(rows: list[Row]) -> Table:
    """Returns the estimates for an A100 beside what the paper measured on one."""
    by_key = {row.key: row for row in rows}
    lines = []
    for name in SUITE:
        ours, suite = (
            by_key.get((of, name, seen, 4096, "a100"))
            for of, seen in (("ours", "tokens"), ("suite", "its own"))
        )
        if ours is None or suite is None:
            continue
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
    headings = (
        "game",
        "kernels, ours / the suite's",
        "kB an env",
        "ours, estimated",
        "the suite's, estimated",
        "measured, paper",
    )
    headings += ("estimated to measured", "ours to the suite's")
    return Table(
        "an A100 at 4,096 environments, million steps a second, beside what the suite's paper measured",
        headings,
        tuple(lines),
    )


def update_table(rows: list[Row]) -> Table:
    """Returns what updates of a trainer cost."""
    lines = [
        (
            *(
                row.name,
                row.observation,
                row.gpu.upper(),
                f"{row.envs:,}",
                f"{row.kernels:,}",
                f"{row.waits:,}",
            ),
            *(
                f"{row.bytes / 1e3:.1f}",
                f"{row.memory / 1e9:.2f}",
                " to ".join(f"{rate / 1e3:.0f}k" for rate in row.steps_per_s),
            ),
        )
        for row in sorted(rows, key=lambda row: row.key)
        if row.of == "update"
    ]
    headings = (
        "game",
        "network",
        "card",
        "environments",
        "kernels",
        "waits",
        "kB an env step",
        "GB of memory",
        "env steps/s, estimated",
    )
    return Table("one update of IPPO, preset `paper`", headings, tuple(lines), 3)


if __name__ == "__main__":
    main()
