"""Proofs and guards beside what float32 rounds: whole numbers beyond 2^24, reals that become infinite, agents whose number can vary."""

import pytest

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import Effort, GameFamily, Report, verify_properties
from sjdsl.properties.verify_properties import decide_statically

LARGE = """sj 1
game large "Large" {{
  size  players : count = {players}
  size  guests : count = 1 in 0 .. 2
  param least : count = 16777210 in 16777206 .. 16777230
  param most : count = 16777230 in 16777206 .. 16777230
  param near : number = 16777216 in 16777000 .. 16778000
  param one : number = 4 in 0.9 .. 4
  param share : number = 0 in 0 .. 40
  param huge : number = 1 in -1000000000 .. 1000000000
  episode 20
  kind grass "."
  map {{ "...." }}
  field n : 16777200 .. 16777230 = 16777217
  field m : 16777200 .. 16777230 = 16777216
  field j : 0 .. 5 = 0
  field k : 0 .. 5 = 0
  field part : 0 .. 40 = 0
  field pot : reward = 1
  agents {number} {{ acts stay, vote(agent), offer(agent, 0 .. 2)  {forbid} }}
  define value = {value}
  define argument = n
  phase start {{ {start} }}
  schedule rule
  phase rule {{ {rule} }}
  checks {{ require near < near{sum}  {checks} }}
}}
"""
SUM = " + one" * 20
SENT = "each agent { send agent to grass }"
DOUBLED = "add pot * 1000000 to pot"


def large(
    checks: str = "",
    rule: str = "",
    players: str = "2",
    number: str = "players",
    forbid: str = "",
    value: str = "1",
    start: str = SENT,
) -> GameFamily:
    """Returns a game of numbers that float32 rounds, with these parts."""
    parts = {
        "players": players,
        "number": number,
        "forbid": forbid,
        "value": value,
        "start": start,
        "sum": SUM,
    }
    return GameFamily(Source("large.sj", LARGE.format(checks=checks, rule=rule, **parts), None))


def refused(**parts: str) -> set[str]:
    """Returns the codes of what is wrong with such a game."""
    try:
        large(**parts)
    except CompileError as error:
        return {d.code for d in error.diagnostics if d.severity == "error"}
    return set()


def is_proved(family: GameFamily) -> bool:
    verdict = decide_statically(family, len(family.own.checks) - 1)
    return verdict is not None and verdict.how == "proved"


GUARDS = {  # of `set k = n - 16777211`, where n is at least 16777211 -> whether it keeps k in 0 .. 5, as float32 compares
    "n <= 16777216": True,
    "n <= 16777216.0": False,
    "16777216.0 >= n": False,
    "n < 16777217.0": True,
    "n < 16777217.5": False,
    "n == 16777216.0": False,
    "n in 0 .. 16777216.0": False,
    "n in 0.0 .. 16777216": False,
    "not (n > 16777216.0)": False,
    "not (n >= 16777216.0)": True,
    "n + 0.0 <= 16777216": False,
    "n * 1.0 <= 16777216.0": False,
    "n - 16777211.0 <= 5": False,
    "n + j <= 16777216 + j * 1.0": False,
    "n <= 16777216 + 0.0": False,
}


@pytest.mark.parametrize("guard", GUARDS)
def test_which_guards_keep_a_field_in_its_range(guard: str) -> None:
    rule = f"when n >= 16777211 and {guard} {{ set k = n - 16777211 }}"
    assert refused(rule=rule) == (set() if GUARDS[guard] else {"SJ204"})


@pytest.mark.parametrize(
    "guard",
    [
        "j <= 4.0",
        "j < 4.5",
        "not (j > 4.0)",
        "j in 0.0 .. 4",
        "j == 4.0",
        "j * 1.0 <= 3 and j <= 4.0",
    ],
)
def test_small_whole_numbers_beside_reals_are_exact(guard: str) -> None:
    assert not refused(rule=f"when {guard} {{ set k = j + 1 }}")


