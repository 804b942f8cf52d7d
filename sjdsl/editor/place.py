"""The place of the cursor: what stands before it, which words of the language may follow, and which local names there are."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from lark import Token

from sjdsl.compiler.diagnostics.limits import MAX_PROBLEMS, check_text
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import automaton, closing_braces, parser
from sjdsl.compiler.syntax.recovery.automaton import END, Automaton, Stack, accepted, read
from sjdsl.compiler.syntax.recovery.repair import Trouble, find_repair
from sjdsl.compiler.syntax.soft_words import as_name
from sjdsl.compiler.syntax.tokens import scan

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*$")
BEFORE = re.compile(r'"(?:\\.|[^"\\\n])*"|#[^\n]*|"(?P<open>[^"\n]*)$')


@dataclass(frozen=True)
class Place:
    """A place of a text. `tokens`: those before the word that is being written there, which begins at `start` and is `word` so far.

    `inside`: `comment`, or `text` for one in quotes, of which `word` is the part before the cursor; else empty.
    """

    tokens: tuple[Token, ...]
    word: str
    start: int
    inside: str = ""

    @cached_property
    def following(self) -> frozenset[str]:
        """The kinds of tokens that may stand here; soft words by their own kind."""
        stack = read_all(list(self.tokens))
        return frozenset(accepted(automaton(), stack))

    def last(self, number: int = 1) -> str:
        """Returns the kind of the last token, of the one before it for 2, and so on; empty where there is none."""
        return self.tokens[-number].type if len(self.tokens) >= number else ""

    def text(self, number: int = 1) -> str:
        return str(self.tokens[-number]) if len(self.tokens) >= number else ""


def place_at(text: str, offset: int) -> Place:
    """Returns the place before a character of any text."""
    before = text[:offset]
    line = before[before.rfind("\n") + 1 :]
    start = len(before) - len(line)
    for match in BEFORE.finditer(line):
        if match.end() == len(line) and match.group().startswith("#"):
            return Place((), "", offset, "comment")
        if match.group("open") is not None:
            opened = start + match.start()
            return Place(_tokens(before[:opened]), match.group("open"), opened + 1, "text")
    written = WORD.search(before)
    word = written.group() if written else ""
    return Place(_tokens(before[: offset - len(word)]), word, offset - len(word))


def _tokens(text: str) -> tuple[Token, ...]:
    source = Source("", text)
    return () if check_text(source) else tuple(scan(source, parser()).tokens)


def read_all(tokens: list[Token]) -> Stack:
    """Returns what the parser knows behind tokens; where one cannot be read, behind the smallest change that lets it go on."""
    table = automaton()
    stack, before, at, repairs = Stack(table.start, None), None, 0, 0
    kinds = [token.type for token in tokens] + [END]
    texts = [str(token) for token in tokens] + [""]
    closing = closing_braces(kinds)
    while at < len(tokens):
        kinds[at] = as_name(table, stack, tokens[at]).type
        after = read(table, stack, kinds[at], at)
        if after is not None:
            before, stack, at = stack, after, at + 1
            continue
        repair = find_repair(Trouble(table, kinds, texts, closing, stack, before, at)) if repairs < MAX_PROBLEMS else None
        if repair is None or (repair.resume >= len(tokens) and not _can_go_on(table, repair.stack)):
            at += 1  # as if the token were not there
            continue
        before, stack, at, repairs = (
            None,
            repair.stack,
            max(repair.resume, at if repair.sort in ("insert", "close") else at + 1),
            repairs + 1,
        )
    return stack


def _can_go_on(table: Automaton, stack: Stack) -> bool:
    return accepted(table, stack) != [END]


def head(tokens: Sequence[Token], kinds: frozenset[str]) -> Token | None:
    """Returns the last token of some kinds in the same brackets as the end of the tokens."""
    depth = 0
    for token in reversed(tokens):
        if token.type in ("RBRACE", "RPAR", "RSQB"):
            depth += 1
        elif token.type in ("LBRACE", "LPAR", "LSQB"):
            depth -= 1
            if depth < 0:
                return None
        elif depth == 0 and token.type in kinds:
            return token
    return None
