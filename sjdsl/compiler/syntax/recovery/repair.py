"""Error recovery: finds the smallest change after a syntax error that lets most of the following text be read.

Assumes that the stack cannot read the next token; guarantees that it can read one after the change.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Literal

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.limits import MAX_DEPTH
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.syntax.recovery.automaton import (
    END,
    Automaton,
    Stack,
    accepted,
    levels,
    open_braces,
    reach,
    read,
)
from sjdsl.near_names import nearest

AHEAD = 24  # tokens looked at behind an error
STATEMENT = 12  # tokens that tell what a statement of another language is, and as many before it
ENOUGH = 3  # tokens that must follow for a change to be believed

STATEMENTS = frozenset((
    "EACH", "PICK", "FIRST", "MATCH", "WHEN", "CHANCE", "LET", "DRAW", "SET", "ADD", "GIVE", "TALLY", "SEND",
    "REMOVE", "MOVE", "MARK", "END",
))  # fmt: skip
SECTIONS = frozenset((
    "CITE", "ABOUT", "SIZE", "PARAM", "EPISODE", "KIND", "GROUP", "FIELD", "TIMER", "MAP", "AGENTS", "SHAPE", "DEFINE",
    "SCHEDULE", "PHASE", "OBSERVE", "LOOK", "METRICS", "CHECKS", "POLICY", "SCENARIO", "MOVERS", "VARIANT",
))  # fmt: skip
ENTRIES = frozenset((
    "GLYPH", "BLOCKS", "ACTS", "MOVES", "FORBID", "WINDOW", "SHOW", "HIDE", "EVENT", "MEAN", "FINAL", "REQUIRE",
    "ALWAYS", "ONCE", "CONSERVED", "MONOTONE", "SYMMETRIC", "EXPECT", "DROP", "OTHERWISE", "WHERE",
))  # fmt: skip
RESUMING = STATEMENTS | SECTIONS | ENTRIES | {"LBRACE", "RBRACE", END}

Sort = Literal["near", "name", "insert", "replace", "delete", "close", "unclose", "skip"]
BONUS = {
    "near": 6.0,
    "name": 2.0,
    "insert": 0.0,
    "close": 0.0,
    "unclose": 0.0,
    "delete": -1.0,
    "replace": -1.25,
}
IMBALANCE = 2.0  # what each brace without a partner costs
EARLIER = 0.5  # what a change before the last good token costs
COMMITTING = 2.0  # what it costs to put in a word that asks for a bracket or a value behind it
COMMITTED = frozenset(("CASE", "COUNT", "SUM", "LPAR", "LSQB", "NOT"))
NAMELIKE = frozenset(
    ("CASE", "COUNT", "SUM", "NOBODY", "ALL", "FIRST", "SEEK")
)  # words that may be names put where they can stand
REPEATED = 1.0  # what speaks for leaving out a token that stands there twice


class Trouble(Record):
    """Where the table refused token `at`: `before` is the stack before the token that precedes it."""

    automaton: Automaton
    kinds: Sequence[str]
    texts: Sequence[str]
    closing: Sequence[int]
    stack: Stack
    before: Stack | None
    at: int

    @property
    def unmatched(self) -> int:
        """How many of the open braces are not closed further on; below 0: how many are closed that are not open."""
        return len(open_braces(self.automaton, self.stack)) - self.closing[self.at]


class Repair(Record):
    """A change at token `place`: the stack and the token to go on with.

    `kind`: the kind of token put in, `times` so often; `alone`: no other change is as good.
    """

    sort: Sort
    place: int
    stack: Stack
    resume: int
    kind: str = ""
    times: int = 1
    alone: bool = True

    @property
    def is_sure(self) -> bool:
        return self.sort in ("near", "name")


def find_repair(trouble: Trouble) -> Repair | None:
    """Returns the change after which most can be read; to the next statement if no small one helps; None at the end."""
    found = []
    if statement_slip(trouble, accepted(trouble.automaton, trouble.stack)):
        return _skip(trouble)
    for change in _candidates(trouble):
        # few tokens must be read after a word that is nearly right for it to be believed
        needed = 1 if change.sort == "near" else min(ENOUGH, len(trouble.kinds) - trouble.at)
        seen = (
            reach(trouble.automaton, change.stack, trouble.kinds, change.resume, AHEAD)
            + change.resume
            - trouble.at
        )
        if seen >= needed:
            found.append((_score(trouble, change, min(AHEAD, seen)), change))
    if not found:
        return _skip(trouble)
    score, best = max(found, key=lambda pair: pair[0])
    rivals = sum(other == score for other, _ in found)
    return replace(best, alone=rivals == 1)


def _score(trouble: Trouble, repair: Repair, seen: int) -> float:
    """Returns what speaks for a change after which `seen` tokens from the error on can be read."""
    unmatched = len(open_braces(trouble.automaton, repair.stack)) - trouble.closing[repair.resume]
    score = seen + BONUS[repair.sort] - IMBALANCE * min(abs(unmatched), 3) - 0.01 * repair.times
    score -= EARLIER * (repair.place < trouble.at) + COMMITTING * (repair.kind in COMMITTED)
    repeated = (
        repair.sort == "delete"
        and trouble.at > 0
        and trouble.texts[trouble.at] == trouble.texts[trouble.at - 1]
    )
    return score + REPEATED * repeated


def _candidates(trouble: Trouble) -> Iterator[Repair]:
    """The small changes: one word read as another, one token more or less, braces closed."""
    yield from _changes_here(trouble)
    if trouble.before is not None:
        yield from _changes_before(trouble, trouble.before)
    closed, times = read(trouble.automaton, trouble.stack, "RBRACE"), 1
    while closed is not None and times <= MAX_DEPTH:
        yield Repair("close", trouble.at, closed, trouble.at, "RBRACE", times)
        closed, times = read(trouble.automaton, closed, "RBRACE"), times + 1


def _changes_here(trouble: Trouble) -> Iterator[Repair]:
    automaton, stack, at = trouble.automaton, trouble.stack, trouble.at
    kinds = accepted(automaton, stack)
    for kind in near_keywords(trouble, at, kinds):
        yield Repair("near", at, _read(automaton, stack, kind), at + 1, kind)
    if automaton.words.get(trouble.kinds[at], "").isalpha() and "NAME" in kinds:
        yield Repair("name", at, _read(automaton, stack, "NAME"), at + 1, "NAME")
    for kind in kinds:
        after = _read(automaton, stack, kind)
        if kind != END:
            yield Repair("insert", at, after, at, kind)
        if trouble.kinds[at] != END:
            yield Repair("replace", at, after, at + 1, kind)
    if trouble.kinds[at] != END:
        yield Repair("delete", at, stack, at + 1)


def _changes_before(trouble: Trouble, before: Stack) -> Iterator[Repair]:
    """Changes of the token before the refused one, or in front of it."""
    automaton, place = trouble.automaton, trouble.at - 1
    kinds = accepted(automaton, before)
    for kind in near_keywords(trouble, place, kinds):
        yield Repair("near", place, _read(automaton, before, kind), trouble.at, kind)
    if trouble.kinds[place] in NAMELIKE and "NAME" in kinds:
        yield Repair("name", place, _read(automaton, before, "NAME"), trouble.at, "NAME")
    if trouble.kinds[place] == "RBRACE":
        yield Repair("unclose", trouble.at, before, trouble.at)
    for kind in kinds:
        after = (
            read(automaton, _read(automaton, before, kind), trouble.kinds[place], place)
            if kind != END
            else None
        )
        if after is not None:
            yield Repair("insert", place, after, trouble.at, kind)


def _read(automaton: Automaton, stack: Stack, kind: str) -> Stack:
    after = read(automaton, stack, kind)
    assert after is not None
    return after


def can_be_written(automaton: Automaton, kinds: Sequence[str]) -> dict[str, str]:
    """Returns the words and signs of these kinds, each with its kind."""
    return {word: kind for kind, word in automaton.words.items() if kind in kinds} | (
        {"==": "CMP"} if "CMP" in kinds else {}
    )


def statement_slip(trouble: Trouble, kinds: Sequence[str]) -> str:
    """Returns what to write instead of the words of another language that end or begin with the refused token; empty if they are none."""
    at, texts = trouble.at, trouble.texts
    written = " ".join(texts[at : at + STATEMENT]).rstrip()
    before = " ".join(texts[max(0, at - STATEMENT) : at])
    return slip(written, can_be_written(trouble.automaton, kinds), before)[0]


def near_keywords(trouble: Trouble, at: int, kinds: Sequence[str]) -> list[str]:
    """Returns the kinds of the keywords, among `kinds`, that a misspelt word may stand for."""
    text = trouble.texts[at]
    words = can_be_written(trouble.automaton, kinds)
    hint, word = slip(text, words)
    if word:
        return [words[word]]
    if hint or trouble.kinds[at] != "NAME":
        return []
    words = {word: kind for word, kind in words.items() if word.isalpha()}
    near = []
    while best := nearest(text, words):
        near += [words.pop(word) for word in best]
    return near


def _skip(trouble: Trouble) -> Repair | None:
    """Goes to the next statement, brace or end at which some level of the stack can read on."""
    automaton, depth = trouble.automaton, 0
    for resume in range(trouble.at, len(trouble.kinds)):
        kind = trouble.kinds[resume]
        if kind in RESUMING and depth == 0:
            needed = 1 if kind in ("RBRACE", END) else ENOUGH
            for level in levels(trouble.stack):
                if reach(automaton, level, trouble.kinds, resume, needed) >= needed:
                    return Repair("skip", trouble.at, level, resume)
                if level.state in automaton.after["LBRACE"] and kind != "RBRACE":
                    break
        depth = max(0, depth + (kind == "LBRACE") - (kind == "RBRACE"))
    return None
