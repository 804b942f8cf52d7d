"""Error recovery: finds the smallest change after which most of the following text can be read.

Assumes that the stack cannot read the next token; guarantees that it can read one after the change.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal

from lark import Token

from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.limits import MAX_DEPTH
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.recovery.automaton import END, Stack
from sjdsl.near_names import nearest

AHEAD = 24  # tokens looked at behind an error
STATEMENT = 12  # tokens that tell what a statement of another language is, and as many before it
ENOUGH = 3  # tokens that must follow for a change to be believed

STATEMENTS = frozenset((
    "EACH", "PICK", "FIRST", "MATCH", "WHEN", "CHANCE", "LET", "DRAW", "SET", "ADD", "GIVE",
    "TALLY", "SEND", "REMOVE", "MOVE", "MARK", "END",
))  # fmt: skip
SECTIONS = frozenset((
    "CITE", "ABOUT", "SIZE", "PARAM", "EPISODE", "KIND", "GROUP", "FIELD", "TIMER", "MAP", "AGENTS",
    "SHAPE", "DEFINE", "SCHEDULE", "PHASE", "OBSERVE", "LOOK", "METRICS", "CHECKS", "POLICY",
    "SCENARIO", "MOVERS", "VARIANT", "TASK", "TRAIN", "HOLD",
))  # fmt: skip
ENTRIES = frozenset((
    "GLYPH", "BLOCKS", "ACTS", "MOVES", "FORBID", "WINDOW", "SHOW", "HIDE", "EVENT", "MEAN",
    "FINAL", "REQUIRE", "ALWAYS", "ONCE", "CONSERVED", "MONOTONE", "SYMMETRIC", "EXPECT", "DROP",
    "OTHERWISE", "WHERE",
))  # fmt: skip
RESUMING = STATEMENTS | SECTIONS | ENTRIES | {"LBRACE", "RBRACE", END}

Sort = Literal["near", "name", "insert", "replace", "delete", "close", "unclose", "skip"]
BONUS = {  # of a change; its other terms are below
    "near": 6.0,
    "name": 2.0,
    "insert": 0.0,
    "close": 0.0,
    "unclose": 0.0,
    "delete": -1.0,
    "replace": -1.25,
}
IMBALANCE = 2.0  # cost of each brace without a partner
EARLIER = 0.5  # cost of a change before the last good token
COMMITTING = 2.0  # cost of putting in a word that needs a bracket or a value after it
COMMITTED = frozenset(("CASE", "COUNT", "SUM", "LPAR", "LSQB", "NOT"))
NAMELIKE = frozenset(("CASE", "COUNT", "SUM", "NOBODY", "ALL", "FIRST", "SEEK"))  # perhaps names
REPEATED = 1.0  # bonus of leaving out a token that is there twice


class Trouble(Record):
    """Where the table refused token `at`.

    kinds, texts: of the tokens, and of the end. closing: see `parse.closing_braces`.
    stack, before: at that token, and at the one before it.
    """

    source: Source
    tokens: Sequence[Token]
    kinds: Sequence[str]
    texts: Sequence[str]
    closing: Sequence[int]
    stack: Stack
    before: Stack | None
    at: int

    @property
    def words(self) -> Mapping[str, str]:
        """The kinds of tokens that are written in one way only, with their text."""
        return self.stack.automaton.words

    @property
    def unmatched(self) -> int:
        """How many open braces are not closed further on.

        Below 0: how many are closed that are not open.
        """
        return len(self.stack.open_braces()) - self.closing[self.at]


class Repair(Record):
    """A change at token `place`: the stack and the token to go on with.

    kind: of the token that is put in, `times` times. alone: whether no other change is as good.
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
        """Whether later errors can't follow from it: a word is only read as another."""
        return self.sort in ("near", "name")


def find_repair(trouble: Trouble) -> Repair | None:
    """Returns the change after which most can be read.

    If no small one helps, it goes on at the next statement; None if there is none.
    """
    if statement_slip(trouble, trouble.stack.accepted()):
        return _skip(trouble)
    scored = []
    for change in _candidates(trouble):
        # after a word that is nearly right, one token that can be read is enough to believe it
        needed = 1 if change.sort == "near" else min(ENOUGH, len(trouble.kinds) - trouble.at)
        read_on = change.stack.reach(trouble.kinds, change.resume, AHEAD)
        seen = read_on + change.resume - trouble.at
        if seen >= needed:
            scored.append((_score(trouble, change, min(AHEAD, seen)), change))
    if not scored:
        return _skip(trouble)
    best_score, best = max(scored, key=lambda pair: pair[0])
    rivals = sum(score == best_score for score, _ in scored)
    return replace(best, alone=rivals == 1)


