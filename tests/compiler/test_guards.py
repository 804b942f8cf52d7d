"""What a guard proves about a whole number or a word, and how a condition is quoted that it contradicts."""

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source
from tests.compiler.refusals import codes_in

GAME = """sj 1
game frame "Guards" {{
  episode 9
  param worth : reward = {{ raw: 1, cut: 2 }}
  param luck : probability = 0.2
  kind grass "."
  map {{ "...." }}
  agents 2 {{
    acts stay
    field held : 0 .. 9 = 0
    field bag by {{ raw, cut }} : 0 .. 3 = 0
    field holds : {{ nothing, raw, cut, ash }} = nothing
  }}
  define is_food(who) = who.holds is raw or is_cut(who)
  define is_cut(who) = who.holds is cut
  phase start {{ each agent {{ send agent to grass }} }}
  schedule rule
  phase rule {{ {body} }}
}}
"""
MIX = "each agent where sum(agent.bag) {} {{ give worth[mix(agent.bag)] to agent }}"
WRITES = "each agent where agent.held {} {{ set agent.held = 1 }} each agent as other where other.held {} {{ set other.held = other.index }}"


def codes(body: str) -> set[str]:
    return codes_in(GAME.format(body=body))


@pytest.mark.parametrize("guard", ["> 0", "> 1", ">= 1", ">= 2", "> 0.5", ">= 0.5", "== 2"])
def test_a_row_of_at_least_one_has_shares(guard):
    assert codes(MIX.format(guard)) == set()


@pytest.mark.parametrize("guard", [">= 0", "> -1", "< 3", "!= 1"])
def test_a_row_that_can_be_empty_has_none(guard):
    assert codes(MIX.format(guard)) == {"SJ208"}


def test_one_lies_between_one_half_and_more():
    assert codes(WRITES.format("> 1.5", "< 1.5")) == set()
    assert codes(WRITES.format("> 0.5", "< 1.2")) == {"SJ401"}


SHARES = "each agent {{ when count(agent as a where {}) > 0 {{ give 1 / count(agent as b where {}) to agent }} }}"


def test_names_of_bound_variables_do_not_matter():
    assert codes(SHARES.format("a.held > 1", "b.held > 1")) == set()
    assert codes(SHARES.format("a.held > 1", "b.held > 2")) == {"SJ207"}
    assert codes(SHARES.format("a.held > 1 and a is agent", "b.held > 1 and agent is b")) == {
        "SJ207"
    }


@pytest.mark.parametrize("guard", ["luck > 0", "luck >= 0.4", "0.4 <= luck"])
def test_what_is_more_than_nothing_need_not_be_one(guard):
    assert codes(
        f"each agent {{ when {guard} {{ chance 2 * luck - 1 {{ give 1 to agent }} }} }}"
    ) == {"SJ202"}
    assert (
        codes("each agent { when luck >= 0.5 { chance 2 * luck - 1 { give 1 to agent } } }")
        == set()
    )


def test_conditions_on_counts_exclude_each_other_whatever_their_variables_are_called():
    counted = "each agent where count(agent as a where a.held > 1) > 0 {{ set agent.held = 1 }} each agent as b where {} {{ set b.held = 2 }}"
    assert codes(counted.format("count(agent as c where c.held > 1) == 0")) == set()
    assert codes(counted.format("count(agent as c where c.held > 2) == 0")) == {"SJ401"}


LEAST = "when {} {{ each agent where min(b.held over agent as b {}) > 1 {{ give 1 to agent }} }}"


@pytest.mark.parametrize(("guard", "domain"), [
    ("step >= 0", ""),
    ("count(agent as c where c.held > 1) > 0", "where b.held > 1"),
    ("count(agent as c where c.held > 1) >= 1", "where b.held > 1"),
    ("count(agent as c where c.held > 1) != 0", "where b.held > 1"),
    ("count(agent as c where c.held > 1) == 2", "where b.held > 1"),
    ("step >= 0", "where b.held > 1 otherwise 0"),
])  # fmt: skip
def test_a_domain_with_a_member_has_a_least_value(guard, domain):
    assert codes(LEAST.format(guard, domain)) == set()


