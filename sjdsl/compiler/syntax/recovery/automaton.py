"""The parser's LALR table, run on kinds of tokens: what may come next, what is still open."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from lark import Lark

from sjdsl.compiler.diagnostics.frozen import Record

END = "$END"


class Automaton(Record, eq=False):
    """The parser's table.

    states: for each state, symbol -> (action, the state to shift to, or the rule to reduce by).
    after: the states that end with a kind of token. words: the kinds of tokens that are written in
    one way only, with their text. soft: the kinds that are names where no such word can come.
    """

    states: Mapping[int, Mapping[str, tuple[Any, Any]]]
    start: int
    end: int
    after: Mapping[str, frozenset[int]]
    words: Mapping[str, str]
    soft: frozenset[str]

    def stack(self, states: Iterable[int] = ()) -> "Stack":
        """Returns the stack with these states above the first one, outermost first."""
        stack = Stack(self, self.start, None, -1)
        for state in states:
            stack = Stack(self, state, stack, -1)
        return stack


def make_automaton(parser: Lark, soft: frozenset[str]) -> Automaton:
    """Returns the table of a LALR parser."""
    conf = parser.parse_interactive("").parser_state.parse_conf
    states = conf.parse_table.states
    after: dict[str, set[int]] = {}
    for transitions in states.values():
        for symbol, (_, argument) in transitions.items():
            if isinstance(argument, int):
                after.setdefault(symbol, set()).add(argument)
    return Automaton(
        states=states,
        start=conf.start_state,
        end=conf.end_state,
        after={kind: frozenset(ending) for kind, ending in after.items()},
        words={t.name: t.pattern.value for t in parser.terminals if t.pattern.type == "str"},
        soft=soft,
    )


class Stack(Record, eq=False):
    """What has been read so far: a state of the table upon the stack below.

    token: the number of the token it ends with.
    """

    automaton: Automaton
    state: int
    below: "Stack | None"
    token: int

    def read(self, kind: str, token: int = -1) -> "Stack | None":
        """Returns the stack after one token; None if it cannot come here.

        A soft word is read as a name where it cannot come as such.
        """
        after = self.read_as(kind, token)
        if after is None and kind in self.automaton.soft:
            return self.read_as("NAME", token)
        return after

    def read_as(self, kind: str, token: int = -1) -> "Stack | None":
        """Returns the stack after one token of just this kind, None if it cannot come here."""
        automaton = self.automaton
        states = automaton.states
        # A word after an expression reduces it a dozen times, each time replacing only the top
        # level: that is held in variables.
        state = self.state
        below = self.below
        last = self.token
        while True:
            _, argument = states[state].get(kind, (None, None))
            if argument is None:
                return None
            if isinstance(argument, int):
                return Stack(automaton, argument, Stack(automaton, state, below, last), token)
            under = below if argument.expansion else Stack(automaton, state, below, last)
            for _ in argument.expansion[1:]:
                assert under is not None
                under = under.below
            assert under is not None
            reduced = states[under.state][argument.origin.name][1]
            if kind == END and reduced == automaton.end:
                return Stack(automaton, state, below, last)
            state = reduced
            below = under

    def accepted(self) -> list[str]:
        """Returns the kinds of tokens that can come next, in a fixed order; soft words as such."""
        kinds = sorted(symbol for symbol in self.automaton.states[self.state] if symbol.isupper())
        return [kind for kind in kinds if self.read_as(kind) is not None]

    def reach(self, kinds: Sequence[str], start: int, ahead: int) -> int:
        """Returns how many tokens from `start` on can be read, `ahead` at most.

        The end of the text counts for all of them.
        """
        stack = self
        for count in range(ahead):
            kind = kinds[start + count]
            after = stack.read(kind)
            if after is None:
                return count
            if kind == END:
                break
            stack = after
        return ahead

    def levels(self) -> "Iterator[Stack]":
        """Yields the stack and everything below it, innermost first."""
        level: Stack | None = self
        while level is not None:
            yield level
            level = level.below

    def open_marks(self, opening: str, closing: str) -> list[int]:
        """Returns the tokens of kind `opening` that have no `closing` yet, innermost first.

        One that a repair put in is -1.
        """
        after = self.automaton.after
        opened: list[int] = []
        closed = 0
        for level in self.levels():
            if level.state in after[closing]:
                closed += 1
            elif level.state in after[opening]:
                if closed:
                    closed -= 1
                else:
                    opened.append(level.token)
        return opened

    def open_braces(self) -> list[int]:
        """Returns the `{` that are open, innermost first."""
        return self.open_marks("LBRACE", "RBRACE")
