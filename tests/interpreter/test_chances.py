"""Every kind of statement that draws, with the words written down by hand."""

import pytest

from sjdsl.compiler import ir
from sjdsl.interpreter.threefry import Recorded

from . import games as g
from .statement_games import COLOUR, RG, SMALL, SOIL_FRUIT, SOIL_HITS, add, run, score, set_, small

CHAIN = ir.Chance(
    branches=(
        ir.Branch(test=ir.Number(type=g.REAL, value=0.5), body=(set_(score(), g.number(1)),)),
        ir.Branch(test=ir.Number(type=g.REAL, value=0.5), body=(set_(score(), g.number(2)),)),
    ),
    otherwise=(set_(score(), g.number(3)),),
    stream=5,
)


@pytest.mark.parametrize(
    ("word", "branch"),
    [
        (0, 1),
        (0x7FFFFFFF, 1),
        (0x80000000, 2),
        (0xBFFFFFFF, 2),
        (0xC0000000, 3),
        (g.LAST, 3),
    ],
)
def test_a_chain_of_chances_uses_one_word(word, branch):
    game = small(g.each(g.agents(), CHAIN))
    world, _ = run(game, draws=g.Table({(5, 1): word}))
    assert world.agents["score"] == [1, branch]


@pytest.mark.parametrize(("share", "expected"), [(0.0, "none"), (1.0, "red")])
def test_chances_of_nought_and_one_are_certain(share, expected):
    chance = ir.Chance(
        branches=(
            ir.Branch(
                test=ir.Number(type=g.REAL, value=share), body=(set_(SOIL_FRUIT, g.word("red")),)
            ),
        ),
        stream=5,
    )
    game = small(g.each(g.cells("soil"), chance))
    for word in (0, g.LAST):
        assert run(game, draws=g.Table(rest=word))[0].cells["soil", "fruit"] == [expected] * 3


def test_instance_numbers_are_mixed_radix_outermost_first():
    chance = ir.Chance(branches=(), stream=5)
    draws = Recorded(g.Table())
    game = small(g.each(g.cells("soil"), g.each(g.agents(where=g.is_agent(1)), chance)), chance)
    run(game, draws=draws)
    assert [(u.stream, u.number) for u in draws.used if u.stream == 5] == [
        (5, 1),
        (5, 3),
        (5, 5),
        (5, 0),
    ]


@pytest.mark.parametrize(
    ("word", "number"), [(0, 2), (0x55555555, 2), (0x55555556, 3), (0xAAAAAAAB, 4), (g.LAST, 4)]
)
def test_draw_from_a_range(word, number):
    draw = ir.Draw(name="n", type=g.INT, low=g.number(2), high=g.number(4), stream=6)
    game = small(g.each(g.agents(), draw, set_(score(), ir.Local(type=g.INT, name="n"))))
    assert run(game, draws=g.Table({(6, 1): word}))[0].agents["score"] == [2, number]


@pytest.mark.parametrize(("weights", "last_of_red"), [((), 0x7FFFFFFF), ((0.25, 0.75), 0x3FFFFFFF)])
def test_draw_of_a_word(weights, last_of_red):
    """All words of one range give the first; it is as large as the weight, or half."""
    given = tuple(ir.Number(type=g.REAL, value=weight) for weight in weights)
    draw = ir.Draw(name="w", type=COLOUR, words=RG, weights=given, stream=6)
    set_colour = set_(g.of_agent("colour", COLOUR), ir.Local(type=COLOUR, name="w"))
    game = small(draw, g.each(g.agents(), set_colour))
    for word, drawn in (
        (0, "red"),
        (last_of_red, "red"),
        (last_of_red + 1, "green"),
        (g.LAST, "green"),
    ):
        assert run(game, draws=g.Table({(6, 0): word}))[0].agents["colour"] == [drawn] * 2


def pick(n, domain, *body, otherwise=()):
    return ir.Pick(
        number=g.number(n), most=n, domain=domain, body=body, otherwise=otherwise, stream=7
    )


def test_pick_takes_one_of_those_left_in_each_turn():
    game = small(pick(2, g.cells("soil"), set_(SOIL_FRUIT, g.word("red"))))
    fruit = run(game, draws=g.Table({(7, 0): g.turn(1, 3), (7, 1): g.turn(1, 2)}))[0].cells[
        "soil", "fruit"
    ]
    assert fruit == ["none", "red", "red"]
    fruit = run(game, draws=g.Table({(7, 0): g.turn(1, 3) - 1, (7, 1): g.turn(1, 2)}))[0].cells[
        "soil", "fruit"
    ]
    assert fruit == ["red", "none", "red"]


