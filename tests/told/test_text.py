"""The text that a player is told: every name that it may know is in it, and no rule as written."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import sjdsl
from sjdsl.compiler import build, ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.queries import all_fields
from sjdsl.compiler.lower import token_planes
from sjdsl.told import told
from sjdsl.told.naming import Naming
from sjdsl.told.phrases import English
from sjdsl.told.relevance import relevant
from sjdsl.told.sentences import Speaker

from .corpus import CASES, FILES, GOLDEN, game, variants

TURNED = """sj 1
game one "One" {
  episode 100
  kind grass "."
  map { "...." "...." }
  agents 4 { acts stay, forward  moves compass }
  phase start { each agent { send agent to grass facing north } }
  SCHEDULE
  phase walk { move each agent }
  RULE
  observe { window ahead 2, behind 1, left 1, right 1 }
}
"""
# Fields that only metrics or policies read, or no rule of that variant.
UNTOLD = {
    *("clean_up+socialjax clean_at_first", "gift_refinement+socialjax refined"),
    *("reputation patient", "reputation+village patient"),
    *("bach_or_stravinsky_in_the_matrix badge", "pure_coordination_in_the_matrix badge"),
    *("rationalizable_coordination_in_the_matrix badge",),
    *("running_with_scissors_in_the_matrix+one_shot badge",),
    *("running_with_scissors_in_the_matrix+one_shot young",),
    *(
        f"{name}_in_the_matrix+repeated badge"
        for name in (
            *("bach_or_stravinsky", "chicken", "prisoners_dilemma", "pure_coordination"),
            *("rationalizable_coordination", "running_with_scissors", "stag_hunt"),
        )
    ),
}
# What the language writes and English doesn't: `x == y`, `0 .. 9`, `set x`, Python's values.
AS_WRITTEN = re.compile(
    r"[=!<>]=|[^.]\.\. |[{}]| = "
    r"|\bTrue\b|\bFalse\b|\bNone\b|\binf\b|object at|\(\)|[a-z]  +[a-z]|[,;:.][,;:.]"
)


def names_of(g: ir.Game) -> set[str]:
    """Returns the names of what is on the map, of all fields, words, actions, shapes and planes."""
    glyphs = set("".join(g.rows))
    kinds = {meaning.kind for meaning in g.glyphs if meaning.glyph in glyphs}
    found = kinds | {movers.name for movers in g.movers}
    found |= {shape.name for shape in g.shapes}
    found |= {action.partition("(")[0] for action in g.agents.actions}
    found |= {param.name for param in g.params if param.type.indexed_by}
    for field in all_fields(g):
        if field.held_by.what != "cell" or field.held_by.name in kinds:
            found |= {field.name, *field.type.words}
    for plane in token_planes(g)[2:]:
        found |= {*plane.labels} - {"nobody"}
        found |= {plane.name} - {"marks"}
    for label in token_planes(g)[0].labels:
        kind, *states = label.split()
        found |= {state.partition("=")[2] for state in states if kind in kinds}
    return found


def check_names(name: str) -> None:
    """Checks that each is told as a whole word, not as a part of another one."""
    text = told(game(name))
    absent = {
        one
        for one in names_of(game(name))
        if not re.search(rf"(?<!\w){re.escape(one)}(?!\w)", text)
    }
    assert {f"{name} {one}" for one in absent} <= UNTOLD


@pytest.mark.parametrize("name", FILES)
def test_every_name_that_a_player_may_know_is_told(name: str) -> None:
    check_names(name)


@pytest.mark.thorough
def test_every_name_is_told_in_each_variant() -> None:
    for name in variants():
        check_names(name)


@pytest.mark.parametrize("name", [*FILES, *CASES])
def test_no_rule_is_told_as_it_is_written(name: str) -> None:
    if name in CASES and not game(name).observables and not game(name).window:
        return
    text = told(game(name)).partition("YOUR WINDOW")[0]
    before, _, after = text.partition("SHAPES\n")
    text = before + after.partition("\n\n")[2]  # its pictures have points
    found = [text[max(0, m.start() - 40) : m.end() + 40] for m in AS_WRITTEN.finditer(text)]
    assert found == []


def test_every_statement_has_a_sentence() -> None:
    """Of all statements that matter to a player; none is told as written."""
    silent = []
    for name in FILES:
        g = relevant(game(name)).game
        values = {param.name: param.value for param in g.params}
        speaker = Speaker(English(Naming(g, values)))
        for phase in (g.start, *g.schedule):
            for node in ir.walk(phase):
                if isinstance(node, ir.Statement) and not speaker.lines(node):
                    silent.append(f"{name} {type(node).__name__}")
    assert silent == []


def test_numbers_are_those_of_the_environment() -> None:
    env = sjdsl.make("clean_up", params={"apple": 2.5, "length": 70})
    text = told(env, agent=6)
    assert "the agent gets a reward of 2.5" in text
    assert "An episode lasts 70 steps." in text
    assert "You are agent 6." in text
    with pytest.raises(ValueError, match="numbered 0 to 6; there is no 7"):
        told(env, agent=7)


def test_tactics_events_and_titles_are_not_told() -> None:
    text = told(game("clean_up"))
    for word in ("cooperator", "defector", "eaten", "cleaned", "Clean Up", "commons", "residents"):
        assert word not in text
    assert "first trial" not in told(game("two_trees"))


def test_the_author_can_say_more() -> None:
    g = game("clean_up").model_copy(update={"about": (("player", "Be quick."), ("summary", "No."))})
    assert "whole episode.\nBe quick.\nAn episode" in told(g)


@pytest.mark.parametrize("name", ["mushrooms", "pd_arena", "chemistry"])
def test_an_environment_is_told_as_its_game(name: str) -> None:
    env = sjdsl.make(str(FILES[name]))
    assert told(env) == told(env.game)


def test_the_space_of_a_task_is_told() -> None:
    text = told(game("tasks"))
    assert "(233,280 ways, all equally likely)" in text  # 3 * 720 * 27 * 4
    assert "pay: for each of red, green and blue, a whole number from 0 to 9" in text
    assert "no two the same" in text


def test_an_unknown_expression_is_refused() -> None:
    class New(ir.Expression):
        type: ir.Type

    english = English(Naming(game("clean_up"), {}))
    with pytest.raises(AssertionError, match="Expected code to be unreachable"):
        english.text(New(type=ir.Type(kind="int")))  # type: ignore[arg-type]


def test_nothing_of_jax_is_loaded() -> None:
    code = "import sys, sjdsl.told; sys.exit('jax' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_text_is_as_it_was(golden) -> None:
    golden(GOLDEN / "clean_up.txt", told(game("clean_up"), agent=0))
    golden(GOLDEN / "two_trees.txt", told(game("two_trees"), agent=0))


def test_shapes_say_whether_the_middle_belongs_and_lanes_where_rules_speak_of_them() -> None:
    prey = told(game("predator_prey"))
    assert "- disc(3, centre), 29 cells (x, and the middle @, which belongs to it);" in prey
    assert "in the shape `disc(3, centre)` around agent x" in prey
    foraging = told(game("lb_foraging"))
    assert "- beside, 4 cells (x) around the middle o, which does not belong to it;" in foraging
    assert "lane" not in told(game("clean_up"))
    territory = told(game("territory"))
    assert "Each column is a lane, from the agent's row outward; a lane ends at" in territory
    assert "in agent a's shape `paint`" in territory  # an action is called so too


def test_headings_and_turns_are_told_where_agents_turn() -> None:
    turning = told(game("clean_up"))
    assert "a heading (north, east, south or west)" in turning
    assert "a turn changes only the heading" in turning
    foraging = told(game("lb_foraging"))
    assert "a heading" not in foraging
    assert "turn" not in foraging.partition("WHAT HAPPENS")[2].partition("YOUR WINDOW")[0]
    assert "A>" not in foraging


@pytest.mark.parametrize("phase", ["phase rule { %s }", "phase rule at start { %s }"])
def test_who_is_turned_by_a_rule_does_not_always_look_north(phase: str) -> None:
    rule = phase % "each agent { set agent.heading = east }"
    schedule = "" if "at start" in phase else " -> rule"
    text = TURNED.replace("RULE", rule).replace("SCHEDULE", f"schedule walk{schedule}")
    assert "always look north" not in told(build(Source("one.sj", text)).game)
    plain = TURNED.replace("RULE", "").replace("SCHEDULE", "schedule walk")
    assert "You always look north" in told(build(Source("one.sj", plain)).game)


def test_a_parameter_may_be_called_as_a_word_of_python(tmp_path: Path) -> None:
    text = TURNED.replace("RULE", "phase pay { each agent { give lambda to agent } }")
    path = tmp_path / "one.sj"
    path.write_text(text.replace("SCHEDULE", "param lambda : reward = 1\nschedule walk -> pay"))
    env = sjdsl.make(str(path), params={"lambda": 2.5})
    assert "the agent gets a reward of 2.5" in told(env)


def test_what_a_field_is_at_first_is_told_unless_the_beginning_sets_it() -> None:
    water = "state (clean or dirty; at first clean on 68 cells and dirty on 79 cells)"
    rows = game("clean_up").rows
    glyphs = {m.glyph: dict(m.starts) for m in game("clean_up").glyphs if m.kind == "water"}
    clean = sum(row.count(g) for row in rows for g in glyphs if glyphs[g].get("state") != "dirty")
    assert clean == 68
    assert water in told(game("clean_up"))
    assert "level (1 to 2)\n" in told(game("lb_foraging"))  # drawn for all
    assert "role (prey or predator; prey at first)" in told(game("predator_prey"))  # for some


def test_an_argument_of_a_forbidden_action_is_called_by_a_letter() -> None:
    text = told(game("reputation"))
    assert "- nurse(x) is not allowed while agent x is not one of" in text
    assert "the who is" not in text and "the who's" not in text


def test_values_below_the_window_are_those_that_a_player_can_see() -> None:
    text = told(game("lb_foraging"))
    assert "- other.level: 1 to 2\n" in text
    reputation = told(game("reputation"))
    assert "- other.health: well, ill, hidden\n" in reputation
    assert "is at most 2; else it is hidden." in reputation
    assert "- gate always looks like floor.\n" in told(game("chicken_in_the_matrix"))


def test_what_others_carry_is_said_to_be_unseen() -> None:
    """In Gift Refinement an agent sees its own bag alone, in LB Foraging the levels of all."""
    unseen = "You are not shown: other.bag, agent.post and other.post.\n"
    assert unseen in told(game("gift_refinement"))
    assert "You are not shown" not in told(game("lb_foraging"))


def test_what_stays_from_trial_to_trial_is_told() -> None:
    text = told(game("open_harvest"))
    kept = "these keep their values from one trial to the next, whatever is said there: each tree"
    assert kept in text
    assert "stay until it ends:\n- pay_order: for each of" in text
    assert "all equally likely.\nIn each trial:\n- Each agent" in text
    assert "speed_order.\n\nYOUR REPLY" in text.partition("You are not shown")[2]


def test_phases_at_the_start_are_told_in_order() -> None:
    begun = told(game("starting")).split("HOW A TRIAL BEGINS")[1].split("WHAT HAPPENS")[0]
    stages = re.findall(r"^After that \((\w+)\):$", begun, re.MULTILINE)
    assert stages == ["settle", "claim", "scatter", "stroll"]
