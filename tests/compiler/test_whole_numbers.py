"""Whole numbers stay in int32: what can leave it is refused, and what is accepted is computed as Python's unbounded integers are."""

import itertools
import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import jax
import jax.numpy as jnp
import pytest

import sjdsl
from sjdsl.compiler import compile_source
from sjdsl.compiler.diagnostics.source import Source
from tests.compiler.refusals import errors_in

LOWEST, HIGHEST = -(2**31), 2**31 - 1
AGENTS = 4


def text(
    rules: str = "",
    declared: str = "",
    of_agents: str = "",
    metrics: str | None = None,
    checks: str = "",
    episode: str = "20",
) -> str:
    if metrics is None:
        metrics = "event hits" if "hits" in rules else ""
    return f"""sj 1
game sums {{
  {declared}
  episode {episode}
  kind floor "."
  map {{ "........" }}
  agents {AGENTS} {{ acts stay, wave  moves relative  {of_agents} }}
  phase start {{ each agent {{ send agent to floor }} }}
  phase act {{ {rules} }}
  schedule {"tick -> " * ("timer" in of_agents)}act
  metrics {{ {metrics} }}
  checks {{ {checks} }}
}}
"""


def said(game: str) -> list[str]:
    return [f"{d.code} {d.message}" for d in errors_in(game)]


END = "; whole numbers end at 2147483647"
POT = "field pot : 0 .. 1000000000 capped = 0"


@pytest.mark.parametrize(
    ("game", "message"),
    [
        (text("when step * 1000000 > 5 { tally hits }", episode="2148"), f"`step * 1000000` can become 2148000000{END}"),
        (text("tally hits by k * k", "param k : count = 46341"), f"`k * k` can become 2147488281{END}"),
        (text(declared="field big : 0 .. 536870912 = 0", metrics="final x = min(big * 4, 7)"), f"`big * 4` can become 2147483648{END}"),
        (text("each agent { add 286870912 to pot }", POT), f"4 times in a phase, this can let `pot` become 2147483648{END}"),
        (text("tally hits by 2147483647  tally hits by 1"), f"1 time in a step, this can let the count of `hits` become 2147483648{END}"),
        (text("each agent { tally hits by 536870912 }"), f"4 times in a step, this can let the count of `hits` become 2147483648{END}"),
        (text(of_agents="field worth : 0 .. 536870912 = 0", metrics="final x = sum(agent.worth over agent)"), f"`sum(agent.worth over agent as agent)` can become 2147483648{END}"),
        (text(declared="field row by { a, b } : 0 .. 1073741824 = 0", metrics="final x = sum(row)"), f"`sum(row)` can become 2147483648{END}"),
        (text("when 0 - big * 3 < 0 { tally hits }", "field big : 0 .. 1000000000 = 0"), f"`big * 3` can become 3000000000{END}"),
        (text("when low - 2147483647 - 2 < 0 { tally hits }", "field low : 0 .. 9 = 0"), "`(low - 2147483647) - 2` can become -2147483649; whole numbers begin at -2147483648"),
        (text("tally hits by 2 * 1500000000"), f"`3000000000` can become 3000000000{END}"),
        (text("each agent { set agent.hot = agent.hot + 3 }", of_agents="timer hot", episode="715827883"), f"`agent.hot` can become 2147483649{END}"),
        (text("tally hits by 1000000", checks="always hits >= 0", episode="2148"), f"`hits` can become 2148000000{END}"),
        (text("let twice = big * 2  tally hits by twice", "field big : 0 .. 1073741824 = 0"), f"`big * 2` can become 2147483648{END}"),
        (text("draw n from 3 .. k  tally hits by n * 300000000", "param k : count = 9 in 3 .. 60000"), f"`n * 300000000` can become 2700000000{END}"),
    ],
)  # fmt: skip
def test_what_can_leave_int32_is_refused(game: str, message: str) -> None:
    assert f"SJ218 {message}" in said(game)


