"""Turns the parser's tree into `ast` nodes: a table from grammar rule to class or small function.

Assumes the tree of a text without syntax errors, no deeper than `limits.MAX_TREE`; adds and changes no meaning.
"""

from typing import Any

from lark import Token, Tree

from sjdsl.compiler import ast, nodes
from sjdsl.compiler.source import Span


def build_ast(tree: Tree[Token], file: str) -> ast.File:
    """Returns the file as `ast` nodes; spans name `file`."""
    node = _build(tree, file)
    assert isinstance(node, ast.File)
    return node


def _build(tree: Tree[Token], file: str) -> Any:
    items = [_build(c, file) if isinstance(c, Tree) else _token(c, file) for c in tree.children if c is not None]
    if tree.data == "names":
        return nodes.Part("names", tuple(items))
    if tree.data in CLAUSES:
        return nodes.Part(tree.data, items[0] if items else None)
    span = Span(file, tree.meta.start_pos, tree.meta.end_pos, tree.meta.line, tree.meta.column)
    return RULES[tree.data](span, *items)


def _token(token: Token, file: str) -> ast.Name | ast.String | str:
    span = Span(file, token.start_pos or 0, token.end_pos or 0, token.line or 0, token.column or 0)
    match token.type:
        case "STRING":
            return ast.String(span, nodes.unquote(token))
        case "INT" | "DEC" | "CMP" | "SIGN" | "TIMES" | "DOTS" | "OTHERWISE":
            return str(token)
        case _:
            return ast.Name(span, str(token))


CLAUSES = {
    "title", "extends", "by", "capped", "set_of", "nearest", "amount", "gainer", "after", "facing", "stay",
    "bind", "inside", "where", "seek", "hidden_on", "body", "badge",
}  # fmt: skip

RULES: dict[str, nodes.Build] = {
    "start": lambda span, version, game: ast.File(span, int(version), game),
    "game": nodes.game,
    "cite": ast.Cite,
    "about": nodes.several(ast.About, 1),
    "variant": nodes.variant,
    "override": ast.Override,
    "drop": ast.Drop,
    "size": nodes.size,
    "param": nodes.param,
    "constant": nodes.constant,
    "limits": nodes.all_of,
    "unit": nodes.only,
    "table": nodes.several(ast.Table),
    "entry": ast.Entry,
    "episode": ast.Episode,
    "kind": nodes.several(ast.Kind, 2),
    "glyph": nodes.glyph,
    "blocks": nodes.blocks,
    "blocked": nodes.only,
    "field": nodes.field,
    "timer": ast.Timer,
    "range": nodes.range_,
    "agent_type": nodes.agent_type,
    "words": nodes.several(ast.Words),
    "group": nodes.several(ast.Group, 1),
    "map": nodes.map_,
    "rows": nodes.all_of,
    "agents": nodes.agents,
    "acts": nodes.several(ast.Acts),
    "moves": ast.Moves,
    "forbid": nodes.forbid,
    "all": lambda span: ast.All(span, None),
    "shape": nodes.shape,
    "define": nodes.define,
    "schedule": nodes.several(ast.Schedule),
    "turn": nodes.several(ast.Turn, 1),
    "phase": nodes.phase,
    "block": nodes.several(ast.Block),
    "let": ast.Let,
    "draw": nodes.optional(ast.Draw, 3),
    "each": ast.Each,
    "pick": nodes.optional(ast.Pick, 4),
    "first": nodes.optional(ast.First, 3),
    "match": nodes.match_,
    "when": nodes.optional(ast.When, 3),
    "chance": nodes.optional(ast.Chance, 3),
    "otherwise": nodes.only,
    "set": ast.Set,
    "add": ast.Add,
    "give": ast.Give,
    "all_but": ast.All,
    "tally": nodes.tally,
    "send": nodes.send,
    "remove": ast.Remove,
    "move": ast.Move,
    "mark": nodes.mark,
    "end": ast.End,
    "domain": nodes.domain,
    "on": nodes.on,
    "near": nodes.near,
    "shape_name": nodes.shape_name,
    "members": nodes.several(ast.Members),
    "observe": nodes.several(ast.Observe),
    "window": nodes.window,
    "show": nodes.several(ast.Show, 1),
    "relabel": nodes.relabel,
    "look": nodes.look,
    "paint": nodes.several(ast.Paint),
    "hide": nodes.hide,
    "metrics": nodes.several(ast.Metrics),
    "event": nodes.event,
    "mean": lambda span, name, value: ast.Measure(span, True, name, value),
    "final": lambda span, name, value: ast.Measure(span, False, name, value),
    "checks": nodes.checks,
    "require": ast.Require,
    "always": ast.Always,
    "once": ast.Once,
    "conserved": ast.Conserved,
    "monotone": ast.Monotone,
    "symmetric": nodes.symmetric,
    "expect": nodes.expect,
    "policy": nodes.policy,
    "expr": nodes.binary("or"),
    "and_e": nodes.binary("and"),
    "negate": nodes.negate,
    "compare": nodes.compare,
    "is_": nodes.binary("is"),
    "is_not": nodes.binary("is not"),
    "chose": ast.Chose,
    "standing": ast.Standing,
    "within": nodes.optional(ast.Within, 3),
    "sum": nodes.chain,
    "prod": nodes.chain,
    "signed": ast.Unary,
    "int": nodes.int_,
    "dec": nodes.dec,
    "nobody": ast.Nobody,
    "count": ast.Count,
    "total": nodes.optional(ast.Total, 2),
    "case": nodes.several(ast.Case, 1),
    "arm": nodes.arm,
    "key": nodes.all_of,
    "call": nodes.several(ast.Call, 1),
    "path": nodes.several(ast.Path, 1),
    "member": ast.Member,
    "index": ast.Index,
}
