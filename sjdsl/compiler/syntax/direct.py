"""Reads a text straight to its AST, several times as fast as by way of the grammar's own tree.

Source -> ast.File, or how far it was read, or what is too large about it; None for wrong
characters, numbers and brackets
"""

import re
from bisect import bisect_right
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from lark import Lark

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.errors import TooDeep
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.limits import (
    CHAINS,
    MAX_DEPTH,
    MAX_DIGITS,
    MAX_STATEMENTS,
    MAX_TOKENS,
    MAX_TREE,
    STATEMENTS,
    too_much,
)
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.recovery.automaton import END, Stack
from sjdsl.compiler.syntax.rules import AS_WRITTEN, RULES, Part, unquote
from sjdsl.compiler.syntax.soft_words import SOFT, can_come, names_in_place
from sjdsl.compiler.syntax.tokens import BRACKETS, PREFIX, is_too_large

WRONG = "WRONG"  # the kind of a character that begins no word or sign
EVERY = 64  # words after which the stack is kept
NOTHING = (None, None)  # what the table has for a token that cannot come


class Rule(Record, eq=False):
    """What is done where a rule of the grammar has been read.

    width: how many symbols it has. kept: which of them become children, each with whether its
    value is a list to be taken in. name: of the rule, empty for a list that another rule takes in.
    passes: whether a single child stands for the rule itself.
    """

    width: int
    origin: str
    kept: tuple[tuple[int, bool], ...]
    name: str
    passes: bool
    build: Callable[..., Any] | None


class Tables(Record, eq=False):
    """A grammar as it is run here.

    sign: matches what is between words, and then a word or sign. words: kinds of those written in
    letters. states: kind -> (action, state or rule of the parser) for each state. rules: by the
    identity of the parser's own, which `parser` keeps alive. passed: (state below, state, kind) ->
    state after the rules for which their only child stands, as far as they have been met.
    """

    parser: Lark
    sign: re.Pattern[str]
    words: Mapping[str, str]
    states: Mapping[int, Mapping[str, tuple[Any, Any]]]
    rules: Mapping[int, Rule]
    passed: dict[tuple[int, int, str], int]
    start: int
    end: int


class Words(Record, eq=False):
    """The tokens of a text, one entry each: where they start and end, their kinds and texts.

    The kinds end with that of the end.
    """

    starts: list[int]
    ends: list[int]
    kinds: list[str]
    texts: list[str]


class ReadSoFar(Record, eq=False):
    """The stack before word `at` of a text, which stands a little before its first mistake."""

    at: int
    stack: Stack


@cache
def tables(parser: Lark) -> Tables:
    """Returns the tables of a parser's grammar."""
    conf, ignored = parser.parse_interactive("").parser_state.parse_conf, parser.lexer_conf.ignore
    states = conf.parse_table.states
    rules = {
        id(rule): _rule(rule)
        for row in states.values()
        for _, rule in row.values()
        if not isinstance(rule, int)
    }
    words = {t.pattern.value: t.name for t in parser.terminals if t.pattern.value.isalpha()}
    others = [t for t in parser.terminals if not t.pattern.value.isalpha()]
    others.sort(
        key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name)
    )  # as Lark does
    between = "|".join(t.pattern.to_regexp() for t in others if t.name in ignored)
    signs = "|".join(
        f"(?P<{t.name}>{t.pattern.to_regexp()})" for t in others if t.name not in ignored
    )
    sign = re.compile(rf"(?:{between})*+(?:{signs}|(?P<{WRONG}>(?s:.))|\Z)")
    return Tables(parser, sign, words, states, rules, {}, conf.start_state, conf.end_state)


def _rule(rule: Any) -> Rule:
    """Returns what is done for a rule of the parser."""
    symbols, keeps_all = rule.expansion, rule.options.keep_all_tokens
    kept = [
        (at, s.name.startswith("_") and not s.is_term)
        for at, s in enumerate(symbols)
        if keeps_all or not (s.is_term and s.filter_out)
    ]
    name = "" if rule.origin.name.startswith("_") else rule.alias or rule.origin.name
    passes = rule.options.expand1 and not rule.alias
    return Rule(
        len(symbols), str(rule.origin.name), tuple(kept), str(name), passes, RULES.get(name)
    )


def read_directly(source: Source, parser: Lark) -> ast.File | ReadSoFar | Diagnostic | None:
    """Returns the tree of a text whose version line is right.

    Otherwise it returns how far it was read, if the words are not those of a game; a diagnostic,
    if it is nested too deeply or has too many statements; None, if a character is wrong, a number
    too large, or the text too long or its brackets nested too deeply.
    """
    known = tables(parser)
    words = cut(source.text, known)
    return None if words is None else Reader(words, source, known).file()


def cut(text: str, known: Tables) -> Words | None:
    """Returns the words and signs of a text; None for one that `scan` finds a mistake in."""
    words = Words([], [], [], [])
    starts, ends, kinds, texts = words.starts, words.ends, words.kinds, words.texts
    brackets = prefixes = 0
    for match in known.sign.finditer(text):
        kind = match.lastgroup
        if kind is None:  # only what is between, at the end of the text
            continue
        start, end = match.span(kind)
        word = text[start:end]
        if kind == "NAME":
            kind = known.words.get(word, kind)
        elif (
            kind == WRONG
            or (kind == "INT" and is_too_large(word))
            or (kind == "DEC" and len(word) > MAX_DIGITS)
        ):
            return None
        brackets += BRACKETS.get(kind, 0)
        prefixes = prefixes + 1 if kind in PREFIX else 0
        if brackets + prefixes > MAX_DEPTH:
            return None
        starts.append(start)
        ends.append(end)
        kinds.append(kind)
        texts.append(word)
    if not kinds or len(kinds) > MAX_TOKENS:
        return None
    for at in names_in_place(kinds):
        kinds[at] = "NAME"
    kinds.append(END)
    return words