@pytest.mark.parametrize(
    ("one", "other", "exclusive"),
    [
        ("n > 16777216", "n <= 16777216.0", False),
        ("n > 16777216.0", "n <= 16777216.0", True),
        ("pot >= 0.1", "pot <= 0.09999999999", False),
        ("pot >= 0.1", "pot <= 0.05", True),
        ("pot > 0.1", "not (pot > 0.1)", True),
        ("not (pot > 0.1)", "not (pot <= 0.1)", False),  # both hold of NaN
        ("not (pot > 1)", "not (pot < 2)", False),
        ("not (share > 1)", "not (share < 2)", True),  # no parameter is NaN
    ],
)
def test_which_writes_exclude_each_other(one: str, other: str, exclusive: bool) -> None:
    rule = f"when {one} {{ set k = 1 }}  when {other} {{ set k = 2 }}"
    assert refused(rule=rule) == (set() if exclusive else {"SJ401"})


def test_a_cancelled_sum_that_is_rounded_leaves_its_range() -> None:
    assert refused(rule="set part = round((share + 1000000000) - 1000000000)") == {"SJ204"}
    assert not refused(rule="set part = round(share)")
    assert not refused(rule="when huge >= 0 and huge <= j { set part = round(huge * 8) }")
    assert refused(
        rule="set part = round(max(huge - 1000000, 0))", checks="require huge <= 1000040"
    ) == {"SJ204"}  # up to a millionth
    assert not refused(rule="set part = round(min(max((huge + 1000000000) - 1000000000, 0), 39))")


def test_agents_are_placed_by_float32() -> None:
    """2.99999999 is 3.0 there, and agent 3 is not above it."""
    start = "each agent where agent.index <= 2 {{ send agent to grass }}  each agent where agent.index > {} {{ send agent to grass }}"
    assert refused(players="4", start=start.format("2.99999999"))
    assert not refused(players="4", start=start.format("2.5"))


def test_a_require_of_whole_numbers_is_exact() -> None:
    assert refused(checks="require least * 100 + 1 <= least * 100") == {"SJ212"}
    assert refused(checks="require least + 1 == least") == {"SJ212"}
    assert not refused(checks="require least + 7 == near")  # 16777217 as a float32


RAMPS = {  # -> what is refused of a ramp between two ends, where a guard says that they differ
    ("n", "m"): {"SJ215"},
    ("n", "m + 1"): {"SJ215"},
    ("least", "most"): {"SJ215"},
    ("n * 1.0", "m * 1.0"): set(),
    ("near", f"near{SUM}"): set(),
    ("j", "k"): set(),
}


@pytest.mark.parametrize(("zero", "one"), RAMPS)
def test_the_ends_of_a_ramp_differ_as_float32(zero: str, one: str) -> None:
    guarded = f"when {zero} < {one} {{ set part = round(ramp(n, {zero}, {one})) }}"
    assert refused(rule=guarded) == RAMPS[zero, one]
    assert (
        refused(checks=f"always {zero} == {one} or ramp({zero}, {zero}, {one}) <= 1")
        == RAMPS[zero, one]
    )


def test_a_require_tells_ends_apart_in_float32() -> None:
    """20 times 0.9 is more than a millionth of 2^24, and adding 0.9 to 2^24 gives 2^24."""
    from sjdsl.library.parameters import param_values

    game = large(rule=f"set part = round(ramp(near, near, near{SUM}))").own
    assert param_values(game, {"near": 16777216.0, "one": 4.0})
    with pytest.raises(ValueError, match="require"):
        param_values(game, {"near": 16777216.0, "one": 0.9})


def test_slopes_of_ramps() -> None:
    assert refused(
        checks="require least < most  monotone value rising in argument",
        value="ramp(n, least, most)",
    ) == {"SJ215"}
    assert is_proved(
        large(
            "require share < huge  monotone value rising in argument", value="ramp(n, share, huge)"
        )
    )