def test_the_bound_that_helps_is_the_largest_that_does() -> None:
    def help_of(game: str) -> str:
        (only,) = errors_in(game)
        return only.hint

    squared = text("tally hits by k * k", "param k : count = 99999")
    assert help_of(squared) == "`k` can be 46340 at most"
    assert not errors_in(squared.replace("99999", "46340"))
    assert errors_in(squared.replace("99999", "46341"))
    pot = text("each agent { add 999999999 to pot }", POT)
    assert help_of(pot) == "it can be 286870911 at a time at most"
    assert not errors_in(pot.replace("999999999", "286870911"))
    counted = text("each agent { tally hits by 999999999 }  tally hits by 3")
    assert help_of(counted) == "it can be 536870911 at a time at most"
    assert not errors_in(counted.replace("999999999", "536870911"))
    guarded = text("tally hits by big * 3", "field big : 0 .. 1000000000 = 0")
    assert (
        help_of(guarded)
        == "guard it with `when big <= 715827882`, or see to it that `big` has a smaller range"
    )
    assert not errors_in(
        guarded.replace("tally hits by big * 3", "when big <= 715827882 { tally hits by big * 3 }")
    )


@pytest.mark.parametrize(
    "game",
    [
        text("when big < 10 and big * 1000 > 5 { tally hits }", "field big : 0 .. 1000000000 = 0"),
        text("when big > 10 or big * 1000 > 5 { tally hits }", "field big : 0 .. 1000000000 = 0"),
        text("when big > k { tally hits } otherwise { tally hits by big * 1000 }", "param k : count = 9  field big : 0 .. 1000000000 = 0"),
        text("tally hits by case big { 0..9: big * 1000, otherwise: 1 }", "field big : 0 .. 1000000000 = 0"),
        text("tally hits by count(agent as a where a.worth in 1 .. 9 and a.worth * 1000 > 5)", of_agents="field worth : 0 .. 1000000000 = 0"),
        text("tally hits by sum(a.worth * 9 over agent as a where a.worth < 9)", of_agents="field worth : 0 .. 1000000000 = 0"),
        text("each agent as a where a.worth <= 5 { tally hits by a.worth * 1000 for a }", of_agents="field worth : 0 .. 1000000000 = 0"),
        text("chance 0.5 { tally hits by 2000000000 } otherwise { tally hits by 2000000001 }"),
        text("pick 1 agent { tally hits by 2000000000 }"),
        text("each agent { tally hits by 2000000000 for agent }"),
        text("each agent as a { each agent as b { tally hits by 500000000 for b } }"),
        text("each agent { add 1000000000 to agent.worth }", of_agents="field worth : 0 .. 1000000000 capped = 0"),
        text("each agent { set agent.hot = agent.hot + 3 }", of_agents="timer hot", episode="700000000"),
        text("each agent { set agent.hot = min(agent.hot + 3, 9) }", of_agents="timer hot", episode="2000000000"),
        text("when big * 1.0 * big > 5 { tally hits }", "field big : 0 .. 1000000000 = 0"),
        text(declared="param k : count = 100000", checks="require k * k > 5"),
        text("when deep == -1000000000 { add 2000000000 to deep }", "field deep : -1000000000 .. 1000000000 = 0"),
        text("when unlimited > 5 { tally hits }", "param unlimited : count = 7"),
    ],
)  # fmt: skip
def test_what_cannot_leave_int32_is_accepted(game: str) -> None:
    assert said(game) == []


@pytest.mark.parametrize(("episode", "code"), [("0", "SJ214"), ("-5", "SJ214"), ("7 * 0", "SJ214"), ("days - 4", "SJ214"), ("20 - step", "SJ216"), ("2147483647 + 1", "SJ214")])  # fmt: skip
def test_an_episode_has_a_length(episode: str, code: str) -> None:
    assert [
        d.code for d in errors_in(text(declared="param days : steps = 4", episode=episode))
    ] == [code]
    assert not errors_in(text(declared="param days : steps = 4", episode="days - 3"))


def test_every_range_of_whole_numbers_has_a_module_of_its_own() -> None:
    """Seven digits: the hash of a game, by which its module is kept, tells them apart."""
    modules = [
        compile_source(Source("sums.sj", text("add 1 to pot", POT.replace("1000000000", str(end)))))
        for end in (1000000, 1000001)
    ]
    hashes = [
        next(line for line in module.splitlines() if line.startswith("HASH")) for module in modules
    ]
    assert hashes[0] != hashes[1]


