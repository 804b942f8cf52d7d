"""Every construct of the language is used by a bundled game."""

import dataclasses
from collections.abc import Iterator

import pytest

from sjdsl.compiler import ast, build, ir
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.tree import walk
from sjdsl.compiler.syntax.parse import parse
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import bundled, find_game, games_folder

FOLDED = {ir.Truth}  # what phases with parameters leave of a comparison of two words
WANTED = {
    *("agents block", "lot", "set of more than 32", "shown when", "value shown", "window when"),
    *(
        "draw of numbers",
        "draw of reals",
        "row by number",
        "row by agent",
        "event by agent",
        "param by number",
        "param by agent",
    ),
    *(
        "a cell is held",
        "nowhere",
        "ahead",
        "along",
        "at random",
        "toward",
        "away from",
        "avoiding",
    ),
}


def uses(game: ir.Game) -> Iterator[str]:
    """Yields what a game uses that no class of nodes tells."""
    for node in ir.walk(game):
        match node:
            case ir.Agents(blocks=(_, *_)):
                yield "agents block"
            case ir.Set(lot=int()):
                yield "lot"
            case ir.VarField(type=type_):
                yield from ("a cell is held" for _ in [0] if type_.kind == "cell")
                yield from (
                    "set of more than 32"
                    for _ in [0]
                    if type_.kind == "agents" and game.agents.number > 32
                )
                yield from (f"row by {level.sort}" for level in type_.by)
            case ir.Param(type=type_):
                yield from (f"param by {level.sort}" for level in type_.by)
            case ir.Event(by=ir.Level() as by):
                yield f"event by {by.sort}"
            case ir.Observable():
                yield from (
                    what
                    for what, said in (("shown when", node.shown_when), ("value shown", node.value))
                    if said is not None
                )
            case ir.Window(views=(_, *_)):
                yield "window when"
            case ir.Draw():
                yield from (
                    f"draw of {what}"
                    for what, is_so in (
                        ("numbers", node.numbers),
                        ("reals", node.type.kind == "real"),
                    )
                    if is_so
                )
            case ir.Nowhere():
                yield "nowhere"
            case ir.Along():
                yield (
                    "ahead"
                    if isinstance(node.heading, ir.FieldRead)
                    and node.heading.held_by.what == "mover"
                    else "along"
                )
            case ir.Wander():
                yield "at random" if node.goal is None else "away from" if node.away else "toward"
                yield from ("avoiding" for _ in [0] if node.avoided is not None)
            case _:
                pass


def test_every_form_of_text_is_in_a_game() -> None:
    found = {
        type(node)
        for path in games_folder().rglob("*.sj")
        for node in walk(parse(read_source(path)))
    }
    assert {kind for kind in vars(ast).values() if dataclasses.is_dataclass(kind)} - found == {
        ast.Node,
        ast.Named,
    }


@pytest.mark.thorough
def test_every_rule_is_in_a_game() -> None:
    sources = [read_source(find_game(name)) for name in bundled()]
    games = [
        build(source, variant).game
        for source in sources
        for variant in ((), *((name,) for name in compose(source).variants))
    ]
    kinds = {
        kind
        for kind in vars(ir).values()
        if isinstance(kind, type) and issubclass(kind, ir.Node) and not kind.__subclasses__()
    }
    assert kinds - {type(node) for game in games for node in ir.walk(game)} == FOLDED
    assert WANTED - {use for game in games for use in uses(game)} == set()
