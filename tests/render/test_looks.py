"""What a `look` does to pictures, and that it does nothing else."""

import re
from pathlib import Path

import numpy as np
import pytest

import sjdsl
from sjdsl.compiler import build, check, compile_source
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir.hash import game_hash
from sjdsl.render import Snapshot
from sjdsl.render.appearance import TINTED, cell_keys, draw_cell, draw_figures, possessions_of
from sjdsl.render.colours import agent_colour, mixed, read_colour
from sjdsl.render.look import Look, make_look
from sjdsl.render.usual import Picture
from sjdsl.runtime.env import Environment

GAME = """sj 1
game grove "Grove" {
  episode 4
  kind moss  "."
  kind hedge "#" { blocks agents }
  kind start_ "S"
  kind bush "b" {
    field hue : { red, blue } = red     glyph "B" with hue = blue
    field crop : 0 .. 4 capped = 0
    field fruit : { none, ripe } = none
    field owner : agent
    field pickers : set of agent
  }
  map { "..S#.."
        ".bBbS." }
  agents 3 {
    acts turn_right, forward, stay
    moves relative
    field bag by { fresh, dry } : 0 .. 9 capped = 0
    field mood : { calm, wild } = calm
    timer tired
  }
  phase start { each agent { send agent to start_ or_moss } }
  schedule tick -> walk -> pick_up
  phase walk { move each agent }
  phase pick_up {
    each agent on bush {
      set bush.fruit = none  add agent to bush.pickers  add 1 to bush.crop  add 1 to agent.bag[fresh]
      set agent.mood = wild  set agent.tired = 3
    }
  }
  observe {
    show bush.crop as { much where bush.crop > 2, little }  show bush.owner
    show bush.pickers as { mine where agent in bush.pickers, others }  show agent.bag  show other.mood
  }
LOOKS
}
""".replace("start_ or_moss", "moss")
ALL = """
  look bush as "#102030"
  look bush where bush.hue is blue as green gem
  look bush where bush.crop >= 2 and bush.owner is nobody with coin
  look bush where not (bush.pickers is nobody) with black
  look agent where agent.bag[fresh] + agent.bag[dry] > 0 and agent.mood is wild as orange animal with pot
""".replace("agent.bag[fresh] + agent.bag[dry]", "sum(agent.bag)")


def made(looks: str, folder: Path) -> Environment:
    file = folder / "grove.sj"
    file.write_text(GAME.replace("LOOKS", looks), encoding="utf-8")
    return sjdsl.make(file)


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    return made("", tmp_path_factory.mktemp("plain"))


@pytest.fixture(scope="module")
def looked(tmp_path_factory: pytest.TempPathFactory) -> Environment:
    return made(ALL, tmp_path_factory.mktemp("looked"))


def bushes(look: Look, **fields: list) -> list:
    """Returns the drawings of the three bushes with some of their fields given."""
    kind = next(k for k in look.kinds if k.name == "bush")
    values = {
        "hue": [0, 1, 0],
        "crop": [0] * 3,
        "fruit": [0] * 3,
        "owner": [-1] * 3,
        "pickers": [0] * 3,
    } | fields
    keys, number = cell_keys(
        kind,
        {
            f"bush_{name}": np.array(v, np.uint32 if name == "pickers" else np.int32)
            for name, v in values.items()
        },
    )
    return [draw_cell(kind, keys[n]) for n in number]


def figures(look: Look, bag: list, mood: list) -> list:
    values = {"agent_bag": np.array(bag), "agent_mood": np.array(mood)}
    nothing = np.zeros(3, int)
    return draw_figures(look, Snapshot(0, values, nothing, nothing, nothing, nothing > 0, nothing))[
        "agent"
    ]


def test_a_look_is_no_rule(plain: Environment, looked: Environment) -> None:
    assert plain.hash == looked.hash
    texts = [
        compile_source(Source("grove.sj", GAME.replace("LOOKS", looks))) for looks in ("", ALL)
    ]
    assert texts[0] == texts[1], "not even a draw"
    assert looked.game.looks and game_hash(looked.game) == game_hash(plain.game)


def test_conditions_read_words_numbers_owners_and_sets(looked: Environment) -> None:
    look = make_look(looked.game)
    first, blue, _ = bushes(look)
    assert first.ground == mixed((16, 32, 48), read_colour("red"), TINTED), "no look reads its hue"
    assert first.body is not None and first.body.sprite == "bush", "by its name"
    assert blue.body == Picture("gem", read_colour("green"))
    assert blue.ground == (16, 32, 48), "what a later look does not speak of stays"
    cropped = bushes(look, crop=[2, 1, 4], owner=[-1, -1, 1], pickers=[4, 0, 0])
    coin, black = Picture("coin", read_colour("orange")), Picture("disc", read_colour("black"))
    assert [set(d.badges) for d in cropped] == [{coin, black}, set(), set()]


