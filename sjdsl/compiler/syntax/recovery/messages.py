"""Words a syntax error for its author: what was read, what could stand there, what to write."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import chain, count, pairwise

from lark import Token

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Label
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.recovery.automaton import END
from sjdsl.compiler.syntax.recovery.repair import (
    COMMITTED,
    SECTIONS,
    STATEMENTS,
    Repair,
    Trouble,
    can_be_written,
    near_keywords,
    statement_slip,
)
from sjdsl.near_names import either, nearest

PHRASES = {
    "NAME": "a name",
    "STRING": 'a text in `"`',
    "INT": "a whole number",
    "DEC": "a number",
    END: "the end of the file",
}
MISPLACED = (
    (STATEMENTS, SECTIONS, "a statement stands inside a `phase`"),
    (SECTIONS, STATEMENTS, "a declaration stands outside the phases"),
)
VALUES = frozenset(
    ("NAME", "INT", "DEC", "COUNT", "SUM", "CASE", "LPAR", "NOBODY", "SIGN", "ANY", "ALL")
)
OPERATORS = frozenset(("CMP", "SIGN", "TIMES", "POWER", "AND", "OR", "IS", "IN", "ON", "CHOSE"))
GROUPS = (
    (STATEMENTS, "a statement"),
    (SECTIONS, "a declaration"),
    (VALUES, "a value"),
)
LONGEST = 7  # things named as expected


def word_error(trouble: Trouble, repair: Repair | None) -> Diagnostic:
    """Returns the diagnostic of one syntax error, as the repair explains it best."""
    if repair is None:
        return _unexpected(trouble, repair)
    if repair.place < trouble.at and trouble.before is not None:
        trouble = replace(trouble, stack=trouble.before, before=None, at=repair.place)
    if repair.sort == "name":
        word = str(trouble.tokens[repair.place])
        span = _refused_span(trouble)
        return errors.ReservedWord(span, word=word, other=_free_name(word, trouble.tokens))
    if repair.kind == "RBRACE" and repair.sort in ("close", "insert"):
        if trouble.unmatched or _is_outdented(trouble):
            return _open_block(trouble, repair)
    return _unexpected(trouble, repair)


def token_span(token: Token, source: Source) -> Span:
    return Span(
        source.name, token.start_pos or 0, token.end_pos or 0, token.line or 1, token.column or 1
    )


def _free_name(word: str, tokens: Sequence[Token]) -> str:
    """Returns a name like a word that the file does not have yet."""
    names = chain((f"{word}_",), (f"{word}__{number}" for number in count(2)))
    return next(name for name in names if name not in tokens)


def _refused_span(trouble: Trouble) -> Span:
    """Returns the span of the refused token; at the end of the file, the place after the last."""
    tokens = trouble.tokens
    source = trouble.source
    if trouble.at < len(tokens):
        return token_span(tokens[trouble.at], source)
    return _place_behind(tokens[-1], source) if tokens else source.span(0, 0)


def _place_behind(token: Token, source: Source) -> Span:
    """Returns the empty span where a token ends."""
    return source.span(token.end_pos or 0, token.end_pos or 0)


def _open_block(trouble: Trouble, repair: Repair) -> Diagnostic:
    """Returns the diagnostic of a `{` without its `}`, with the likely place of that."""
    tokens = trouble.tokens
    source = trouble.source
    opener, closer = _find_unclosed(tokens[: trouble.at], source)
    if opener is None:
        opener = trouble.stack.open_braces()[0]
    help_ = "write `}` where it ends"
    if repair.times > 1:
        help_ = f"{help_}; {repair.times} are missing in all"
    label: Label | None = None
    fix: Fix | None = None
    outdented = _find_outdented(opener, tokens[: trouble.at + 1], source)
    if outdented is not None and outdented != closer:
        gap = _place_behind(tokens[outdented - 1], source)
        label = Label(gap, "`}` seems to be missing here")
        fix = Fix(gap, " }" * repair.times)
    elif closer is not None:
        span = token_span(tokens[closer], source)
        label = Label(span, "this `}` seems to close a block around it")
    elif trouble.at < len(tokens):
        span = _refused_span(trouble)
        label = Label(span, f"`{tokens[trouble.at]}` cannot stand inside it")
        fix = Fix(_place_behind(tokens[trouble.at - 1], source), " }" * repair.times)
    else:
        fix = Fix(_place_behind(tokens[-1], source), "\n}" * repair.times)
    labels = () if label is None else (label,)
    return errors.OpenBlock(token_span(tokens[opener], source), help=help_, labels=labels, fix=fix)


def _is_outdented(trouble: Trouble) -> bool:
    """Returns whether the refused token begins a line no further right than the open block."""
    tokens = trouble.tokens
    source = trouble.source
    opened = trouble.stack.open_braces()
    if not opened or trouble.at == len(tokens):
        return False
    refused = tokens[trouble.at]
    if not _begins_line(refused, source):
        return False
    return _indent(refused, source) <= _indent(tokens[opened[0]], source)


def _find_unclosed(tokens: Sequence[Token], source: Source) -> tuple[int | None, int | None]:
    """Returns the `{` that is probably not closed, and the `}` that was taken for its own.

    That `}` begins a line further left than the `{`. Blocks around it then end too far left as
    well; so of nested ones it is the innermost, of others the last.
    """
    opened: list[int] = []
    opener: int | None = None
    closer: int | None = None
    for number, token in enumerate(tokens):
        if token.type == "LBRACE":
            opened.append(number)
        elif token.type == "RBRACE" and opened:
            own_opener = opened.pop()
            is_around = opener is not None and own_opener < opener
            if is_around or not _begins_line(token, source):
                continue
            if _indent(token, source) < _indent(tokens[own_opener], source):
                opener = own_opener
                closer = number
    return opener, closer


def _find_outdented(opener: int, tokens: Sequence[Token], source: Source) -> int | None:
    """Returns the first token after a `{` that begins a line no further right than its line.

    None if that is a `}` just below.
    """
    outside = _indent(tokens[opener], source)
    for number, token in enumerate(tokens[opener + 1 :], opener + 1):
        indent = _indent(token, source)
        if indent <= outside and _begins_line(token, source):
            is_own_brace = token.type == "RBRACE" and indent == outside
            return None if is_own_brace else number
    return None


def _find_surplus(tokens: Sequence[Token], source: Source) -> int | None:
    """Returns the first `}` that is probably one too many: the next line is inside its block."""
    opened: list[int] = []
    for number, (token, after) in enumerate(pairwise(tokens)):
        if token.type == "LBRACE":
            opened.append(number)
        elif token.type == "RBRACE" and opened:
            outside = _indent(tokens[opened.pop()], source)
            further = _indent(after, source) - outside
            is_inside = further > 0 or (further == 0 and after.type == "RBRACE")
            if is_inside and _begins_line(after, source):
                return number
    return None


def _indent(token: Token, source: Source) -> int:
    """Returns by how many columns the line of a token is indented; a tab counts as up to 4."""
    start = source.text.rfind("\n", 0, token.start_pos or 0) + 1
    line = source.text[start : token.end_pos].expandtabs(4)
    return len(line) - len(line.lstrip())


def _begins_line(token: Token, source: Source) -> bool:
    """Returns whether only spaces stand before a token in its line."""
    start = source.text.rfind("\n", 0, token.start_pos or 0) + 1
    return not source.text[start : token.start_pos].strip()


def _unexpected(trouble: Trouble, repair: Repair | None) -> Diagnostic:
    """Returns the diagnostic of a token that can't stand where it does."""
    tokens = trouble.tokens
    source = trouble.source
    span = _refused_span(trouble)
    kinds = trouble.stack.accepted()
    expected = expected_text(trouble, kinds)
    fix: Fix | None = None
    labels: tuple[Label, ...] = ()
    hint = statement_slip(trouble, kinds)
    if not hint:
        writable = can_be_written(trouble, kinds)
        hint, _ = slip(trouble.texts[trouble.at], writable)
    help_ = hint or _help_text(trouble, kinds)
    if repair is not None and repair.alone:
        word = trouble.words.get(repair.kind, "")
        is_sign = bool(word) and not word.isalpha()
        match repair.sort:
            case "near":
                word = word or "=="
                help_ = help_ or f"did you mean `{word}`?"
                fix = Fix(span, word)
            case "replace" if is_sign and repair.kind not in COMMITTED:
                expected = f"`{word}`"
                fix = Fix(span, word)
            case "insert" if is_sign:
                expected = f"`{word}`"
                space = "" if word in ")],:." else " "
                fix = Fix(_place_behind(tokens[trouble.at - 1], source), space + word)
            case "insert" if word:
                help_ = help_ or f"write `{word}` before it"
                fix = Fix(source.span(span.start, span.start), f"{word} ")
            case "insert":
                expected = PHRASES.get(repair.kind, expected)
            case "unclose":
                labels = (_one_too_many(tokens[trouble.at - 1], source),)
        if hint and repair.sort != "near":
            fix = None  # the hint is about another change
    if trouble.unmatched < 0:
        surplus = _find_surplus(tokens[: trouble.at + 1], source)
        if surplus is not None:
            labels = (_one_too_many(tokens[surplus], source),)
    labels = labels or _context_labels(trouble, repair)
    actual = "end of the file"
    if trouble.at < len(tokens):
        text = trouble.texts[trouble.at]
        actual = f"`{text}`" if len(text) <= 40 else f"`{text[:37]}...`"
    return errors.Unexpected(
        span, actual=actual, expected=expected, help=help_, labels=labels, fix=fix
    )


