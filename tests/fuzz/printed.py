"""A program laid out by the formatter: the same tree, the same rules, and nothing left to do the second time."""

from sjdsl.compiler import build, ir, print_ast, print_ir
from sjdsl.compiler.parse import parse
from sjdsl.compiler.source import Source
from sjdsl.format import format_source
from tests.fuzz.programs import Program


def changed_by_layout(program: Program, source: Source, game: ir.Game) -> str:
    """Returns what the formatter changes; empty if nothing but the layout. `source`: of the program; `game`: what it is compiled to."""
    for name, text in {"game.sj": program.text, **program.files}.items():
        if not name.endswith(".sj"):
            continue
        once = format_source(Source(name, text))
        if format_source(Source(name, once)) != once:
            return f"format: {name} is laid out differently the second time"
        if tree(once) != tree(text):
            return f"format: {name} is another tree"
    again = build(Source(source.name, format_source(source), source.folder)).game
    if print_ir.game(again, positions=False) != print_ir.game(game, positions=False):
        return "format: the text laid out has other rules"
    return ""


def tree(text: str) -> list[str]:
    """Returns the tree of a text, without positions."""
    return list(print_ast.lines(parse(Source("game.sj", text))))