class Reader:
    """One run of the table over words. Values are nodes, lists of them, or the numbers of words."""

    def __init__(self, words: Words, source: Source, known: Tables):
        self._words = words
        self._file = source.name
        self._known = known
        self._lines = [0, *(match.end() for match in re.finditer("\n", source.text))]
        self._statements = 0
        self._too_large: Diagnostic | None = None

    def file(self) -> ast.File | ReadSoFar | Diagnostic:
        """Returns the file, how far the words were read, or what is too large about it."""
        known, kinds = self._known, self._words.kinds
        states, rules, passed, end = known.states, known.rules, known.passed, known.end
        stack, values, firsts, heights = [known.start], list[Any](), list[int](), list[int]()
        earlier = kept = (0, list[int](), list[int]())
        for number, kind in enumerate(kinds):
            if not number % EVERY:
                earlier, kept = kept, (number, stack[:], firsts[:])
            if (
                kind in SOFT
                and not can_come(states, stack, kind)
                and can_come(states, stack, "NAME")
            ):
                kind = kinds[number] = "NAME"
            while True:
                to = states[stack[-1]].get(kind, NOTHING)[1]
                if to.__class__ is int:
                    stack.append(to)
                    values.append(number)
                    firsts.append(number)
                    heights.append(0)
                    break
                if to is None:
                    at, before, words = kept if kept[0] <= max(0, number - 1) else earlier
                    so_far = Stack(before[0], None)
                    for state, word in zip(
                        before[1:], words, strict=True
                    ):  # the word with which each level begins
                        so_far = Stack(state, so_far, word)
                    return ReadSoFar(at, so_far)
                rule = rules[id(to)]
                width = rule.width
                if width > 1 or not rule.passes:
                    value, height = self._made(
                        rule, values[-width:], firsts[-width], number, max(heights[-width:])
                    )
                    first = firsts[-width]
                    del stack[-width:], values[-width:], firsts[-width:], heights[-width:]
                    values.append(value)
                    firsts.append(first)
                    heights.append(height)
                    stack.append(states[stack[-1]][rule.origin][1])
                else:
                    below, state = stack[-2:]
                    stack[-1] = passed.get((below, state, kind)) or self._passed(below, state, kind)
                if kind == END and stack[-1] == end:
                    file: ast.File = values[-1]
                    return self._too_large or file
        raise AssertionError("the end of a text is read or refused")

    def _passed(self, below: int, state: int, kind: str) -> int:
        """Returns the state after all rules for which a single child stands: a dozen for `(a)`."""
        states = self._known.states
        after = state
        while True:
            to = states[after].get(kind, NOTHING)[1]
            rule = None if to is None or to.__class__ is int else self._known.rules[id(to)]
            if rule is None or rule.width > 1 or not rule.passes:
                self._known.passed[below, state, kind] = after
                return after
            after = states[below][rule.origin][1]

    def _made(
        self, rule: Rule, values: list[Any], first: int, behind: int, height: int
    ) -> tuple[Any, int]:
        """Returns a node, and the height of its tree. height: of its deepest child."""
        items: list[Any] = []
        for at, is_list in rule.kept:
            if not is_list:
                items.append(values[at])
            elif items:
                items += values[at]
            else:
                items = values[at]  # nobody else has the list
        name = rule.name
        if not name:
            return items, height
        if rule.passes and len(items) == 1:
            return items[0], height
        signs = 0
        for at, item in enumerate(items):
            if item.__class__ is int:
                items[at] = self._word(item)
                signs += 1
        height += (signs or len(items) - 1) if name in CHAINS else 1
        self._statements += name in STATEMENTS
        if self._too_large is None:
            self._check_size(height, first)
        if rule.build is None:
            if name == "names":
                return Part(name, tuple(items)), height
            return Part(name, items[0] if items else None), height
        words = self._words
        return rule.build(self._span(words.starts[first], words.ends[behind - 1]), *items), height

    def _check_size(self, height: int, first: int) -> None:
        """Notes that a text is nested too deeply, or has too many statements."""
        start = self._words.starts[first]
        if height > MAX_TREE:
            self._too_large = TooDeep(self._span(start, start), limit=MAX_TREE)
        elif self._statements > MAX_STATEMENTS:
            problem = "the file has more statements"
            self._too_large = too_much(problem, MAX_STATEMENTS, self._span(start, start))

    def _word(self, number: int) -> ast.Name | ast.String | str:
        words = self._words
        kind = words.kinds[number]
        text = words.texts[number]
        if kind in AS_WRITTEN:
            return text
        span = self._span(words.starts[number], words.ends[number])
        return ast.String(span, unquote(text)) if kind == "STRING" else ast.Name(span, text)

    def _span(self, start: int, end: int) -> Span:
        line = bisect_right(self._lines, start)
        return Span(self._file, start, end, line, start - self._lines[line - 1] + 1)
