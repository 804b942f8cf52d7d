"""The limits of the compiler on the size of a game, and checks of a text before it is parsed."""

import re

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic
from sjdsl.compiler.diagnostics.source import Source, Span

MAX_BYTES = 1 << 20
MAX_LINE = 4096  # characters
MAX_TOKENS = 32_768
MAX_STATEMENTS = 4096
MAX_DEPTH = 64  # brackets around one place, signs and `not` before one value
MAX_TREE = 160  # the same, and operators in a row, links of an `otherwise` chain, blocks
MAX_INTEGER = 2**31 - 1
MAX_VALUE = 2**30  # of a declared number, and of the ends of a field's range
MAX_EXPONENT = 64  # of a power that is a product
MAX_DIGITS = 32  # characters of a decimal number
MAX_PROBLEMS = 100  # syntax errors of one file

MAX_MAP_SIDE = 256
MAX_MAP_CELLS = 65_536
MAX_SHAPE_CELLS = 256
MAX_WINDOW = 32  # cells to one side
MAX_AGENTS = 64
MAX_ACTIONS = 256
MAX_MOVERS = 64  # of one sort
MAX_KINDS = 64
MAX_WORDS = 64  # in one set
MAX_FIELDS = 128
MAX_PHASES = 64
MAX_TRIALS = 1024  # of an episode
MAX_TURNS = 128
MAX_SHIFT = 64  # cells that an agent is sent in a direction
MAX_DRAWN = 65_535  # values of one draw
MAX_DEALT = 256  # values that the different entries of a row are drawn from
MAX_DEFINES_DEEP = 32  # a define that uses a define that …
MAX_EXPANSIONS = 4096  # uses of defines, once those inside them are written out

CHAINS = ("sum", "prod", "expr", "and_e")
STATEMENTS = frozenset((  # rules of the grammar that count as statements
    "cite", "about", "size", "param", "episode", "task", "task_field", "train_on", "hold_out", "kind", "group", "field", "timer", "map", "agents",
    "movers", "shape", "define", "schedule", "phase", "observe", "look", "metrics", "checks",
    "variant", "override", "drop", "glyph", "blocks", "acts", "moves", "forbid", "window", "show", "show_event",
    "hide", "event", "mean", "final", "require", "always", "once", "conserved", "monotone",
    "symmetric", "expect", "let", "draw", "each", "pick", "first", "match", "when", "chance", "set",
    "add", "give", "tally", "send", "shift", "remove", "move", "mark", "end", "scripted", "act",
    "go", "aim", "scenario", "slots",
))  # fmt: skip


def too_much(problem: str, limit: int, span: Span, help_: str = "") -> Diagnostic:
    """Returns the error for something there is too much of."""
    return errors.TooMuch(span, problem=problem, limit=limit, help=help_)


def check_text(source: Source) -> list[Diagnostic]:
    """Returns why a text cannot be parsed at all: too large, not text, or a line too long."""
    size = len(source.text)
    if size <= MAX_BYTES:
        size = len(source.text.encode("utf-8", "surrogatepass"))
    if size > MAX_BYTES:
        return [errors.FileTooLarge(source.span(0, 0), size=size, limit=MAX_BYTES)]
    if "\0" in source.text:
        at = source.text.index("\0")
        return [errors.NotText(source.span(at, at), problem="it holds NUL characters")]
    old = re.search(r"\r(?!\n)", source.text)
    if old:
        problem = "it has lines that end with a carriage return alone"
        return [errors.NotText(source.span(old.start(), old.start()), problem=problem)]
    long = re.search(rf"[^\n]{{{MAX_LINE + 1},}}", source.text)
    if long:
        span = source.span(long.start(), long.start())
        problem = f"this line has {len(long.group())} characters"
        return [too_much(problem, MAX_LINE, span, "break the line")]
    return []
