"""How much of the language programs use: the alternatives of the grammar, and what their typed rules are made of."""

from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin

from lark import Lark, Token

import sjdsl.grammar
from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import read_tree
from tests.fuzz.programs import Program

SIGNS = ("CMP", "SIGN", "TIMES")  # terminals that are several signs
ABSTRACT = (
    "Expression",
    "Statement",
    "RestrictionNode",
    "TurnNode",
    "PolicyRuleNode",
    "CourseNode",
)


class Grammar:
    """The parser of the language, which notes each alternative by which a text is read."""

    def __init__(self) -> None:
        text = Path(sjdsl.grammar.__path__[0], "sj.lark").read_text("utf-8")
        self.parser = Lark(text, parser="lalr", lexer="basic", strict=True)
        self.used: Counter[str] = Counter()
        inner = self.parser.parser.parser.parser  # type: ignore[union-attr]
        inner.callbacks = {
            rule: self._noting(rule, callback) for rule, callback in inner.callbacks.items()
        }
        rules = {
            _written(rule) for rule in self.parser.rules if not rule.origin.name.startswith("_")
        }
        signs = {
            f"{t.name} {sign}"
            for t in self.parser.terminals
            if t.name in SIGNS
            for sign in _signs(t.pattern.value)
        }
        self.alternatives = tuple(sorted(rules | signs))

    def read(self, program: Program) -> None:
        """Adds what a program uses."""
        for name, text in {"program.sj": program.text, **program.files}.items():
            if not name.endswith(".txt"):
                self.read_text(Source(name, text))

    def read_text(self, source: Source) -> list[Token]:
        """Adds what a text uses, and returns its tokens."""
        reader, (tokens, _) = self.parser.parse_interactive(""), read_tree(source)
        for token in tokens:
            reader.feed_token(token)
        reader.feed_eof(tokens[-1])
        self.used.update(f"{t.type} {t}" for t in tokens if t.type in SIGNS)
        return tokens

    def missing(self) -> list[str]:
        return [a for a in self.alternatives if not self.used[a]]

    def _noting(self, rule: Any, callback: Any) -> Any:
        def noted(children: list[Any]) -> Any:
            self.used[_written(rule)] += 1
            return callback(children)

        return noted


def _written(rule: Any) -> str:
    """Returns an alternative as `rule: its parts`."""
    return f"{rule.alias or rule.origin.name}: {' '.join(symbol.name for symbol in rule.expansion)}"


def _signs(pattern: str) -> list[str]:
    """Returns the signs of a terminal that is a choice of them: `(?:\\<=|\\<)`."""
    inner = pattern.removeprefix("(?:").removesuffix(")")
    return [sign.replace("\\", "") for sign in inner.split("|")]


@cache
def rule_parts() -> tuple[str, ...]:
    """Returns what typed rules can be made of: every node, and every value of a field that has few."""
    return tuple(
        sorted(
            {f"{kind.__name__}{part}" for kind in _kinds(ir.Node) for part in ("", *_choices(kind))}
        )
    )


def rule_parts_used(game: ir.Game) -> Counter[str]:
    """Returns how often each of them occurs in a game."""
    used: Counter[str] = Counter()
    for node in ir.walk(game):
        name = type(node).__name__
        used[name] += 1
        used.update(
            f"{name}.{field}{_value(getattr(node, field))}" for field in _fields(type(node))
        )
    return used


def _kinds(kind: type[ir.Node]) -> Iterator[type[ir.Node]]:
    for inner in kind.__subclasses__():
        if inner.__name__ not in ABSTRACT:
            yield inner
        yield from _kinds(inner)


@cache
def _fields(kind: type[ir.Node]) -> tuple[str, ...]:
    return tuple(
        name
        for name, field in kind.model_fields.items()
        if name != "origin" and [*_values(field.annotation)]
    )


def _choices(kind: type[ir.Node]) -> list[str]:
    return [
        f".{name}{value}"
        for name in _fields(kind)
        for value in _values(kind.model_fields[name].annotation)
    ]


def _values(annotation: Any) -> Iterator[str]:
    """Yields the values told apart: words, yes and no, nothing or something, no members or some."""
    parts = get_args(annotation)
    if get_origin(annotation) is Literal:
        yield from (f" = {value}" for value in parts)
    elif annotation is bool:
        yield from (" = True", " = False")
    elif get_origin(annotation) in (Union, UnionType) and type(None) in parts:
        yield from (" is None", " is given")
    elif get_origin(annotation) is tuple and Ellipsis in parts:
        yield from (" is empty", " has some")


def _value(value: Any) -> str:
    if value is None:
        return " is None"
    if isinstance(value, str | bool):
        return f" = {value}"
    if isinstance(value, tuple):
        return " has some" if value else " is empty"
    return " is given"


def table(grammar: Grammar, parts: Counter[str]) -> list[str]:
    """Returns both measures as lines: how many of how many, which never, which least often."""
    lines = []
    for title, known, used in (
        ("alternatives of the grammar", grammar.alternatives, grammar.used),
        ("parts of typed rules", rule_parts(), parts),
    ):
        never = [k for k in known if not used[k]]
        rare = sorted((k for k in known if used[k]), key=lambda k: used[k])[:10]
        lines.append(f"{title}: {len(known) - len(never)} of {len(known)}")
        lines += [f"  never       {k}" for k in never]
        lines += [f"  {used[k]:>5} times {k}" for k in rare]
    return lines
