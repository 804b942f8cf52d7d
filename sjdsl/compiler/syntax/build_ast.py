"""Builds the AST from the parser's tree: a table from grammar rule to class or small function.

Assumes the tree of a text without syntax errors, no deeper than `limits.MAX_TREE`; adds and changes no meaning.
"""

from typing import Any

from lark import Token, Tree

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span
from sjdsl.compiler.syntax import node_builders


def build_ast(tree: Tree[Token], file: str) -> ast.File:
    """Returns the file as `ast` nodes; spans name `file`."""
    node = _build(tree, file)
    assert isinstance(node, ast.File)
    return node


def _build(tree: Tree[Token], file: str) -> Any:
    items = [_build(c, file) if isinstance(c, Tree) else _token(c, file) for c in tree.children if c is not None]
    if tree.data == "names":
        return node_builders.Part("names", tuple(items))
    if tree.data in CLAUSES:
        return node_builders.Part(tree.data, items[0] if items else None)
    span = Span(file, tree.meta.start_pos, tree.meta.end_pos, tree.meta.line, tree.meta.column)
    return RULES[tree.data](span, *items)


def _token(token: Token, file: str) -> ast.Name | ast.String | str:
    span = Span(file, token.start_pos or 0, token.end_pos or 0, token.line or 0, token.column or 0)
    match token.type:
        case "STRING":
            return ast.String(span, node_builders.unquote(token))
        case kind if kind in AS_WRITTEN:
            return str(token)
        case _:
            return ast.Name(span, str(token))


AS_WRITTEN = frozenset(("INT", "DEC", "CMP", "SIGN", "TIMES", "DOTS", "OTHERWISE"))  # kinds of tokens that become plain texts

CLAUSES = {
    "title", "extends", "by", "capped", "set_of", "nearest", "amount", "gainer", "after", "facing", "stay",
    "bind", "inside", "where", "seek", "hidden_on", "body", "badge", "avoiding", "if_none", "by_lot", "wraps",
}  # fmt: skip

