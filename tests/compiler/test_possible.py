"""Which conditions the compiler says can never hold: what rules, limits of numbers and words exclude, and nothing that a use, a size or a map makes possible."""

import pytest

from sjdsl.compiler import check
from sjdsl.compiler.diagnostics.source import Source

GAME = """sj 1
game yard {{
  size reach : cells = 2 in 1 .. 9
  size many : steps = 100
  param length : steps = 50
  param few : count = 2 in 0 .. 4
  episode {episode}
  kind grass "."
  kind bed "b" {{ field crop : {{ bare, leek, kale }} = bare  field age : 0 .. 7 = 0 }}
  map {{ ".b.b" }}
  agents 2 {{ acts stay, dig  field bag : 0 .. 9 = 0  field far : 0 .. reach = 0  field kin : set of agent }}
  {declared}
  phase start {{ each agent {{ send agent to grass }} }}
  schedule {schedule}
  phase work {{ {work} }}
  phase sort(crop, n) {{ each bed where bed.crop is crop and bed.age > n {{ give 1 to all  when bed.crop is leek {{ give 2 to all }} }} }}
  observe {{ show bed.age as {{ old where bed.age > 3, young }}  show agent.far  show agent.kin as {{ kin where agent in agent.kin, alone }} }}
}}
"""


def never(work: str, episode: str = "100", schedule: str = "work", declared: str = "") -> list[str]:
    """Returns what is underlined as never happening."""
    text = GAME.format(work=work, episode=episode, schedule=schedule, declared=declared)
    found = check(Source("yard.sj", text))
    assert not [d.message for d in found if d.severity == "error" and d.code != "SJ106"]
    return [text[d.span.start : d.span.end] for d in found if d.code == "SJ504"]


@pytest.mark.parametrize(
    ("condition", "part"),
    [
        ("bed.age > 7", ""),
        ("8 <= bed.age", ""),
        ("bed.age in 8 .. 9", ""),
        ("bed.age < few and few < 0", "few < 0"),
        ("bed.age > 5 and bed.age < 3", "bed.age < 3"),
        ("bed.age == 2 and bed.age == 3", "bed.age == 3"),
        ("bed.age != bed.age", ""),
        (
            "bed.crop is leek and (few > 1 and bed.crop in { bare, kale })",
            "bed.crop in { bare, kale }",
        ),
        (
            "bed.crop is not bare and bed.crop is not kale and bed.crop is not leek",
            "bed.crop is not leek",
        ),
        ("not (bed.crop is leek or bed.crop is not leek)", "bed.crop is not leek"),
        ("nobody on bed and not (nobody on bed)", "nobody on bed"),
        ("step == 100", ""),
        ("any(agent where agent.bag > 12)", "agent.bag > 12"),
        ("count(agent where agent chose dig and agent chose stay) == 0", "agent chose stay"),
    ],
)
def test_what_never_holds_is_said_after_where_as_after_when(condition: str, part: str) -> None:
    assert never(f"each bed where {condition} {{ give 1 to all }}") == [part or condition]
    assert never(f"each bed {{ when {condition} {{ give 1 to all }} }}") == [part or condition]


@pytest.mark.parametrize(
    "condition",
    [
        "bed.age > 6",
        "bed.crop is not bare and bed.crop is not kale",
        "bed.age > few",
        "few > 3",
        "step == 99",
        "any(agent where agent.far > 5)",  # another `reach`
        "bed.col > 3 and count(grass) > 5",  # another map
        "any(agent where agent.index == 7)",  # more agents
        "all(agent where agent.bag < 20)",
        "bed.crop is leek or bed.crop is kale",
        "reach > 5",
        "any(bed as other where other.crop is leek and bed.crop is kale)",
    ],
)
def test_what_may_hold_is_not_warned_of(condition: str) -> None:
    assert never(f"each bed where {condition} {{ give 1 to all }}") == []


@pytest.mark.parametrize("episode", ["length", "2 * length", "many"])
def test_an_episode_that_may_be_longer(episode: str) -> None:
    assert never("when step == 110 { give 1 to all }", episode=episode) == []


@pytest.mark.parametrize(
    ("schedule", "found"),
    [
        ("sort(leek, 3)", []),
        ("sort(leek, 3) -> sort(kale, 9)", []),
        ("sort(kale, 3) -> sort(bare, 2)", ["bed.crop is leek"]),
        ("sort(kale, 8) -> sort(bare, 9)", ["bed.age > n", "bed.crop is leek"]),
    ],
)
def test_a_phase_is_warned_of_only_if_no_use_makes_it_possible(
    schedule: str, found: list[str]
) -> None:
    assert never("", schedule=f"{schedule} -> work") == found


@pytest.mark.parametrize(
    ("uses", "found"),
    [("older(4)", []), ("older(4) + older(8)", []), ("older(8) + older(9)", ["bed.age > n"])],
)
def test_a_define_is_warned_of_only_if_no_use_makes_it_possible(
    uses: str, found: list[str]
) -> None:
    assert (
        never(
            f"when {uses} > 0 {{ give 1 to all }}",
            declared="define older(n) = count(bed where bed.age > n)",
        )
        == found
    )


def test_checks_may_ask_for_what_never_happens() -> None:
    checks = "always not any(bed where bed.age > 7)  once step > 200 always count(bed where bed.age > 9) == 0"
    assert never("", declared=f"checks {{ {checks} }}") == []


def test_pick_of_none() -> None:
    picked = "pick 0 bed { give 1 to all }  pick few bed { give 2 to all }  pick crowd bed { give 3 to all }"
    assert never(picked, declared="size crowd : count = 0 in 0 .. 3") == ["0"]