def _one_too_many(brace: Token, source: Source) -> Label:
    return Label(token_span(brace, source), "is this `}` one too many?")


def _help_text(trouble: Trouble, kinds: Sequence[str]) -> str:
    """Returns what may have been meant, whatever the repair: another place, a near keyword."""
    kind = trouble.kinds[trouble.at]
    for group, other, help_ in MISPLACED:
        if kind in group and other <= set(kinds):
            return help_
    keywords = near_keywords(trouble, trouble.at, kinds)
    words = [trouble.words.get(keyword, "") for keyword in keywords]
    if not words or words[0] == "":
        return ""
    are_equally_near = len(words) == 1 or len(nearest(trouble.texts[trouble.at], words)) == len(
        words
    )
    if not are_equally_near:
        return ""  # the repair did not take the nearest
    return f"did you mean {either(words)}?"


def _context_labels(trouble: Trouble, repair: Repair | None) -> tuple[Label, ...]:
    """Returns a label for an open bracket, or for the end of a line where something is missing."""
    tokens = trouble.tokens
    source = trouble.source
    kinds = trouble.stack.accepted()
    brackets = trouble.stack.open_marks("LPAR", "RPAR")
    brackets += trouble.stack.open_marks("LSQB", "RSQB")
    written = [number for number in brackets if number >= 0]
    if written and {"RPAR", "RSQB"} & set(kinds):
        return (Label(token_span(tokens[max(written)], source), "opened here"),)
    is_missing = repair is not None and repair.sort == "insert" and "RBRACE" not in kinds
    if is_missing and 0 < trouble.at < len(tokens):
        last = tokens[trouble.at - 1]
        if tokens[trouble.at].line != last.line:
            return (Label(token_span(last, source), "after this"),)
    return ()


def expected_text(trouble: Trouble, kinds: Sequence[str]) -> str:
    """Returns what can stand at a place, as a phrase: groups first, at most a few single words."""
    left = set(kinds)
    phrases = []
    for group, phrase in GROUPS:
        if group <= left:
            phrases.append(phrase)
            left -= group
            if group is VALUES:
                left.discard("NOT")
    if left & {"SIGN", "TIMES"}:
        phrases.append("an operator")
        left -= OPERATORS
    if len(left) + len(phrases) > 1:
        if "DOT" in left:
            left.discard("LPAR")
        left -= {"DOT", "LSQB"}
    phrases += [PHRASES[kind] for kind in PHRASES if kind in left]
    words = trouble.words
    phrases += sorted(f"`{words.get(kind, kind)}`" for kind in left - PHRASES.keys())
    if len(phrases) > LONGEST:
        phrases = [*phrases[: LONGEST - 1], "something else"]
    *first, last = phrases
    return f"{', '.join(first)} or {last}" if first else last