def test_a_field_that_a_look_reads_is_drawn_by_it_alone(
    looked: Environment, plain: Environment
) -> None:
    for env, bars, edge in ((looked, set(), None), (plain, {0, 1}, agent_colour(2))):
        drawn = bushes(make_look(env.game), crop=[3, 3, 3], owner=[-1, -1, 2], pickers=[1, 1, 1])
        assert {place for place, _ in drawn[2].bars} == bars
        assert (drawn[0].edge, drawn[2].edge) == (None, edge)


def test_what_no_agent_sees_is_not_drawn() -> None:
    """Numbers, owners, sets and the agents' fields are seen if they are shown, words of cells unless they are hidden."""
    unseen = re.sub(r"observe \{.*?\n  \}", "observe { hide bush.fruit }", GAME, flags=re.DOTALL)
    dark, light = (
        make_look(build(Source("grove.sj", text.replace("LOOKS", ""))).game)
        for text in (unseen, GAME)
    )
    crops = {"fruit": [1] * 3, "crop": [3] * 3, "owner": [2] * 3, "pickers": [1] * 3}
    for look, some in ((dark, False), (light, True)):
        bush, *_ = bushes(look, **crops)
        _, _, wild = figures(look, bag=[[9, 9]] * 3, mood=[1] * 3)
        assert [
            bool(part)
            for part in (bush.badges, bush.bars, bush.edge, wild.badges, look.possessions)
        ] == [some] * 5


def test_words_that_agents_cannot_tell_apart_look_alike() -> None:
    told = "show bush.hue as { reddish where bush.hue is red, other }"
    text = (
        GAME.replace("{ red, blue } = red", "{ red, blue, green } = red")
        .replace("show bush.owner", told)
        .replace("LOOKS", "")
    )
    look = make_look(build(Source("grove.sj", text)).game)
    red, blue, green = bushes(look, hue=[0, 1, 2])
    assert blue == green != red


def test_agents_show_what_they_carry(looked: Environment, plain: Environment) -> None:
    look = make_look(plain.game)
    idle, busy, full = figures(look, bag=[[0, 0], [2, 0], [1, 3]], mood=[0, 0, 1])
    assert (idle.badges, busy.badges) == ((), ())
    assert len(full.badges) == 1, "a mood; what can be counted stands in the agent's row"
    nothing = np.zeros(3, int)
    shot = Snapshot(
        0,
        {"agent_bag": np.array([[0, 0], [2, 0], [1, 3]])},
        nothing,
        nothing,
        nothing,
        nothing > 0,
        nothing,
    )
    assert [amount for _, amount in possessions_of(look, shot, 2)] == [1, 3]
    calm, _, wild = figures(make_look(looked.game), bag=[[1, 0], [0, 0], [1, 3]], mood=[0, 1, 1])
    assert (calm.sprite, calm.colour) == ("agent", agent_colour(0))
    assert (wild.sprite, wild.colour, wild.badges[0].sprite) == (
        "animal",
        read_colour("orange"),
        "pot",
    )
    assert len(wild.badges) == 1, "its fields are read by the look"


@pytest.mark.parametrize(
    ("look", "code"),
    [
        (
            "look agent where agent.unread > 1 as red",
            "SJ505",
        ),  # what only a picture reads is used by no rule
        ("look moss as red blue", "SJ115"),
        ("look moss as gem coin", "SJ115"),
        ("look mos as red", "SJ101"),
        ("look bush where bush.hue is green as red", "SJ205"),
    ],
)
def test_what_is_wrong_with_a_look_is_said(look: str, code: str) -> None:
    text = GAME.replace("LOOKS", look).replace(
        "timer tired", "timer tired  field unread : 0 .. 3 = 0"
    )
    used = text.replace(
        "set agent.tired = 3", "set agent.tired = 3  add 0 * agent.unread to agent.bag[dry]"
    )
    found = {d.code for d in check(Source("grove.sj", text if code == "SJ505" else used))}
    assert code in found


def test_what_blocks_is_drawn_by_its_name_and_water_is_not_land() -> None:
    kinds = ("land", "lake", "pond", "hedge", "cliff", "fence", "path", "x")
    blocking = ("lake", "hedge", "cliff", "fence", "x")
    declared = "  ".join(
        f'kind {name} "{name[0] if name != "path" else "t"}"'
        + " { blocks agents }" * (name in blocking)
        for name in kinds
    )
    game = f"""sj 1
game x "X" {{
  episode 4
  {declared}
  map {{ "lLphcftx" }}
  agents 1 {{ acts stay }}
  phase start {{ each agent {{ send agent to land }} }}
  schedule rest
  phase rest {{ }}
}}
""".replace('kind lake "l"', 'kind lake "L"')
    looks = {kind.name: kind for kind in make_look(build(Source("x.sj", game)).game).kinds}
    bodies = {
        name: look.body.sprite if look.body is not None else "" for name, look in looks.items()
    }
    assert bodies == {
        "land": "",
        "lake": "water",
        "pond": "water",
        "hedge": "bush",
        "cliff": "ore",
        "fence": "wall",
        "path": "",
        "x": "block",
    }
    assert len({look.ground for look in looks.values()}) == len(kinds)
