"""Builds the AST of a text from the grammar's own tree.

Tree -> ast.File
"""

from typing import Any

from lark import Token, Tree

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.errors import TooDeep
from sjdsl.compiler.diagnostics.limits import (
    CHAINS,
    MAX_STATEMENTS,
    MAX_TREE,
    STATEMENTS,
    too_much,
)
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.rules import AS_WRITTEN, RULES, unquote


def build_file(root: Tree[Token], source: Source) -> ast.File:
    """Returns the file that a tree is.

    Raises:
      CompileError: it is nested too deeply, or has too many statements.
    """
    values: dict[int, Any] = {}  # by the identity of a tree: nodes, or parts of the nodes around
    heights: dict[int, int] = {}
    statements = 0
    for tree in _inner_first(root):
        below = (heights[id(child)] for child in tree.children if isinstance(child, Tree))
        height = max(below, default=0) + _levels(tree)
        statements += tree.data in STATEMENTS
        if height > MAX_TREE:
            raise CompileError([TooDeep(_start(tree, source), limit=MAX_TREE)])
        if statements > MAX_STATEMENTS:
            problem = "the file has more statements"
            raise CompileError([too_much(problem, MAX_STATEMENTS, _start(tree, source))])
        children = [
            values[id(child)] if isinstance(child, Tree) else _leaf(child, source)
            for child in tree.children
        ]
        heights[id(tree)] = height
        values[id(tree)] = _node(tree, children, source)
    file: ast.File = values[id(root)]
    return file


def _inner_first(root: Tree[Token]) -> list[Tree[Token]]:
    """Returns a tree and all trees in it, each after those in it, from left to right.

    It may be too deep for recursion.
    """
    outer_first = []
    waiting = [root]
    while waiting:
        tree = waiting.pop()
        outer_first.append(tree)
        waiting += [child for child in tree.children if isinstance(child, Tree)]
    return outer_first[::-1]


def _levels(tree: Tree[Token]) -> int:
    """Returns how many levels a tree adds to the AST: a chain adds one for each operator."""
    if tree.data not in CHAINS:
        return 1
    operators = sum(isinstance(child, Token) for child in tree.children)
    return operators or len(tree.children) - 1  # `and` and `or` leave no token


def _node(tree: Tree[Token], children: list[Any], source: Source) -> Any:
    """Returns the node of a tree, or the content of a clause: True if it has none."""
    name = str(tree.data)
    if name in RULES:
        meta = tree.meta
        span = Span(source.name, meta.start_pos, meta.end_pos, meta.line, meta.column)
        return RULES[name](span, *children)
    return children[0] if children else True


def _leaf(token: Token | None, source: Source) -> ast.Name | ast.String | str | None:
    """Returns the part of a node that a token is: a text, a name, or the token as written.

    None for an optional part that isn't there.
    """
    if token is None:
        return None
    text = str(token)
    if token.type in AS_WRITTEN:
        return text
    span = Span(
        source.name, token.start_pos or 0, token.end_pos or 0, token.line or 0, token.column or 0
    )
    return ast.String(span, unquote(text)) if token.type == "STRING" else ast.Name(span, text)


def _start(tree: Tree[Token], source: Source) -> Span:
    """Returns the empty span where a tree begins."""
    return source.span(tree.meta.start_pos, tree.meta.start_pos)