def _score(trouble: Trouble, repair: Repair, seen: int) -> float:
    """Returns the score of a change after which `seen` tokens from the error on can be read."""
    unmatched = len(repair.stack.open_braces()) - trouble.closing[repair.resume]
    score = seen + BONUS[repair.sort] - IMBALANCE * min(abs(unmatched), 3) - 0.01 * repair.times
    if repair.place < trouble.at:
        score -= EARLIER
    if repair.kind in COMMITTED:
        score -= COMMITTING
    if repair.sort == "delete" and trouble.at > 0:
        if trouble.texts[trouble.at] == trouble.texts[trouble.at - 1]:
            score += REPEATED
    return score


def _candidates(trouble: Trouble) -> Iterator[Repair]:
    """Yields the small changes: a word read as another, one token more or less, braces closed."""
    yield from _changes_here(trouble)
    if trouble.before is not None:
        yield from _changes_before(trouble, trouble.before)
    closed = trouble.stack.read("RBRACE")
    times = 1
    while closed is not None and times <= MAX_DEPTH:
        yield Repair("close", trouble.at, closed, trouble.at, "RBRACE", times)
        closed = closed.read("RBRACE")
        times += 1


def _changes_here(trouble: Trouble) -> Iterator[Repair]:
    """Yields changes of the refused token, or in front of it."""
    stack = trouble.stack
    at = trouble.at
    kinds = stack.accepted()
    for kind in near_keywords(trouble, at, kinds):
        yield Repair("near", at, _read_accepted(stack, kind), at + 1, kind)
    if trouble.words.get(trouble.kinds[at], "").isalpha() and "NAME" in kinds:
        yield Repair("name", at, _read_accepted(stack, "NAME"), at + 1, "NAME")
    for kind in kinds:
        after = _read_accepted(stack, kind)
        if kind != END:
            yield Repair("insert", at, after, at, kind)
        if trouble.kinds[at] != END:
            yield Repair("replace", at, after, at + 1, kind)
    if trouble.kinds[at] != END:
        yield Repair("delete", at, stack, at + 1)


def _changes_before(trouble: Trouble, before: Stack) -> Iterator[Repair]:
    """Yields changes of the token before the refused one, or in front of it."""
    place = trouble.at - 1
    kinds = before.accepted()
    for kind in near_keywords(trouble, place, kinds):
        yield Repair("near", place, _read_accepted(before, kind), trouble.at, kind)
    if trouble.kinds[place] in NAMELIKE and "NAME" in kinds:
        yield Repair("name", place, _read_accepted(before, "NAME"), trouble.at, "NAME")
    if trouble.kinds[place] == "RBRACE":
        yield Repair("unclose", trouble.at, before, trouble.at)
    for kind in kinds:
        if kind == END:
            continue
        after = _read_accepted(before, kind).read(trouble.kinds[place], place)
        if after is not None:
            yield Repair("insert", place, after, trouble.at, kind)


def _read_accepted(stack: Stack, kind: str) -> Stack:
    """Returns the stack after a token of a kind that can come next."""
    after = stack.read(kind)
    assert after is not None
    return after


def can_be_written(trouble: Trouble, kinds: Sequence[str]) -> dict[str, str]:
    """Returns the words and signs of these kinds, each with its kind."""
    words = {word: kind for kind, word in trouble.words.items() if kind in kinds}
    if "CMP" in kinds:
        words["=="] = "CMP"
    return words


def statement_slip(trouble: Trouble, kinds: Sequence[str]) -> str:
    """Returns what to write in place of a statement of another language; empty for other errors.

    The refused token begins it, as in `while x > 3`, or is inside, as the second `*` of `x ** 2`.
    kinds: of the tokens that could stand in place of the refused one.
    """
    at = trouble.at
    before = trouble.texts[max(0, at - STATEMENT) : at]
    behind = trouble.texts[at : at + STATEMENT]
    known = can_be_written(trouble, kinds)
    hint, _ = slip(" ".join(behind).rstrip(), known, " ".join(before))
    return hint


def near_keywords(trouble: Trouble, at: int, kinds: Sequence[str]) -> list[str]:
    """Returns the kinds of the keywords, among `kinds`, that a misspelt word may stand for."""
    text = trouble.texts[at]
    words = can_be_written(trouble, kinds)
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
    depth = 0
    for resume in range(trouble.at, len(trouble.kinds)):
        kind = trouble.kinds[resume]
        if kind in RESUMING and depth == 0:
            needed = 1 if kind in ("RBRACE", END) else ENOUGH
            for level in trouble.stack.levels():
                if level.reach(trouble.kinds, resume, needed) >= needed:
                    return Repair("skip", trouble.at, level, resume)
                if level.state in level.automaton.after["LBRACE"] and kind != "RBRACE":
                    break
        if kind == "LBRACE":
            depth += 1
        elif kind == "RBRACE":
            depth = max(0, depth - 1)
    return None