def test_a_timer_that_the_map_starts_is_kept_as_it_is(tmp_path: Path) -> None:
    game = text("", metrics="final left = max(floor.dry over floor)").replace(
        'kind floor "."', 'kind floor "." { timer dry  glyph "," with dry = 300 }'
    )
    file = tmp_path / "sums.sj"
    file.write_text(
        game.replace('"........"', '",......."').replace("schedule act", "schedule tick -> act")
    )
    env = sjdsl.make(file)
    _, state = env.reset(jax.random.key(0))
    assert (
        env.step_env(jax.random.key(1), state, jnp.zeros(AGENTS, int))[-1]["metrics"]["left"] == 299
    )


# ---- random expressions


@dataclass(frozen=True)
class Leaf:
    """A number in an expression: its text, and the ends of what it can be."""

    said: str
    low: int
    high: int


@dataclass(frozen=True)
class Operation:
    fn: str
    parts: "tuple[Expression, ...]"


Expression = Leaf | Operation
NUMBERS = (
    0,
    1,
    2,
    3,
    7,
    255,
    256,
    32767,
    46340,
    46341,
    65536,
    1000000,
    16777217,
    715827882,
    1073741823,
    1073741824,
    2147483647,
)
ENDS = (
    1,
    2,
    9,
    255,
    256,
    1000,
    46340,
    46341,
    65535,
    100000,
    16777217,
    536870911,
    536870912,
    1000000000,
    1073741824,
)


def written(e: Expression) -> str:
    if isinstance(e, Leaf):
        return e.said
    parts = [written(part) for part in e.parts]
    match e.fn:
        case "min" | "max":
            return f"{e.fn}({', '.join(parts)})"
        case "neg":
            return f"(-({parts[0]}))"
        case _:
            return f"({parts[0]} {e.fn} {parts[1]})"


def value(e: Expression, of: dict[Leaf, int]) -> int:
    """Returns the value of an expression in Python's integers."""
    return int(eval(written(e), {leaf.said: number for leaf, number in of.items()}))


def leaves(e: Expression) -> list[Leaf]:
    return [e] if isinstance(e, Leaf) else [leaf for part in e.parts for leaf in leaves(part)]


def parts_of(e: Expression) -> Iterator[Expression]:
    """Yields an expression and those inside it that are computed in play: numbers alone are one number."""
    yield e
    if isinstance(e, Operation) and any(leaf.low < leaf.high for leaf in leaves(e)):
        for part in e.parts:
            yield from parts_of(part)


def corners(e: Expression) -> Iterator[dict[Leaf, int]]:
    """Yields the leaves at all combinations of their ends."""
    found = sorted(set(leaves(e)), key=lambda leaf: leaf.said)
    for ends in itertools.product(*[sorted({leaf.low, leaf.high}) for leaf in found]):
        yield dict(zip(found, ends, strict=True))


def random_expression(
    rng: random.Random, fields: list[Leaf], depth: int, functions: str
) -> Expression:
    """Returns an expression in which every field stands once at most: its ends are then those of its corners."""
    if depth == 0 or (rng.random() < 0.2 and fields):
        number = rng.choice(NUMBERS)
        return fields.pop() if fields and rng.random() < 0.8 else Leaf(str(number), number, number)
    fn = rng.choice(functions.split())
    if fn == "%":
        divisor = rng.choice([n for n in NUMBERS if n])
        return Operation(
            fn,
            (
                random_expression(rng, fields, depth - 1, functions),
                Leaf(str(divisor), divisor, divisor),
            ),
        )
    many = 1 if fn == "neg" else 2
    return Operation(
        fn, tuple(random_expression(rng, fields, depth - 1, functions) for _ in range(many))
    )


def fields_of(rng: random.Random) -> list[Leaf]:
    return [Leaf(name, 0, rng.choice(ENDS)) for name in "abcdef"]