def test_pick_takes_all_if_there_are_fewer_and_otherwise_only_if_there_is_none():
    red, rounds = set_(SOIL_FRUIT, g.word("red")), set_(g.of_world("rounds", SMALL), g.number(1))
    many = small(pick(9, g.cells("soil"), red, otherwise=(rounds,)))
    none_wanted = small(pick(0, g.cells("soil"), red, otherwise=(rounds,)))
    nobody = small(pick(1, g.cells("soil", where=ir.Truth(value=False)), red, otherwise=(rounds,)))
    results = [run(game)[0] for game in (many, none_wanted, nobody)]
    assert [w.cells["soil", "fruit"].count("red") for w in results] == [3, 0, 0]
    assert [w.fields["rounds"] for w in results] == [0, 0, 1]


def test_a_pick_inside_another_quantifier_has_words_of_its_own_and_so_has_what_it_holds():
    inner = ir.Chance(
        branches=(ir.Branch(test=ir.Number(type=g.REAL, value=1.0), body=()),), stream=8
    )
    game = small(g.each(g.agents(), pick(1, g.cells("soil"), inner)))
    draws = Recorded(g.Table({(7, 0): g.turn(1, 3), (7, 1): g.turn(2, 3)}))
    run(game, draws=draws)
    assert sorted(u.number for u in draws.used if u.stream == 7) == [0, 1]
    assert [u.number for u in draws.used if u.stream == 8] == [1, 5]


def test_first_happens_once_for_each_lane():
    friend = g.agents("friend", restriction=g.near("ray", g.agent()))
    chance = ir.Chance(branches=(), stream=8)
    game = small(
        g.each(
            g.agents(),
            ir.First(
                domain=friend,
                body=(add(score("friend"), g.number(1)), chance),
            ),
        ),
        rows=("....",),
        agents=3,
    )
    draws = Recorded(g.Table())
    world, _ = run(game, (0, 0), (0, 1), (0, 2), headings=(1, 1, 1), draws=draws)
    assert world.agents["score"] == [0, 1, 1]
    assert [u.number for u in draws.used if u.stream == 8] == [0, 1]


# words of ranks by left and right agent, and each left agent's partner; nobody is paired with itself
MATCHES = [
    ({(1, 2): 100, (2, 0): 90, (3, 0): 80, (0, 3): 70}, [None, 2, None, 0]),  # greedily
    ({(0, 0): g.LAST}, [1, None, 3, None]),  # ties by number
]


@pytest.mark.parametrize(("words", "partners"), MATCHES)
def test_match_takes_pairs_in_random_order(words, partners):
    body = (set_(g.of_agent("friend", ir.AGENT, g.agent("a")), g.agent("b")),)
    match = ir.Match(left=g.agents("a"), right=g.agents("b"), first=False, stream=9, body=body)
    table = g.Table({(9, left * 4 + right): word for (left, right), word in words.items()})
    assert run(small(match, agents=4), draws=table)[0].agents["friend"] == partners


def test_match_with_first_pairs_only_the_nearest():
    right = g.agents("b", restriction=g.near("ray", g.agent("a")))
    body = (set_(g.of_agent("friend", ir.AGENT, g.agent("a")), g.agent("b")),)
    for first, words, expected in (
        (True, {(9, 2): g.LAST, (9, 5): 8}, [None, 2, None]),
        (False, {(9, 2): g.LAST, (9, 5): 8}, [2, None, None]),
    ):
        game = small(
            ir.Match(left=g.agents("a"), right=right, first=first, stream=9, body=body),
            rows=("...",),
            agents=3,
        )
        world, _ = run(game, (0, 0), (0, 1), (0, 2), headings=(1, 1, 1), draws=g.Table(words))
        assert world.agents["friend"] == expected


def test_a_draw_in_a_match_is_numbered_by_the_left_member():
    body = (ir.Chance(branches=(), stream=8),)
    game = small(
        ir.Match(
            left=g.agents("a", where=g.is_agent(2, "a")),
            right=g.cells("soil"),
            first=False,
            stream=9,
            body=body,
        ),
        agents=3,
    )
    draws = Recorded(g.Table())
    run(game, draws=draws)
    assert [u.number for u in draws.used if u.stream == 9] == [6, 7, 8]
    assert [u.number for u in draws.used if u.stream == 8] == [2]


def test_an_agent_is_matched_with_one_cell_only():
    body = (add(SOIL_HITS, g.plus(g.index("a"), g.number(1))),)
    game = small(
        ir.Match(left=g.agents("a"), right=g.cells("soil"), first=False, stream=9, body=body)
    )
    world, _ = run(game, draws=g.Table({(9, 1): 50, (9, 4): 40, (9, 5): 30}))
    assert world.cells["soil", "hits"] == [0, 1, 2]