@pytest.mark.parametrize(("guard", "domain"), [
    ("step >= 0", "where b.held > 1"),
    ("count(agent as c where c.held > 2) > 0", "where b.held > 1"),
    ("count(agent as c where c.held > 1) >= 0", "where b.held > 1"),
    ("step >= 0", "on grass"),
    ("step >= 0", "in disc(1) of agent"),
])  # fmt: skip
def test_a_domain_that_can_be_empty_has_none(guard, domain):
    assert codes(LEAST.format(guard, domain)) == {"SJ217"}


def test_where_agents_can_be_away_there_is_one_as_long_as_one_is_named():
    remove = "each agent where agent chose stay { remove agent }"
    assert codes(f"{remove}  when min(agent.held over agent) > 1 {{ give 1 to all }}") == {"SJ217"}
    assert (
        codes(f"{remove}  each agent where min(b.held over agent as b) > 1 {{ give 1 to agent }}")
        == set()
    )
    assert codes("when min(agent.held over agent) > 1 { give 1 to all }") == set()


FOOD = "each agent as a {{ each agent as b where {} {{ give worth[a.holds] to b }} }}"


@pytest.mark.parametrize(
    "guard",
    [
        "a.holds in { raw, cut }",
        "a.holds is raw or a.holds is cut",
        "raw is a.holds or a.holds in { cut }",
        "(a.holds is raw or a.holds is cut) and b.held > 1",
        "not (a.holds is nothing or a.holds is ash)",
        "is_food(a)",
        "a.holds is raw or (a.holds is cut or a.holds is raw)",
    ],
)
def test_a_word_is_one_of_those_that_or_joins(guard):
    assert codes(FOOD.format(guard)) == set()


@pytest.mark.parametrize(
    "guard",
    [
        "a.holds is raw or a.holds is ash",
        "a.holds is raw or b.holds is cut",
        "a.holds is raw or b.held > 1",
        "a.holds is not raw or a.holds is not ash",
        "not (a.holds is raw or a.holds is cut)",
        "a.holds is raw and a.holds is cut or a.held > 1",
    ],
)
def test_or_leaves_every_other_word(guard):
    assert codes(FOOD.format(guard)) == {"SJ205"}


def test_conditions_joined_with_or_exclude_a_word_that_none_names():
    free = "each agent where {} {{ set agent.held = 1 }} each agent as b where {} {{ set b.held = b.index }}"
    assert codes(free.format("agent.holds is raw or agent.holds is cut", "b.holds is ash")) == set()
    assert codes(free.format("agent.holds is raw or agent.holds is cut", "b.holds is cut")) == {
        "SJ401"
    }


@pytest.mark.parametrize(
    ("rule", "quoted"),
    [
        ("each agent where agent.holds is raw { when agent.holds is cut { end } }", "`agent.holds is raw` holds here"),
        ("each agent { when agent.holds is raw { } otherwise when agent.holds is raw { end } }", "`agent.holds is not raw` holds here"),
        ("each agent { when agent.holds is not raw { } otherwise { when agent.holds is ash { end } } }", "`agent.holds is raw` holds here"),
        ("each agent { when agent.bag[cut] > 1 { } otherwise { when agent.bag[cut] > 2 { end } } }", "`agent.bag[cut] <= 1` holds here"),
        ("when any(agent where agent.held > 1) { } otherwise when any(agent where agent.held > 1) { end }",
         "`not any(agent where agent.held > 1)` holds here"),
        ("when not all(agent where agent.held > 1) { when all(agent where agent.held > 1) { end } }",
         "`not all(agent where agent.held > 1)` holds here"),
        ("each agent where agent chose stay { when not agent chose stay { end } }", "`agent chose stay` holds here"),
        ("each agent { when worth[raw] * 1 > 9 and agent.bag[raw] +  agent.held > 20 { end } }", "`agent.bag[raw] + agent.held` is 0 .. 12"),
    ],
)  # fmt: skip
def test_what_never_happens_is_quoted_as_written(rule, quoted):
    warnings = [d for d in check(Source("frame.sj", GAME.format(body=rule))) if d.code == "SJ504"]
    assert [d.message for d in warnings] == [f"this can never happen: {quoted}"]