@pytest.mark.parametrize(
    ("players", "number", "forbid", "proved"),
    [
        ("1", "players", "forbid vote(0) when step > 0", False),
        ("1", "players", "forbid vote when step > 0", True),
        ("1", "players", "forbid vote(x) when step > 0", True),
        ("1 in 1 .. 1", "players", "forbid vote(0) when step > 0", True),
        ("1", "1", "forbid vote(0) when step > 0", True),
        ("1", "players * 1", "forbid vote(0) when step > 0", False),
        ("1", "players + guests - 1", "forbid vote(0) when step > 0", False),
        ("1", "players + guests - 1", "forbid vote(x) when step > 0", True),
        ("1", "players", "forbid offer(players - 1, 2) when step > 0", False),
        ("1", "players", "forbid offer(x, 2) when step > 0", True),
        ("2 in 1 .. 2", "players", "forbid vote(0), vote(1) when step > 0", True),
        ("2 in 1 .. 3", "players", "forbid vote(0), vote(1) when step > 0", False),
        (
            "2 in 2 .. 2",
            "players",
            "forbid vote(0) when step > 0  forbid vote(1) when step > 1",
            False,
        ),
    ],
)
def test_symmetry_for_every_number_of_agents(
    players: str, number: str, forbid: str, proved: bool
) -> None:
    assert (
        is_proved(large("symmetric agents", players=players, number=number, forbid=forbid))
        is proved
    )


def test_numbers_of_agents_that_a_require_leaves_out() -> None:
    """A number between those that are refused counts, too."""
    parts = {"players": "1 in 1 .. 4", "forbid": "forbid vote(0) when step > 0"}
    assert not is_proved(large("require players == 1 or players == 4  symmetric agents", **parts))
    assert is_proved(large("require players == 1 or players == 9  symmetric agents", **parts))


@pytest.mark.parametrize(
    "check",
    [
        "always pot * 0 <= 0",
        "always min(pot, 5) <= 5",
        "always max(pot * 0, 1) >= 1",
        "always not (min(pot, 5) > 5)",
        "always pot - pot in 0 .. 0",
        "always ramp(pot, 0, 1) <= 1",
        "always (pot + 1) / (max(pot, 0) + 1) <= 1",
        "always huge * huge * huge * huge * huge * 0 <= 0",
        "always sum(huge * huge * huge * huge over grass) < 0 or sum(huge * huge * huge * huge over grass) >= 0",
        "always sum(huge * huge * huge * huge * huge over agent) * 0 <= 0",
        "conserved pot * 0",
        "once n > 0 always pot * 0 <= 0",
    ],
)
def test_reals_that_may_leave_float32_prove_nothing(check: str) -> None:
    assert not is_proved(large(check))


@pytest.mark.parametrize(
    "check",
    [
        "always huge * 0 <= 0",
        "always min(huge, 5) <= 5",
        "always huge * huge * huge * huge >= 0 or huge * huge * huge * huge < 0 or one > 0",
        "always max(huge * huge * huge * huge * huge, 1) >= 1",  # infinite, and a number
        "always ramp(share, 0, one) <= 1",
        "always k <= 5",
        "conserved one * share",
    ],
)
def test_other_reals_prove_as_much_as_before(check: str) -> None:
    assert is_proved(large(check, rule=DOUBLED))


def test_nothing_is_proved_by_ranges_where_nan_may_be_rounded() -> None:
    assert not is_proved(
        large("always part <= 40", rule="set part = round(min(max(pot / max(pot, 1), 0), 40))")
    )


def report_of(family: GameFamily) -> Report:
    return verify_properties(family, Effort(examples=30, compiled=False))


@pytest.mark.parametrize(
    "checks", ["", "conserved count(agent)", "always k <= 5  symmetric agents"]
)
def test_a_game_whose_checks_are_all_proved_is_played_for_reals_that_leave_float32(
    checks: str,
) -> None:
    (fault,) = report_of(large(checks, rule=DOUBLED)).faults
    assert "a real leaves float32" in fault.reason


def test_a_game_whose_reals_stay_in_float32_is_not_played_for_that() -> None:
    report = report_of(
        large("conserved count(agent)", rule="each agent { give share * one to agent }")
    )
    assert (report.steps, report.faults) == (0, ())
