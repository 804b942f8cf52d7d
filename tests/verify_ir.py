"""Verifies invariants of the IR that no node can check alone, after elaboration and after every pass in tests.

Raises AssertionError: a game that fails is a bug of the compiler, never of its author.
"""

from collections import Counter

from sjdsl.compiler import ir
from sjdsl.compiler.ir.operations import CALCULATIONS


def verify(game: ir.Game) -> ir.Game:
    """Returns the game if its parts fit together."""
    names = [
        t.name for t in (game.start, *game.starting, *game.schedule) if isinstance(t, ir.Phase)
    ]
    assert len(set(names)) == len(names), names
    shapes = {s.name for s in (*game.shapes, *game.policy_shapes)}
    kinds = {k.name for k in game.kinds}
    for node in ir.walk(game):
        match node:
            case ir.Near(shape=shape) | ir.Mark(shape=shape) | ir.Aim(shape=shape):
                assert shape in shapes, node
            case ir.Member(entity_type=ir.EntityType(what="cell")):
                assert node.kinds and set(node.kinds) <= kinds, node
            case ir.Word():
                assert node.value in node.type.words, node
            case ir.Chose(action=action) | ir.Act(action=action) | ir.Aim(action=action):
                assert 0 <= action < len(game.agents.actions), node
            case ir.ChoseWith(action=name) | ir.ArgumentOf(action=name):
                assert name in {action.name for action in game.agents.with_arguments}, node
            case ir.Arithmetic():
                row = CALCULATIONS[node.fn]
                assert row.least <= len(node.args) <= row.most, node
            case ir.Case():
                assert node.arms, node
            case _:
                pass
    _check_streams(game)
    glyphs = {g.glyph for g in game.glyphs}
    assert len(glyphs) == len(game.glyphs), game.glyphs
    assert game.rows and all(
        len(row) == len(game.rows[0]) and set(row) <= glyphs for row in game.rows
    ), game.rows
    return game


def _check_streams(game: ir.Game) -> None:
    """Every drawing statement has a stream of its own; sends of one pool share theirs."""
    streams: Counter[int] = Counter()
    for turn in (game.start, *game.starting, *game.schedule):
        pools: set[int] = set()
        for node in ir.walk(turn):
            match node:
                case ir.Draw() | ir.Pick() | ir.Chance() | ir.Match() | ir.Move() | ir.Wander():
                    streams[node.stream] += 1
                case ir.Shift():
                    streams.update(
                        stream
                        for stream in (node.stream, node.heading_stream)
                        if stream is not None
                    )
                case ir.Set(lot=int(stream)):
                    streams[stream] += 1
                case ir.Send() if node.pool not in pools:
                    pools.add(node.pool)
                    streams.update((node.cell_stream, node.heading_stream))
                case _:
                    pass
    assert all(n == 1 for n in streams.values()), streams
