"""What a step tells of itself: every write with its statement, its instance and the draws that led to it."""

from sjdsl.compiler import ir
from sjdsl.interpreter.account import Account
from sjdsl.interpreter.board import board_of
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.step import reset, step

from . import games as g
from .statement_games import SOIL_FRUIT, score, set_, small

QUARTER = ir.Number(type=g.REAL, value=0.25)
GROW = ir.Chance(
    branches=(ir.Branch(test=QUARTER, body=(set_(SOIL_FRUIT, g.word("red")),)),), stream=5
)
FIRES, FAILS = 0x3FFFFFFF, 0x40000000  # the word's upper 31 bits against a quarter of 2^31


def told(game: ir.Game, words: dict) -> list[Account]:
    accounts: list[Account] = []
    params = default_params(game)
    world = reset(game, params, g.Table())
    step(
        game, world, [0] * game.agents.number, params, g.Table(words, rest=g.LAST), accounts.append
    )
    return accounts


def test_a_write_comes_with_its_instance_and_its_draws():
    game = small(g.each(g.cells("soil"), GROW))
    (account,) = told(game, {(5, 0): FAILS, (5, 2): FIRES})
    assert [d.result for d in account.drawn] == [None, None, 0]
    assert account.drawn[0].bounds == (2**29,)
    (done,) = account.done
    assert isinstance(done.statement, ir.Set)
    assert done.causes == (account.drawn[2],)
    (written,) = done.written["sets"]
    assert written[0].owner == ("soil", 2)
    assert done.names["soil"] == board_of(game).cells["soil"][2]
    assert account.before.cells["soil", "fruit"] == ["none"] * 3
    assert account.after.cells["soil", "fruit"] == ["none", "none", "red"]


def test_picks_tell_who_was_picked():
    pick = ir.Pick(
        number=g.number(1), most=1, domain=g.agents(), body=(set_(score(), g.number(7)),), stream=9
    )
    (account,) = told(small(pick), {(9, 0): g.LAST})
    assert [(d.bits, d.result) for d in account.drawn] == [(g.LAST, True)]
    (done,) = account.done
    assert done.names["agent"] == 1
    assert done.causes == account.drawn[:1]


def test_what_a_draw_gives_holds_for_the_statements_after_it():
    draw = ir.Draw(name="n", type=g.INT, low=g.number(3), high=g.number(6), stream=4)
    before, after = set_(score(), g.number(1)), set_(score("other"), g.number(2))
    game = small(
        g.each(g.agents(where=g.is_agent(0)), before),
        g.each(g.agents("other", where=g.is_agent(1, "other")), draw, after),
    )
    (account,) = told(game, {})
    assert [len(d.causes) for d in account.done] == [0, 1]
    assert account.done[1].causes[0].result == 6


def test_nothing_is_kept_where_no_account_is_wanted():
    game = small(g.each(g.cells("soil"), GROW))
    params, words = default_params(game), g.Table({(5, 1): FIRES}, rest=g.LAST)
    world = reset(game, params, g.Table())
    plain, _ = step(game, world, [0, 0], params, words)
    assert told(game, {(5, 1): FIRES})[0].after.cells == plain.cells
