"""What does not fit the game is refused, with a message that says what to change."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from sjdsl.testing import Scene, Stage

GAME = Path(__file__).parent / "camp.sj"
STAGE = Stage(GAME)
PICTURE = ("PPP.v#", "^.TT..", "...<..")


def put(*picture: str, **facts: Any) -> Callable[[], Scene]:
    return lambda: STAGE.put(*(picture or PICTURE), **facts)


def fields(name: str, value: Any) -> Callable[[], Scene]:
    return put(fields={name: value})


def looks(**signs: str) -> Callable[[], Any]:
    return lambda: Stage(GAME, looks=signs).put(*PICTURE)


# how it is written -> a part of the message
MISTAKES: list[tuple[Callable[[], Any], str]] = [
    # pictures
    (put("PPP.v#", "^.TT.."), "the picture has 2 rows, the map has 3"),
    (put("PPP.v#", "^.TT.", "...<.."), "row 1 of the picture has 5 cells, the map has 6: `^.TT.`"),
    (
        put("PPP.v#", "^.TT.P", "...<.."),
        "row 1, column 5: `P` stands for `gate`, and the map has `grass` there",
    ),
    (
        put("PPP.v#", "^.xT..", "...<.."),
        "row 1, column 2: `x` isn't a sign; the map has a `tree` there: `T` tree fruit=ripe, `t` tree fruit=none",
    ),
    (put("PPP.v#", "^.TT..", "......"), "the game has 3 agents; the picture has 2 arrows"),
    (
        put("PPP.v#  0", "^.TT..  0", "...<.."),
        "the game has 3 agents; the picture has 3 arrows, told [0, 0]",
    ),
    (
        put("PPP.v#  01", "^.TT..", "...<.."),
        "row 0 has 1 agents; beside it `01` does not number them",
    ),
    (put(under={7: "."}), "under: one sign for an agent of the picture, not 7: '.'"),
    (put(under={0: "T"}), "under agent 0: `T` stands for `tree`, and the map has `grass` there"),
    # looks
    (
        looks(T="tree fruit=none"),
        "`T` is a glyph of the game already, of `tree`: take another sign for `tree fruit=none`",
    ),
    (looks(v="tree fruit=none"), "`v` is an arrow of an agent and stands for a cell"),
    (looks(b="tre fruit=none"), "look `b`: the game has no kind `tre`; did you mean `tree`?"),
    (looks(b="tree friut=none"), "`tree` has no field `friut`; did you mean `fruit`?"),
    (looks(b="tree fruit"), 'write "tree field=value"'),
    (
        looks(b="tree fruit=rope"),
        "`tree.fruit` is one of none, ripe, not 'rope'; did you mean `ripe`?",
    ),
    (looks(b="tree takers=0"), "`tree.takers` has many values; put it with `fields`"),
    (lambda: Stage(GAME, arrows="nes").signs, "`arrows` are four different characters"),
    # fields
    (fields("agent.bog", 1), "`agent` has no field `bog`; did you mean `bag`?"),
    (fields("tre.fruit", 1), "the game has no `tre`; did you mean `tree`?"),
    (fields("mod", 1), "the game has no field `mod`; did you mean `mood`?"),
    (fields("agent.bag[rod]", 1), "there is no entry `rod`; did you mean `red`?"),
    (fields("agent.hue[red]", 1), "`hue` is one value, without an index"),
    (
        fields("agent.bag", 1),
        "`agent.bag of 0` has an entry for each of red, blue: write `agent.bag of 0[red]`, or a mapping by entry",
    ),
    (
        fields("agent.bag[red]", [1, 2]),
        "`agent.bag[red]`: 2 values are given, there are 3; give some as a mapping",
    ),
    (fields("agent.bag[red]", 10), "`agent.bag[red] of 0` is a whole number from 0 to 9, not 10"),
    (
        fields("agent.hue", {1: "rad"}),
        "`agent.hue of 1` is one of red, blue, not 'rad'; did you mean `red`?",
    ),
    (fields("agent.friend", {1: 3}), "`agent.friend of 1`: the agents are 0 .. 2, not 3"),
    (fields("tree.fruit", {(0, 0): "none"}), "`tree.fruit`: (0, 0) is none of (1, 2), (1, 3)"),
    (
        fields("agent.tired", {0: 1000}),
        "the timer `tired` holds up to 255 steps in this game, not 1000",
    ),
    # away
    (
        put("PPP.v#", "..TT..", "...<..", away={1: (2, "walk")}),
        "no phase `walk` sends it away `after` some steps; fire can",
    ),
    (
        put("PPP.v#", "..TT..", "...<..", away={1: -1}),
        "the ticks until it returns are 0 (never) or more, not -1",
    ),
    (
        lambda: Stage("coins", ("CP", "PC")).put("CP", ">C", away={1: 0}),
        "nobody is removed for good in this game",
    ),
    # numbers
    (put(params={"heta": 1}), "the game has no parameter `heta`; did you mean `heat`?"),
    (put(params={"heat": -1}), "`heat` is -1, outside 0"),
    # what is asked
    (
        lambda: put()().step("forwards"),
        "`forwards` isn't an action of this game; did you mean `forward`?",
    ),
    (lambda: put()().value("reward"), "no step has been taken"),
    (lambda: put()().value("event eaten[red]"), "no step has been taken"),
    (lambda: put()().value("marks walk"), "no phase `walk` marks cells; there are fire"),
    (lambda: put()().seen(0, "contents"), "there is no plane `contents`; did you mean `content`?"),
    (
        lambda: put()().seen(0, "content", ahead=10),
        "10 ahead, 0 to the right is outside the window",
    ),
]


@pytest.mark.parametrize(
    ("mistake", "message"), MISTAKES, ids=[message[:40] for _, message in MISTAKES]
)
def test_mistakes(mistake: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=re.escape(message)):
        mistake()


def test_a_game_that_is_not_there() -> None:
    with pytest.raises(FileNotFoundError, match="did you mean `coins`"):
        Stage("coin").put("CP")


SENDERS = """sj 1
game senders "Two phases that send away, one of them to two places" {
  episode 9
  kind grass "."
  kind gate "g"
  map { "..gg" }
  agents 2 { acts stay, forward, leave }
  phase start { each agent { send agent to grass } }
  schedule tick -> leave -> flee
  phase leave { each agent where agent chose leave { send agent to gate after 3 } }
  phase flee {
    each agent where agent chose forward {
      when agent.heading is north { send agent to gate after 2 } otherwise { send agent to grass after 2 otherwise stay }
    }
  }
}
"""


def test_who_is_away_needs_one_destination(tmp_path: Path) -> None:
    """If several phases could have sent it away, one is named; if that one has several destinations, the scene can't be put."""
    game = tmp_path / "senders.sj"
    game.write_text(SENDERS, encoding="utf-8")
    stage = Stage(game, interpreted=True)
    with pytest.raises(
        ValueError, match=re.escape("say which phase sent it away (flee, leave), as (2, 'flee')")
    ):
        stage.put(">.gg", away={1: 2})
    with pytest.raises(ValueError, match="the phase flee sends away to several destinations"):
        stage.put(">.gg", away={1: (2, "flee")})
    assert stage.put(">.gg", away={1: (2, "leave")}).value("agent.ticks") == [0, 2]
