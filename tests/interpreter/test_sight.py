"""What depends on who looks, against windows worked out by hand."""

import numpy as np
import pytest

from sjdsl.compiler import build
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.planes import planes
from sjdsl.interpreter.state import Cell, default_params
from sjdsl.interpreter.step import reset
from sjdsl.interpreter.threefry import Threefry

GAME = """sj 1
game sight "Two who look along a strip" {{
  episode 5
  field king  : agent
  kind grass "."
  kind bush  "b"
  kind brick "o" {{ field owner : agent }}
  kind tile  "t" {{ field owner : agent  field worth : 0 .. 3 = 1 }}
  group thing = brick, tile
  map {{ ".b.ot" }}
  agents 2 {{ acts stay  field far : {{ yes_, no_ }} = no_  field bag : 0 .. 5 = 3 }}
  phase start {{ each agent {{ send agent to grass facing east  when agent.index == 1 {{ set agent.far = yes_ }} }} }}
  schedule rest
  phase rest {{ }}
  observe {{ {observe} }}
}}
"""


def seen(
    observe_: str, *places: int, owners: tuple[int | None, int | None] = (None, None)
) -> tuple[dict[str, np.ndarray], tuple]:
    """Returns each plane by its name, `[agents, rows, columns]`, with both agents in row 0, looking east; and the content's labels."""
    game = build(Source("sight.sj", GAME.format(observe=observe_))).game
    world = reset(game, default_params(game), Threefry(0, 0))
    world.position[:] = [Cell(0, column) for column in places]
    world.cells["brick", "owner"], world.cells["tile", "owner"] = [owners[0]], [owners[1]]
    found, seen_ = planes(game), observe(game, world)
    return {plane.name: seen_[:, number] for number, plane in enumerate(found)}, found[0].labels


STRIP = "window ahead 4, behind 0, left 0, right 0"


def ahead(plane: np.ndarray) -> list[list[int]]:
    """Returns what each agent sees from its own cell on."""
    return [column[::-1, 0].tolist() for column in plane]


def test_beyond_ones_own_window_all_is_as_off_the_map() -> None:
    found, labels = seen(
        "window ahead 1, behind 0, left 0, right 0  window ahead 4 when agent.far is yes_  show agent.bag  show other.bag",
        0,
        2,
    )
    assert labels == ("outside", "grass", "bush", "brick", "tile")
    assert ahead(found["content"]) == [[1, 2, 0, 0, 0], [1, 3, 4, 0, 0]]
    assert ahead(found["agent"]) == [
        [1, 0, 0, 0, 0],
        [1, 0, 0, 0, 0],
    ]  # agent 1 stands two cells ahead of agent 0
    assert ahead(found["other.bag"]) == [[0] * 5] * 2
    assert ahead(found["agent.bag"]) == [[3] * 5] * 2
    farther, _ = seen(
        "window ahead 2, behind 0, left 0, right 0  window ahead 4 when agent.far is yes_  show other.bag",
        0,
        2,
    )
    assert ahead(farther["other.bag"])[0] == [0, 0, 3, 0, 0]


def test_the_first_window_whose_condition_holds_counts() -> None:
    first = "window ahead 4 when agent.col == 0  window ahead 0 when agent.col == 0"
    found, _ = seen(f"window ahead 1, behind 0, left 0, right 0  {first}", 0, 2)
    assert ahead(found["content"]) == [[1, 2, 1, 3, 4], [1, 3, 0, 0, 0]]


def test_agents_cover_what_they_stand_on() -> None:
    found, labels = seen(f"{STRIP}  hide content on agents  show other.far", 0, 1)
    assert labels[-1] == "covered"
    assert ahead(found["content"])[0] == [5, 5, 1, 3, 4]  # the observer covers its own cell too
    assert ahead(found["agent"])[0] == [1, 2, 0, 0, 0]
    assert ahead(found["other.far"])[0] == [0, 1, 0, 0, 0]


def test_who_owns_the_things_of_a_group() -> None:
    found, labels = seen(f"{STRIP}  show thing.owner", 0, 2, owners=(0, 1))
    assert labels[3:] == tuple(
        f"{kind} owner={who}" for kind in ("brick", "tile") for who in ("nobody", "self", "other")
    )
    assert ahead(found["content"]) == [[1, 2, 1, 4, 8], [1, 5, 7, 0, 0]]


def test_shown_while_a_condition_holds() -> None:
    shown = "show agent.far when agent.col > 0  show agent.bag when agent.col > 0  show everyone.col  show other.moved when agent.col > 0"
    found, _ = seen(f"{STRIP}  {shown}", 0, 2)
    assert [plane[0, 0] for plane in found["agent.far"]] == [2, 0]  # hidden, yes_
    assert [plane[0, 0] for plane in found["agent.bag"]] == [0, 3]
    assert ahead(found["other.moved"])[0] == [0, 0, 3, 0, 0]  # nobody, no, yes, hidden
    assert [found[f"everyone[{agent}].col"][0, 0, 0] for agent in range(2)] == [0, 2]


def test_what_is_seen_by_distance_and_place() -> None:
    found, labels = seen(
        f"{STRIP}  show tile.worth as {{ rich where tile.worth > 0 and distance(agent, tile) < 3, some where tile.col == agent.col, far_away }}",
        0,
        2,
    )
    assert labels[4:] == ("tile worth=rich", "tile worth=some", "tile worth=far_away")
    assert ahead(found["content"]) == [[1, 2, 1, 3, 6], [1, 3, 4, 0, 0]]


def test_agents_block_shapes_only() -> None:
    text = GAME.replace("acts stay", "acts stay  blocks agents")
    with pytest.raises(CompileError, match="agents always block each other") as refused:
        build(Source("sight.sj", text.format(observe="show agent.bag")))
    assert refused.value.diagnostics[0].code == "SJ113"


def test_the_place_of_one_who_may_be_away_is_asked_with_care() -> None:
    text = GAME.replace(
        "phase rest {{ }}", "phase rest {{ each agent where agent.col > 2 {{ remove agent }} }}"
    )
    for label in (
        "near_by where distance(agent, everyone) < 2, far_off",
        "at_left where everyone.col < 2, at_right",
    ):
        with pytest.raises(CompileError, match="who may be away"):
            build(Source("sight.sj", text.format(observe=f"show everyone.bag as {{ {label} }}")))
        build(
            Source(
                "sight.sj",
                text.format(
                    observe=f"show everyone.bag as {{ gone where everyone.away, {label} }}"
                ),
            )
        )
        build(
            Source(
                "sight.sj",
                text.format(
                    observe=f"show everyone.bag as {{ {label.replace('where', 'where not everyone.away and')} }}"
                ),
            )
        )
