"""Words a syntax error for its author: what was found, what could have stood there, and what to write."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import count, pairwise

from lark import Token

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Label
from sjdsl.compiler.diagnostics.slips import slip
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.syntax.recovery.automaton import END, accepted, open_braces, open_marks
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
OPERATORS = frozenset(("CMP", "SIGN", "TIMES", "AND", "OR", "IS", "IN", "ON", "CHOSE"))
LONGEST = 7  # things named as expected


def word_error(
    trouble: Trouble, repair: Repair | None, tokens: Sequence[Token], source: Source
) -> Diagnostic:
    """Returns the diagnostic of one syntax error, as the repair explains it best."""
    if repair is not None and repair.place < trouble.at and trouble.before is not None:
        trouble = replace(trouble, stack=trouble.before, before=None, at=repair.place)
    if repair is not None and repair.sort == "name":
        word = str(tokens[repair.place])
        other = f"{word}_"  # a name that the file does not have yet
        other = (
            other
            if other not in tokens
            else next(name for number in count(2) if (name := f"{other}_{number}") not in tokens)
        )
        return errors.ReservedWord(_refused_span(trouble, tokens, source), word=word, other=other)
    closing = repair is not None and repair.kind == "RBRACE" and repair.sort in ("close", "insert")
    if (
        repair is not None
        and closing
        and (trouble.unmatched or _is_outdented(trouble, tokens, source))
    ):
        return _open_block(trouble, repair, tokens, source)
    return _unexpected(trouble, repair, tokens, source)


def token_span(token: Token, source: Source) -> Span:
    return Span(
        source.name, token.start_pos or 0, token.end_pos or 0, token.line or 1, token.column or 1
    )


def _refused_span(trouble: Trouble, tokens: Sequence[Token], source: Source) -> Span:
    """The span of the refused token; at the end of the file, the place behind the last token."""
    if trouble.at < len(tokens):
        return token_span(tokens[trouble.at], source)
    return _behind(tokens[-1], source) if tokens else source.span(0, 0)


def _behind(token: Token, source: Source) -> Span:
    return source.span(token.end_pos or 0, token.end_pos or 0)


def _open_block(
    trouble: Trouble, repair: Repair, tokens: Sequence[Token], source: Source
) -> Diagnostic:
    opener, closer = _suspect(tokens[: trouble.at], source)
    opener = open_braces(trouble.automaton, trouble.stack)[0] if opener is None else opener
    help_ = "write `}` where it ends"
    if repair.times > 1:
        help_ += f"; {repair.times} are missing in all"
    labels: tuple[Label, ...] = ()
    fix: Fix | None = None
    left = _left_of(opener, tokens[: trouble.at + 1], source)
    if left is not None and left != closer:
        labels = (Label(_behind(tokens[left - 1], source), "`}` seems to be missing here"),)
        fix = Fix(_behind(tokens[left - 1], source), " }" * repair.times)
    elif closer is not None:
        labels = (
            Label(token_span(tokens[closer], source), "this `}` seems to close a block around it"),
        )
    elif trouble.at < len(tokens):
        labels = (
            Label(
                _refused_span(trouble, tokens, source),
                f"`{tokens[trouble.at]}` cannot stand inside it",
            ),
        )
        fix = Fix(_behind(tokens[trouble.at - 1], source), " }" * repair.times)
    else:
        fix = Fix(_behind(tokens[-1], source), "\n}" * repair.times)
    return errors.OpenBlock(token_span(tokens[opener], source), help=help_, labels=labels, fix=fix)


def _is_outdented(trouble: Trouble, tokens: Sequence[Token], source: Source) -> bool:
    """Whether the refused token begins a line no further right than the line of the innermost open brace."""
    opened = open_braces(trouble.automaton, trouble.stack)
    if not opened or trouble.at == len(tokens) or not _begins_line(tokens[trouble.at], source):
        return False
    return _indent(tokens[trouble.at], source) <= _indent(tokens[opened[0]], source)


def _suspect(tokens: Sequence[Token], source: Source) -> tuple[int | None, int | None]:
    """Returns the `{` that is probably not closed, and the `}` taken for its own: one that begins a line further left.

    Blocks around it then end too far left as well; so of nested ones it is the innermost, of others the last.
    """
    opened: list[int] = []
    suspect: tuple[int | None, int | None] = (None, None)
    for number, token in enumerate(tokens):
        if token.type == "LBRACE":
            opened.append(number)
        elif token.type == "RBRACE" and opened:
            opener = opened.pop()
            around = suspect[0] is not None and opener < suspect[0]
            if (
                not around
                and _begins_line(token, source)
                and _indent(token, source) < _indent(tokens[opener], source)
            ):
                suspect = (opener, number)
    return suspect


def _left_of(opener: int, tokens: Sequence[Token], source: Source) -> int | None:
    """Returns the first token behind a `{` that begins a line no further right than the line of the `{`, unless it is a `}` there."""
    for number in range(opener + 1, len(tokens)):
        token = tokens[number]
        if _begins_line(token, source) and _indent(token, source) <= _indent(
            tokens[opener], source
        ):
            return (
                None
                if token.type == "RBRACE"
                and _indent(token, source) == _indent(tokens[opener], source)
                else number
            )
    return None


def _surplus(tokens: Sequence[Token], source: Source) -> int | None:
    """Returns the first `}` that is probably one too many: it ends a block though the next line stands inside it."""
    opened: list[int] = []
    for number, (token, after) in enumerate(pairwise(tokens)):
        if token.type == "LBRACE":
            opened.append(number)
        elif token.type == "RBRACE" and opened:
            outside = _indent(tokens[opened.pop()], source)
            inside = _indent(after, source) - outside
            if _begins_line(after, source) and (
                inside > 0 or (inside == 0 and after.type == "RBRACE")
            ):
                return number
    return None


def _indent(token: Token, source: Source) -> int:
    line = source.text[
        source.text.rfind("\n", 0, token.start_pos or 0) + 1 : token.end_pos
    ].expandtabs(4)
    return len(line) - len(line.lstrip())


def _begins_line(token: Token, source: Source) -> bool:
    start = source.text.rfind("\n", 0, token.start_pos or 0) + 1
    return not source.text[start : token.start_pos].strip()


def _unexpected(
    trouble: Trouble, repair: Repair | None, tokens: Sequence[Token], source: Source
) -> Diagnostic:
    here = _refused_span(trouble, tokens, source)
    kinds = accepted(trouble.automaton, trouble.stack)
    expected, fix = expected_text(trouble, kinds), None
    labels: tuple[Label, ...] = ()
    hint = (
        statement_slip(trouble, kinds)
        or slip(trouble.texts[trouble.at], can_be_written(trouble.automaton, kinds))[0]
    )
    help_ = hint or _help(trouble, kinds)
    if repair is not None and repair.alone:
        word = trouble.automaton.words.get(repair.kind, "")
        match repair.sort:
            case "near":
                word = word or "=="
                help_, fix = help_ or f"did you mean `{word}`?", Fix(here, word)
            case "replace" if word and not word.isalpha() and repair.kind not in COMMITTED:
                expected = f"`{word}`"
                fix = Fix(here, word)
            case "insert" if word and not word.isalpha():
                gap = _behind(tokens[trouble.at - 1], source)
                expected, fix = f"`{word}`", Fix(gap, word if word in ")],:." else f" {word}")
            case "insert" if word:
                help_, fix = (
                    help_ or f"write `{word}` before it",
                    Fix(source.span(here.start, here.start), f"{word} "),
                )
            case "insert":
                expected = PHRASES.get(repair.kind, expected)
            case "unclose":
                labels = (
                    Label(token_span(tokens[trouble.at - 1], source), "is this `}` one too many?"),
                )
        if hint and repair.sort != "near":
            fix = None  # the hint tells of another change
    surplus = _surplus(tokens[: trouble.at + 1], source) if trouble.unmatched < 0 else None
    if surplus is not None:
        labels = (Label(token_span(tokens[surplus], source), "is this `}` one too many?"),)
    labels = labels or _context(trouble, repair, tokens, source)
    text = trouble.texts[trouble.at]
    found = (
        "end of the file"
        if trouble.at == len(tokens)
        else f"`{text}`"
        if len(text) <= 40
        else f"`{text[:37]}...`"
    )
    return errors.Unexpected(
        here, actual=found, expected=expected, help=help_, labels=labels, fix=fix
    )


def _help(trouble: Trouble, kinds: Sequence[str]) -> str:
    """Returns what may have been meant, whatever the repair: another place, a near keyword."""
    kind = trouble.kinds[trouble.at]
    for group, other, help_ in MISPLACED:
        if kind in group and other <= set(kinds):
            return help_
    near = [
        trouble.automaton.words.get(kind, "") for kind in near_keywords(trouble, trouble.at, kinds)
    ]
    if len(near) > 1 and len(nearest(trouble.texts[trouble.at], near)) < len(
        near
    ):  # of which one is as good as the other
        return ""
    return f"did you mean {either(near)}?" if near and near[0] else ""


def _context(
    trouble: Trouble, repair: Repair | None, tokens: Sequence[Token], source: Source
) -> tuple[Label, ...]:
    """Points at an open bracket that should have been closed, or at the end of the line before if something is missing there."""
    brackets = open_marks(trouble.automaton, trouble.stack, "LPAR", "RPAR")
    brackets += open_marks(trouble.automaton, trouble.stack, "LSQB", "RSQB")
    brackets = [number for number in brackets if number >= 0]
    if brackets and {"RPAR", "RSQB"} & set(accepted(trouble.automaton, trouble.stack)):
        return (Label(token_span(tokens[max(brackets)], source), "opened here"),)
    missing = (
        repair is not None
        and repair.sort == "insert"
        and "RBRACE" not in accepted(trouble.automaton, trouble.stack)
    )
    if (
        missing
        and 0 < trouble.at < len(tokens)
        and tokens[trouble.at].line != tokens[trouble.at - 1].line
    ):
        return (Label(token_span(tokens[trouble.at - 1], source), "after this"),)
    return ()


def expected_text(trouble: Trouble, kinds: Sequence[str]) -> str:
    """Returns what can stand at a place, as a phrase: groups first, at most a few single words."""
    left = set(kinds)
    phrases = []
    for group, phrase in (
        (STATEMENTS, "a statement"),
        (SECTIONS, "a declaration"),
        (VALUES, "a value"),
    ):
        if group <= left:
            phrases.append(phrase)
            left -= group | ({"NOT"} if group is VALUES else set())
    if left & {"SIGN", "TIMES"}:
        phrases.append("an operator")
        left -= OPERATORS
    if len(left) + len(phrases) > 1:
        left -= {"DOT", "LSQB"} | ({"LPAR"} if "DOT" in left else set())
    phrases += [PHRASES[kind] for kind in PHRASES if kind in left]
    phrases += sorted(
        f"`{trouble.automaton.words.get(kind, kind)}`" for kind in left - PHRASES.keys()
    )
    if len(phrases) > LONGEST:
        phrases = [*phrases[: LONGEST - 1], "something else"]
    return " or ".join(filter(None, (", ".join(phrases[:-1]), phrases[-1])))
