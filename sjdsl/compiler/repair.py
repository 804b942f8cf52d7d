"""How reading goes on after a syntax error: the small change that lets most of the text behind it be read.

Assumes that `stack` cannot read token `at`; guarantees that reading goes on behind `at` or with a shallower stack.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from sjdsl.compiler.automaton import END, Automaton, Stack, accepted, levels, open_marks, reach, read
from sjdsl.compiler.diagnostics import nearest

AHEAD = 12  # tokens looked at behind an error
ENOUGH = 3  # tokens that must follow for a change to be believed

SENTENCES = (
    "EACH", "PICK", "FIRST", "MATCH", "WHEN", "CHANCE", "LET", "DRAW", "SET", "ADD", "GIVE", "TALLY", "SEND", "REMOVE", "MOVE",
    "MARK", "END",
)  # fmt: skip
SECTIONS = (
    "CITE", "SIZE", "PARAM", "EPISODE", "KIND", "GROUP", "FIELD", "TIMER", "MAP", "AGENTS", "SHAPE", "DEFINE", "SCHEDULE",
    "PHASE", "OBSERVE", "METRICS", "CHECKS", "VARIANT",
)  # fmt: skip
INNER = (
    "GLYPH", "BLOCKS", "ACTS", "MOVES", "FORBID", "WINDOW", "SHOW", "HIDE", "EVENT", "MEAN", "FINAL", "REQUIRE", "ALWAYS",
    "ONCE", "CONSERVED", "MONOTONE", "SYMMETRIC", "EXPECT", "DROP", "OTHERWISE", "WHERE",
)  # fmt: skip
RESUMING = frozenset((*SENTENCES, *SECTIONS, *INNER, "LBRACE", "RBRACE", END))

# Words other languages use, with ours.
FOREIGN = {
    "if": "when", "else": "otherwise", "elif": "otherwise", "foreach": "each", "every": "each", "any": "each", "def": "define",
    "function": "define", "rule": "phase", "step": "phase", "const": "param", "constant": "param", "parameter": "param",
    "players": "agents", "player": "agents", "agent": "agents", "tile": "kind", "object": "kind", "reward": "give", "random": "chance",
    "probability": "chance", "var": "let", "assign": "set", "import": "extends", "inherits": "extends", "type": "kind",
    "order": "schedule", "count_event": "tally", "invariant": "always", "assert": "require", "teleport": "send", "respawn": "send",
    "counter": "timer", "variable": "field", "stop": "end", "none": "nobody",
}  # fmt: skip

Sort = Literal["near", "name", "earlier name", "insert", "replace", "delete", "close", "unclose", "skip"]


@dataclass(frozen=True)
class Repair:
    """The stack and the token to go on with; `kind`: the kind of token put in, `times` so often; `score`: how good it is."""

    sort: Sort
    stack: Stack
    resume: int
    kind: str = ""
    times: int = 1
    score: float = 0.0
    unique: bool = True


@dataclass(frozen=True)
class Trouble:
    """Where the table refused: `before` is the stack before the token that precedes `at`."""

    automaton: Automaton
    keywords: dict[str, str]
    kinds: Sequence[str]
    texts: Sequence[str]
    stack: Stack
    before: Stack | None
    at: int

    def ahead(self, stack: Stack | None, start: int) -> int:
        """How many tokens behind `at` can be read from `start` on."""
        return reach(self.automaton, stack, self.kinds, start, AHEAD) + start - self.at

    @property
    def missing_braces(self) -> int:
        """How many more `{` are open than there are `}` left (negative: too few are open)."""
        left = self.kinds[self.at :]
        return len(open_marks(self.stack, self.automaton.braces)) - left.count("RBRACE") + left.count("LBRACE")


def find_repair(trouble: Trouble) -> Repair:
    """Returns the change that lets most be read; skips to the next statement if no small one helps."""
    sure = _near(trouble)
    if sure is not None:
        return sure
    candidates = [replace(c, score=c.score + trouble.ahead(c.stack, c.resume)) for c in _candidates(trouble)]
    best = max(candidates, key=lambda c: c.score, default=None)
    if best is None or trouble.ahead(best.stack, best.resume) < ENOUGH:
        return _skip(trouble)
    rivals = [c for c in candidates if c is not best and c.score == best.score]
    return replace(best, unique=not rivals)


def near_keyword(text: str, words: Sequence[str]) -> str:
    """Returns the only word that `text` was most likely meant to be, or nothing."""
    if FOREIGN.get(text) in words:
        return FOREIGN[text]
    best = nearest(text, words)
    if best and nearest(text, [w for w in words if w != best]) and _equally_near(text, best, words):
        return ""
    return best


def _equally_near(text: str, best: str, words: Sequence[str]) -> bool:
    """Whether another word is as near: then taking the candidates in the other order changes the answer."""
    others = [w for w in words if w != best]
    second = nearest(text, others)
    return nearest(text, [f"{second}"]) != "" and len(second) == len(best) and second[:1] == text[:1] != best[:1]