def declared(fields: list[Leaf], starts: dict[Leaf, int]) -> str:
    return "  ".join(
        f"field {leaf.said} : {leaf.low} .. {leaf.high} = {starts[leaf]}" for leaf in fields
    )


def test_an_expression_is_refused_if_and_only_if_a_part_of_it_leaves_int32_at_some_corner() -> None:
    rng, refused = random.Random(1), 0
    for _ in range(300):
        fields = fields_of(rng)
        e = random_expression(rng, list(fields), 3, "+ - * min max neg")
        game = text(
            f"when {written(e)} > 0 {{ tally hits }}",
            declared(fields, dict.fromkeys(fields, 0)),
        )
        leaving = any(
            not LOWEST <= value(part, at) <= HIGHEST for part in parts_of(e) for at in corners(e)
        )
        assert any(d.code == "SJ218" for d in errors_in(game)) == leaving, written(e)
        refused += leaving
    assert 60 < refused < 240


def test_what_is_accepted_is_computed_as_unbounded_integers_are(tmp_path: Path) -> None:
    """At the ends of the fields and at random values; each expression is counted, what is below 0 by an event of its own."""
    rng, many = random.Random(2), 40
    fields = fields_of(rng)
    accepted: list[Expression] = []
    while len(accepted) < many:
        e = random_expression(rng, rng.sample(fields, len(fields)), 4, "+ - * % min max neg")
        counted = f"tally hits by max({written(e)}, 0)  tally hits by max(0 - {written(e)}, 0)"
        if len(set(leaves(e))) > 1 and not errors_in(
            text(counted, declared(fields, dict.fromkeys(fields, 0)))
        ):
            accepted.append(e)
    names = [(f"up{i}", f"down{i}") for i in range(many)]
    rules = [
        f"tally {up} by max({written(e)}, 0)  tally {down} by max(0 - {written(e)}, 0)"
        for e, (up, down) in zip(accepted, names, strict=True)
    ]
    metrics = " ".join(f"event {up} event {down}" for up, down in names)
    (tmp_path / "sums.sj").write_text(
        text("\n".join(rules), declared(fields, dict.fromkeys(fields, 0)), metrics=metrics)
    )
    env = sjdsl.make(tmp_path / "sums.sj")
    _, state = env.reset(jax.random.key(0))
    for turn in range(60):
        at = {
            leaf: rng.choice(
                (leaf.low, leaf.high) if turn % 2 else (rng.randint(leaf.low, leaf.high), leaf.high)
            )
            for leaf in fields
        }
        now = state.replace(
            **{f"world_{leaf.said}": jnp.int32(number) for leaf, number in at.items()}
        )
        events = jax.device_get(
            env.step_env(jax.random.key(turn), now, jnp.zeros(AGENTS, int))[-1]["events"]
        )
        for e, (up, down) in zip(accepted, names, strict=True):
            expected = value(
                e, at | {leaf: leaf.low for leaf in leaves(e) if leaf.low == leaf.high}
            )
            assert int(events[up]) - int(events[down]) == expected, (written(e), at)


def test_sums_of_a_phase_are_exact_at_the_largest_that_is_accepted(tmp_path: Path) -> None:
    """Four agents add to a field that is capped, to one each, and count; the interpreter's sums are Python's."""
    game = text(
        "each agent { add 286870911 to pot  add 1000000000 to agent.worth  tally hits by 536870911  tally own by 2147483647 for agent }",
        POT.replace("= 0", "= 999999999"),
        "field worth : 0 .. 1000000000 capped = 999999999",
        "event hits  event own",
    )
    (tmp_path / "sums.sj").write_text(game)
    env = sjdsl.make(tmp_path / "sums.sj")
    _, state = env.reset(jax.random.key(0))
    _, after, _, _, info = env.step_env(jax.random.key(1), state, jnp.zeros(AGENTS, int))
    assert int(after.world_pot) == min(999999999 + 4 * 286870911, 10**9)
    assert after.agent_worth.tolist() == [10**9] * AGENTS
    assert int(info["events"]["hits"]) == 4 * 536870911
    assert info["events"]["own"].tolist() == [HIGHEST] * AGENTS
