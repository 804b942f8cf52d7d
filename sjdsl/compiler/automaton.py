"""The parser's table run on kinds of tokens alone: what may come next, how far a text goes on, what is still open."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from lark import Lark

END = "$END"


@dataclass(frozen=True, eq=False)
class Stack:
    """What has been read so far: a state of the table upon the stack below; `token` is the number of the token it ends with."""

    state: int
    below: "Stack | None"
    token: int = -1


@dataclass(frozen=True, eq=False)
class Automaton:
    """`states`: for each state, symbol -> ("shift", state) or ("reduce", rule); `braces`: the states just after a `{`."""

    states: Mapping[int, Mapping[str, Any]]
    start: int
    end: int
    braces: frozenset[int]
    brackets: frozenset[int]


def make_automaton(parser: Lark) -> Automaton:
    """Returns the table of a LALR parser."""
    conf = parser.parse_interactive("").parser_state.parse_conf
    table: dict[int, dict[str, Any]] = {}
    for state, row in conf.parse_table.states.items():
        table[state] = {
            symbol: ("reduce", argument) if hasattr(argument, "expansion") else ("shift", argument)
            for symbol, (_, argument) in row.items()
        }
    shifts = {(symbol, argument) for row in table.values() for symbol, (kind, argument) in row.items() if kind == "shift"}
    braces = frozenset(state for symbol, state in shifts if symbol == "LBRACE")
    brackets = frozenset(state for symbol, state in shifts if symbol in ("LPAR", "LSQB"))
    return Automaton(table, conf.start_state, conf.end_state, braces, brackets)


def read(automaton: Automaton, stack: Stack, kind: str, token: int = -1) -> Stack | None:
    """Returns the stack after one token of this kind, None if it cannot come here."""
    while True:
        action, argument = automaton.states[stack.state].get(kind, (None, None))
        if action is None:
            return None
        if action == "shift":
            return Stack(argument, stack, token)
        if kind == END and _is_start_rule(automaton, stack, argument):
            return stack
        stack = _reduce(automaton, stack, argument)


def _reduce(automaton: Automaton, stack: Stack, rule: Any) -> Stack:
    last = stack.token
    for _ in rule.expansion:
        assert stack.below is not None
        stack = stack.below
    return Stack(automaton.states[stack.state][rule.origin.name][1], stack, last)


def _is_start_rule(automaton: Automaton, stack: Stack, rule: Any) -> bool:
    return _reduce(automaton, stack, rule).state == automaton.end


def accepted(automaton: Automaton, stack: Stack) -> list[str]:
    """Returns the kinds of tokens that can come next, in a fixed order."""
    kinds = sorted(symbol for symbol in automaton.states[stack.state] if symbol.isupper())
    return [kind for kind in kinds if read(automaton, stack, kind) is not None]


def reach(automaton: Automaton, stack: Stack | None, kinds: Sequence[str], start: int, ahead: int) -> int:
    """Returns how many tokens from `start` on can be read, `ahead` at most; the end of the text counts for all of them."""
    count = 0
    while stack is not None and count < ahead:
        kind = kinds[start + count]
        stack = read(automaton, stack, kind)
        if stack is not None and kind == END:
            return ahead
        count += stack is not None
    return count


def levels(stack: Stack) -> Iterator[Stack]:
    """Returns the stack and everything below it, innermost first."""
    level: Stack | None = stack
    while level is not None:
        yield level
        level = level.below


def open_marks(stack: Stack, states: frozenset[int]) -> list[int]:
    """Returns the tokens that opened what is still open (`automaton.braces` or `.brackets`), innermost first."""
    return [level.token for level in levels(stack) if level.state in states]
