"""What agents are told of a task beside the fields that are shown."""

from pathlib import Path

import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.properties import GameFamily
from sjdsl.properties.hidden_task import HiddenTask, hidden_task
from sjdsl.properties.verify_properties import decide_statically

TEXT = """sj 1
game told "A task that is told or not" {
  episode 5
  task rules { field hue : { red, green }  field price by { red, green } : 0 .. 9 }
  field mood : { good, bad } = good
  kind grass "."  kind tree "T"
  map { "..." "T.." }
  agents 2 { acts stay, forward  moves relative }
  phase start { each agent { send agent to grass } }
  schedule pay -> walk
  phase pay { when hue is red and price[red] > 4 { give 1 to all } }
  phase walk { move each agent }
  observe { window ahead 1, behind 1, left 1, right 1  SHOWN }
}
"""


def told(shown: str) -> HiddenTask:
    verdict = hidden_task(build(Source("told.sj", TEXT.replace("SHOWN", shown))).game)
    assert verdict is not None
    return verdict


@pytest.mark.parametrize("shown", ["", "show mood", "show agent.row"])
def test_nothing_that_is_seen_reads_the_task(shown: str) -> None:
    assert told(shown) == HiddenTask("rules", ("hue", "price"), "proved")


def test_what_is_shown_as_it_is_is_not_hidden() -> None:
    assert told("show hue").fields == ("price",)
    assert told("show hue  show price").fields == ()


@pytest.mark.parametrize(
    "shown",
    [
        "show mood as { good where price[red] > 4, bad }",
        "show tree as { grass where hue is green, tree }",
        "show mood when hue is red",
    ],
)
def test_labels_and_conditions_that_read_the_task_tell_it(shown: str) -> None:
    verdict = told(shown)
    assert verdict.how == "told"
    assert verdict.lines == (13,)


def test_what_reads_the_task_and_shows_nothing_of_it_is_tried() -> None:
    verdict = told("show mood as { good where price[red] > 4 and price[red] < 4, bad }")
    assert verdict.how == "tried"
    assert "random states" in str(verdict)


def test_a_game_without_a_task_has_none() -> None:
    cases = Path(__file__).parents[1] / "cases"
    text = (cases / "moving.sj").read_text("utf-8")
    assert hidden_task(build(Source("moving.sj", text)).game) is None


@pytest.mark.parametrize("between", ["  ", " } }\n  phase rank at start { each agent { "])
def test_symmetry_counts_the_beginning_that_trials_play_again(between: str) -> None:
    """Agents get their numbers before the first step: in a step only where an episode has trials."""
    text = TEXT.replace("SHOWN", "").replace("T..", "TT.")
    text = text.replace("agents 2 {", "agents 2 { field rank : 0 .. 1 = 0 ")
    text = text.replace(
        "send agent to grass }", f"send agent to grass{between}set agent.rank = agent.index }}"
    )
    text = text.replace("  observe", "  checks { symmetric agents }\n  observe")
    for episode, how in (("episode 5", "proved"), ("episode 2 trials of 5", "decided")):
        source = Source("told.sj", text.replace("episode 5", episode))
        verdict = decide_statically(GameFamily(source, ()), 0)
        assert verdict is not None
        assert (verdict.how, verdict.passed) == (how, how == "proved"), verdict
