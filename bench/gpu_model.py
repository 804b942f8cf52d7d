"""What one step of a game costs on a GPU that is not there: XLA compiles for a described card, and what it made is counted (gpu_cost.py).

`make gpu-model` makes the environment for it: JAX with its plug-in for CUDA, 5.5 GB, no GPU needed. Nothing runs on a GPU, and no figure is a
measurement. Compiling takes seconds to a minute for each row, so rows are kept in a JSON file, and a program that is there already is not
compiled again. With --suite CHECKOUT the suite's own environments are compiled as well, from a checkout of its repository:

    build/gpu-model/.venv/bin/python bench/gpu_model.py coins harvest_open --envs 1024,4096 --suite SocialJax --json runs/gpu_model.json
"""

import argparse
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
from sjdsl.bench.timing import memory_of
from sjdsl.library.substrates import substrates
from sjdsl.runtime.forms import forced

NINE = published.suite()
TEN = (  # Melting Pot's substrates, one of each family of rules
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
# Games with 20 agents. Coins is for two.
TWENTY = (
    *(f"{game}+crowd" for game in NINE if game not in ("coins", "pd_arena")),
    "pd_arena*20",
)
GROUPS = {"nine": NINE, "ten": TEN, "twenty": TWENTY}
SECTION = "gpu model"
STEP_TABLES = (  # the arguments of `step_table`: title, names, whose, observation
    ("one step of a game, tokens", NINE, "ours", "tokens"),
    ("one step of a game, one-hot observations", NINE, "ours", "onehot"),
    ("one step of a game, the suite's own environments", NINE, "suite", "its own"),
    ("one step of a game with 20 agents, tokens", TWENTY, "ours", "tokens"),
    ("one step of a substrate, tokens", TEN, "ours", "tokens"),
    ("one step of a substrate, one-hot observations", TEN, "ours", "onehot"),
)


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
    """Compiles the programs that the command line names, prints and stores a row for each."""
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
        "--envs",
        type=parse_numbers,
        default=(4096,),
        help="environments side by side, such as 1024,4096",
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
        row = compile_row(program, asked.gpu, rows, asked.hlo, asked.kernels)
        rows = read_rows(asked.json) | {row.key: row}  # another process may have added some
        write_rows(asked.json, rows)
        print(line_of(row), flush=True)
    if asked.markdown:
        write_section(asked.markdown, SECTION, page(rows))


def parse_numbers(text: str) -> tuple[int, ...]:
    return tuple(map(int, text.split(",")))


def target_of(gpu: Gpu) -> Any:
    """Returns the sharding of arrays on a card that is only described."""
    topology = topologies.get_topology_desc(
        platform="cuda", target_config=gpu.xla_target_config, topology="1x1x1"
    )
    mesh = topologies.make_mesh(topology, (1,), ("d",))
    return jax.sharding.NamedSharding(mesh, jax.sharding.PartitionSpec())


def programs(asked: argparse.Namespace, target: Any) -> Iterator[Program]:
    """Yields the programs that the command line asks for."""
    names = [name for word in asked.games for name in GROUPS.get(word, (word,))]
    for name in names:
        if asked.update:
            for network in asked.update.split(","):
                yield update_of(name, network, target)
            continue
        for envs in asked.envs:
            if not asked.only_suite:
                for observation in asked.observation.split(","):
                    yield step_of(name, observation, envs, target)
            if asked.suite is not None and name in SUITE:
                yield suite_step(name, asked.suite, envs, target)


def shapes_on(target: Any, tree: Any, batch: tuple[int, ...] = ()) -> Any:
    """Returns the shapes of a tree's arrays, with further axes in front, on the card."""
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
    num_agents = int(agents) if agents else None
    return sjdsl.make(game, variant or None, num_agents=num_agents, observation=observation)


def step_of(name: str, observation: str, envs: int, target: Any) -> Program:
    """Returns `env.step` of many environments, with resets, as `sjdsl bench` plays it."""
    env = make(name, observation)
    task = game_task(env)
    actions = jax.ShapeDtypeStruct((env.num_agents,), jnp.int32)
    shapes = (jax.eval_shape(task.reset), actions, jax.ShapeDtypeStruct((2,), jnp.uint32))

    def step_one(state: Any, actions: Any, key: Any) -> Any:
        return task.step(state, actions, jax.random.wrap_key_data(key))

    return Program(
        of="ours",
        name=name,
        observation=observation,
        envs=envs,
        agents=env.num_agents,
        function=jax.vmap(step_one),
        shapes=shapes_on(target, shapes, (envs,)),
        env_steps=envs,
    )


def suite_step(name: str, checkout: Path, envs: int, target: Any) -> Program:
    """Returns a step of the suite's own environment, with its resets."""
    jnp.clip = socialjax_original.clip  # type: ignore[assignment]
    module_and_class, agents = SUITE[name]
    make_original = socialjax_original.load(checkout, module_and_class)
    env = make_original(num_agents=agents, shared_rewards=False)
    key = jax.ShapeDtypeStruct((2,), jnp.uint32)
    state = jax.eval_shape(lambda k: jax.tree.map(jnp.asarray, env.reset(k)[1]), key)
    step = jax.vmap(socialjax_original.make_step(env))
    shapes = (state, jax.ShapeDtypeStruct((agents,), jnp.int32), key)
    return Program(
        of="suite",
        name=name,
        observation="its own",
        envs=envs,
        agents=agents,
        # The state comes first, as its memory is used again.
        function=lambda state, actions, key: step(key, state, actions),
        shapes=shapes_on(target, shapes, (envs,)),
        env_steps=envs,
    )


def update_of(name: str, network: str, target: Any) -> Program:
    """Returns one update of IPPO with the preset `paper`: a rollout, and learning from it."""
    from sjdsl.trainers import make_train
    from sjdsl.trainers.settings.preset import load_preset

    env = make(name, "tokens")
    config = load_preset("paper", {"algorithm": "ippo", "network": network}, name).config
    train = make_train(env, config)
    state = jax.eval_shape(lambda: train.init(jax.random.key(0)))
    return Program(
        of="update",
        name=name,
        observation=network,
        envs=config.num_envs,
        agents=env.num_agents,
        function=train.update,
        shapes=shapes_on(target, (state,)),
        env_steps=config.steps_per_update,
    )


def compile_row(
    program: Program, gpu: str, rows: dict[Any, Row], hlo: Path | None, kernels: bool
) -> Row:
    """Returns the row of a program; compiles it unless `rows` has the same program.

    hlo: a folder for the text of what XLA made, None: it isn't kept. kernels: whether to print them. With either of these it's always compiled.
    """
    with forced("gpu"):
        lowered = jax.jit(program.function, donate_argnums=0).lower(*program.shapes)
    digest = hashlib.sha256(f"{jax.__version__} {lowered.as_text()}".encode()).hexdigest()[:16]
    known = rows.get((program.of, program.name, program.observation, program.envs, gpu))
    if known is not None and known.program == digest and not kernels and hlo is None:
        return known
    start = processor_time()
    compiled = lowered.compile()
    compile_seconds = processor_time() - start
    text = compiled.as_text()
    if hlo is not None:
        hlo.mkdir(parents=True, exist_ok=True)
        name = f"{program.of}_{program.name}_{program.observation}_{program.envs}_{gpu}.hlo"
        (hlo / name.replace(" ", "_")).write_text(text)
    cost = cost_of(text)
    if kernels:
        print("\n".join(map(line_of_kernel, cost.kernels)))
    results = jax.eval_shape(program.function, *program.shapes)
    least_bytes = sum(
        math.prod(leaf.shape) * jnp.dtype(leaf.dtype).itemsize
        for leaf in jax.tree.leaves((program.shapes, results))
        if not jnp.issubdtype(leaf.dtype, jax.dtypes.prng_key)
    )
    steps = program.env_steps
    shorter, longer = cost.seconds(GPUS[gpu])
    counted = Counter(kernel.op for kernel in cost.kernels)
    return Row(
        of=program.of,
        name=program.name,
        observation=program.observation,
        envs=program.envs,
        gpu=gpu,
        agents=program.agents,
        program=digest,
        kernels=cost.launches,
        waits=cost.waits,
        bytes=cost.bytes / steps,
        least_bytes=least_bytes / steps,
        operations=cost.operations / steps,
        steps_per_s=(steps / longer, steps / shorter),
        memory=memory_of(compiled),
        compile_seconds=compile_seconds,
        made_of=dict(counted.most_common()),
    )


def processor_time() -> float:
    """Returns the seconds that processors have spent on this process and on those that XLA has started, which it compiles with."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def read_rows(path: Path) -> dict[Any, Row]:
    """Returns the rows that a file keeps, by `key`; none if there is no such file."""
    if not path.exists():
        return {}
    stored = [
        Row(**{**row, "steps_per_s": tuple(row["steps_per_s"])})
        for row in json.loads(path.read_text("utf-8"))
    ]
    return {row.key: row for row in stored}


def write_rows(path: Path, rows: dict[Any, Row]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [json.dumps(dataclasses.asdict(rows[key])) for key in sorted(rows)]
    path.write_text("[\n" + ",\n".join(lines) + "\n]\n", encoding="utf-8")


def line_of_kernel(kernel: Kernel) -> str:
    times = f"{kernel.times} times " if kernel.times > 1 else ""
    shape = re.sub(r"{.*?}", "", kernel.shape)  # without the order of its axes in memory
    size = f"{kernel.bytes / 1e6:.2f} MB, {kernel.operations / 1e6:.1f} M operations"
    return f"{times}{kernel.name}: {shape}, {size}; {', '.join(kernel.made_by)}"


def line_of(row: Row) -> str:
    """Returns a row in words."""
    return (
        f"{row.of} {row.name} {row.observation}, {row.envs} envs, {row.gpu}: {row.kernels} kernels, {row.waits} wait, {row.bytes / 1e3:.1f} kB "
        f"({row.bytes / row.least_bytes:.1f} times the least), {row.operations / 1e3:.0f}k operations, {millions(row)} M steps/s, "
        f"{row.memory / 1e9:.2f} GB, compiled in {row.compile_seconds:.0f} s of processor time"
    )


def millions(row: Row) -> str:
    """Returns the estimated millions of steps a second: `1.2 to 3.4`."""
    low, high = (rate / 1e6 for rate in row.steps_per_s)
    return f"{low:.2g} to {high:.2g}" if high < 10 else f"{low:.0f} to {high:.0f}"


def page(rows: dict[Any, Row]) -> str:
    """Returns the tables of the page, from all rows."""
    all_rows = list(rows.values())
    tables = [step_table(*columns, all_rows) for columns in STEP_TABLES]
    tables += [checked_table(all_rows), update_table(all_rows)]
    parts = [f"`make gpu-model`, JAX {jax.__version__}. Nothing here was measured."]
    for table in tables:
        if table.rows:
            title = f"{table.title[0].upper()}{table.title[1:]}"
            parts.append(f"{title}:\n\n{markdown_table(table)}")
    return "\n\n".join(parts) + "\n"


def step_table(
    title: str, names: tuple[str, ...], of: str, observation: str, rows: list[Row]
) -> Table:
    """Returns a table with a line a game; figures for several numbers of environments stand side by side."""
    shown = [
        row
        for row in rows
        if (row.of, row.observation, row.gpu) == (of, observation, "h100") and row.name in names
    ]
    batches = sorted({row.envs for row in shown})
    figures: list[tuple[str, Callable[[Row], str]]] = [
        ("kernels", lambda row: str(row.kernels)),
        ("waits", lambda row: str(row.waits)),
        ("kB an env", lambda row: f"{row.bytes / 1e3:.1f}"),
        ("times the least", lambda row: f"{row.bytes / row.least_bytes:.1f}"),
        ("1,000 operations an env", lambda row: f"{row.operations / 1e3:.0f}"),
        ("million steps/s, estimated", millions),
        ("seconds to compile", lambda row: f"{row.compile_seconds:.0f}"),
    ]
    by_key = {(row.name, row.envs): row for row in shown}
    lines = []
    for name in names:
        of_name = [by_key.get((name, envs)) for envs in batches]
        agents = next((str(row.agents) for row in of_name if row is not None), None)
        if agents is None:
            continue
        cells = []
        for _, in_words in figures:
            cells.append(" / ".join("" if row is None else in_words(row) for row in of_name))
        lines.append((name, agents, *cells))
    sizes = " / ".join(f"{envs:,}" for envs in batches)
    return Table(
        f"{title}, H100, {sizes} environments",
        ("game", "agents", *(heading for heading, _ in figures)),
        tuple(lines),
    )


def checked_table(rows: list[Row]) -> Table:
    """Returns the estimates for an A100 beside what the paper measured on one."""
    by_key = {row.key: row for row in rows}
    lines = []
    for name in SUITE:
        ours = by_key.get(("ours", name, "tokens", 4096, "a100"))
        suite = by_key.get(("suite", name, "its own", 4096, "a100"))
        if ours is None or suite is None:
            continue
        measured = published.speed(name, crowd=False)[4096]
        low, high = suite.steps_per_s
        # Of the geometric means of the low and the high estimate.
        ratio = math.sqrt(math.prod(ours.steps_per_s) / math.prod(suite.steps_per_s))
        lines.append(
            (
                name,
                f"{ours.kernels} / {suite.kernels}",
                f"{ours.bytes / 1e3:.1f} / {suite.bytes / 1e3:.1f}",
                millions(ours),
                millions(suite),
                f"{measured / 1e6:.2g}",
                f"{low / measured:.1f} to {high / measured:.1f}",
                f"{ratio:.1f}",
            )
        )
    headings = (
        "game",
        "kernels, ours / the suite's",
        "kB an env",
        "ours, estimated",
        "the suite's, estimated",
        "measured, paper",
        "estimated to measured",
        "ours to the suite's",
    )
    return Table(
        "an A100 at 4,096 environments, million steps a second, beside what the suite's paper measured",
        headings,
        tuple(lines),
    )


def update_table(rows: list[Row]) -> Table:
    """Returns what updates of a trainer cost."""
    lines = [
        (
            row.name,
            row.observation,
            row.gpu.upper(),
            f"{row.envs:,}",
            f"{row.kernels:,}",
            f"{row.waits:,}",
            f"{row.bytes / 1e3:.1f}",
            f"{row.memory / 1e9:.2f}",
            " to ".join(f"{rate / 1e3:.0f}k" for rate in row.steps_per_s),
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
