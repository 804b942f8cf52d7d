"""A program laid out by the formatter: the same tree, the same rules, and nothing left to do the second time."""

from sjdsl.compiler import build, ir
from sjdsl.compiler.ast import printer as ast_printer
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.ir import printer as ir_printer
from sjdsl.compiler.syntax.parse import parse
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
    if ir_printer.game_text(again, positions=False) != ir_printer.game_text(game, positions=False):
        return "format: the text laid out has other rules"
    return ""


def tree(text: str) -> list[str]:
    """Returns the tree of a text, without positions."""
    return list(ast_printer.lines(parse(Source("game.sj", text))))