RULES: dict[str, node_builders.Build] = {
    "start": lambda span, version, game: ast.File(span, int(version.split(".")[0]), game),
    "game": node_builders.game,
    "cite": ast.Cite,
    "about": node_builders.several(ast.About, 1),
    "variant": node_builders.variant,
    "override": ast.Override,
    "drop": ast.Drop,
    "size": node_builders.size,
    "param": node_builders.param,
    "constant": node_builders.constant,
    "limits": node_builders.all_of,
    "unit": node_builders.only,
    "table": node_builders.several(ast.Table),
    "entry": node_builders.entry,
    "episode": ast.Episode,
    "kind": node_builders.several(ast.Kind, 2),
    "glyph": node_builders.glyph,
    "blocks": node_builders.blocks,
    "blocked": node_builders.only,
    "field": node_builders.with_clauses(ast.Field, "by"),
    "timer": ast.Timer,
    "range": node_builders.range_,
    "agent_type": node_builders.agent_type,
    "numbers": ast.Numbers,
    "cell_type": ast.CellType,
    "words": node_builders.several(ast.Words),
    "group": node_builders.several(ast.Group, 1),
    "map": node_builders.map_,
    "rows": node_builders.all_of,
    "agents": node_builders.agents,
    "movers": node_builders.several(ast.Movers, 3),
    "acts": node_builders.several(ast.Acts),
    "action": node_builders.several(ast.Action, 1),
    "argument": node_builders.argument,
    "chosen": node_builders.chosen,
    "moves": ast.Moves,
    "forbid": node_builders.forbid,
    "all": lambda span: ast.All(span, None),
    "shape": node_builders.shape,
    "define": node_builders.with_clauses(ast.Define, parameters="names"),
    "schedule": node_builders.several(ast.Schedule),
    "turn": node_builders.several(ast.Turn, 1),
    "phase": node_builders.with_clauses(ast.Phase, parameters="names"),
    "block": node_builders.several(ast.Block),
    "let": ast.Let,
    "draw": node_builders.optional(ast.Draw, 3),
    "each": ast.Each,
    "pick": node_builders.optional(ast.Pick, 4),
    "first": node_builders.optional(ast.First, 3),
    "match": node_builders.match_,
    "when": node_builders.optional(ast.When, 3),
    "chance": node_builders.optional(ast.Chance, 3),
    "otherwise": node_builders.only,
    "set": node_builders.with_clauses(ast.Set, lot="by_lot"),
    "add": ast.Add,
    "give": ast.Give,
    "all_but": ast.All,
    "tally": node_builders.with_clauses(ast.Tally, by="amount", receiver="gainer"),
    "send": node_builders.with_clauses(ast.Send, "after", "facing", "stay"),
    "held_cell": node_builders.several(ast.Path, 1),
    "shift": node_builders.with_clauses(ast.Shift, "facing", "stay"),
    "direction": lambda span, path: ast.Direction(span, "along", path),
    "away": lambda span, path: ast.Direction(span, "away", path),
    "toward": lambda span, path: ast.Direction(span, "toward", path),
    "remove": ast.Remove,
    "move": node_builders.optional(ast.Move, 2),
    "nearer": node_builders.with_clauses(ast.Toward, avoided="avoiding"),
    "farther": node_builders.with_clauses(ast.AwayFrom, avoided="avoiding"),
    "at_random": node_builders.with_clauses(ast.AtRandom, avoided="avoiding"),
    "ahead": ast.Ahead,
    "along": ast.Along,
    "mark": node_builders.mark,
    "end": ast.End,
    "domain": node_builders.with_clauses(ast.Domain, "bind", "where", restriction="inside"),
    "on": node_builders.with_clauses(ast.On, "bind"),
    "near": node_builders.near,
    "shape_name": node_builders.shape_name,
    "members": node_builders.several(ast.Members),
    "observe": node_builders.several(ast.Observe),
    "window": node_builders.window,
    "show": node_builders.show,
    "relabel": node_builders.with_clauses(ast.Relabel, "where"),
    "look": node_builders.with_clauses(ast.Look, "where", "body", "badge"),
    "paint": node_builders.several(ast.Paint),
    "hide": node_builders.with_clauses(ast.Hide, on="hidden_on"),
    "metrics": node_builders.several(ast.Metrics),
    "event": node_builders.with_clauses(ast.Event, "by"),
    "mean": lambda span, name, value: ast.Measure(span, True, name, value),
    "final": lambda span, name, value: ast.Measure(span, False, name, value),
    "checks": node_builders.checks,
    "require": ast.Require,
    "always": ast.Always,
    "once": ast.Once,
    "conserved": ast.Conserved,
    "monotone": ast.Monotone,
    "symmetric": node_builders.symmetric,
    "expect": node_builders.expect,
    "policy": node_builders.policy,
    "scripted": node_builders.scripted,
    "act": ast.Act,
    "go": node_builders.with_clauses(ast.Go, avoided="avoiding"),
    "aim": node_builders.aim,
    "scenario": node_builders.scenario,
    "slots": node_builders.optional(ast.Slots, 2),
    "expr": node_builders.binary("or"),
    "and_e": node_builders.binary("and"),
    "negate": node_builders.negate,
    "compare": node_builders.compare,
    "is_": node_builders.binary("is"),
    "is_not": node_builders.binary("is not"),
    "chose": ast.Chose,
    "standing": ast.Standing,
    "within": node_builders.optional(ast.Within, 3),
    "sum": node_builders.chain,
    "prod": node_builders.chain,
    "signed": ast.Unary,
    "int": node_builders.int_,
    "dec": node_builders.dec,
    "nobody": ast.Nobody,
    "count": ast.Count,
    "some": lambda span, domain: ast.Quantified(span, "any", domain),
    "every": lambda span, domain: ast.Quantified(span, "all", domain),
    "total": node_builders.optional(ast.Total, 2),
    "extreme": node_builders.with_clauses(ast.Extreme, "if_none"),
    "case": node_builders.several(ast.Case, 1),
    "arm": node_builders.arm,
    "key": node_builders.all_of,
    "call": node_builders.several(ast.Call, 1),
    "path": node_builders.several(ast.Path, 1),
    "member": ast.Member,
    "index": ast.Index,
}
