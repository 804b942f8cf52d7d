"""Recognises idioms of other languages such as `agent.bag += 1`, and tells how to write them here.

Assumes that the table refused a token; an idiom is believed only if what it stands for can be read in its place.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, lru_cache

from lark import Token

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Label
from sjdsl.compiler.diagnostics.frozen import Record
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.recovery.automaton import END, Automaton, Stack, reach, read
from sjdsl.compiler.syntax.recovery.phrases import PHRASES, Phrase
from sjdsl.compiler.syntax.recovery.repair import ENOUGH, ENTRIES, SECTIONS, STATEMENTS, Trouble
from sjdsl.compiler.syntax.tokens import CLOSING, OPENING

FARTHEST = 6  # tokens before the refused one at which an idiom may begin
BEGINNING = (STATEMENTS | SECTIONS | ENTRIES) - {"WHERE", "OTHERWISE"}
# What a part of a phrase is read behind, and what shows that it is complete.
READ_BEHIND = {
    "EXPR": ("sj 1 game x { checks { require", "RBRACE"),
    "DOMAIN": ("sj 1 game x { checks { require count (", "RPAR"),
}

Lex = Callable[[str], list[Token]]


class Idiom(Record):
    """Tokens `start .. end` are a phrase of elsewhere; `instead` stands for them, `kinds` are its tokens, `stack` is behind them."""

    phrase: Phrase
    start: int
    end: int
    instead: str
    help: str
    stack: Stack


def find_idiom(trouble: Trouble, trail: Mapping[int, Stack], tokens: Sequence[Token], source: Source, lex: Lex) -> Idiom | None:
    """Returns the idiom around the refused token; `trail`: the stack before each token that has been read.

    What stands in its place must be readable, and so must what follows. Where several are, the one that begins first.
    """
    for start in range(max(0, trouble.at - FARTHEST), trouble.at + 1):
        stack = trouble.stack if start == trouble.at else trail.get(start)
        if stack is None:
            continue
        for phrase in _beginning_with(str(tokens[start])) if start < len(tokens) else ():
            found = _match(phrase, start, trouble, tokens, source, lex)
            if found is None or not start <= trouble.at <= found[0]:
                continue
            end, parts = found
            idiom = _believed(phrase, (start, end), parts, stack, trouble, lex)
            if idiom is not None:
                return idiom
    return None


@lru_cache(maxsize=1024)
def _beginning_with(word: str) -> tuple[Phrase, ...]:
    """Returns the phrases that may begin with a word, in the order of the table: hundreds do not."""
    return tuple(phrase for phrase in PHRASES if phrase.pattern[0] == word or phrase.pattern[0].isupper())


def _believed(phrase: Phrase, place: tuple[int, int], parts: Sequence[str], stack: Stack, trouble: Trouble, lex: Lex) -> Idiom | None:
    start, end = place
    values: dict[str, str] = {}
    for number, part in enumerate(parts, 1):
        condition = f"({part})" if re.search(r"\b(and|or)\b", part) else part  # in brackets, if it has parts that `not` would not reach
        values |= {f"{number}": part, f"minus{number}": negated(part), f"all{number}": condition}
        values[f"and{number}"] = " and" if " where " in part else " where"
    instead = phrase.write(values)
    kinds = [token.type for token in lex(instead)]
    if not kinds or kinds == list(trouble.kinds[start:end]):
        return None
    after: Stack | None = stack
    for kind in kinds:
        after = None if after is None else read(trouble.automaton, after, kind)
    needed = min(ENOUGH, len(trouble.kinds) - end)
    if after is None or reach(trouble.automaton, after, trouble.kinds, end, needed) < needed:
        return None
    help_ = phrase.explain(values) if phrase.explanation else f"write `{instead}`"
    return Idiom(phrase, start, end, instead, help_, after)


def _match(phrase: Phrase, start: int, trouble: Trouble, tokens: Sequence[Token], source: Source, lex: Lex) -> tuple[int, list[str]] | None:
    """Returns where a phrase ends and the texts of its parts; None if it does not stand here."""
    at, parts = start, []
    for element in phrase.pattern:
        if at >= len(tokens):
            return None
        if element.isupper():
            end = _end_of(element, at, trouble, lex)
            if end == at:
                return None
            text = source.text[tokens[at].start_pos : tokens[end - 1].end_pos]
            parts.append(" ".join(re.sub(r"#[^\n]*", "", text).split()))  # as it is written, on one line and without comments
            at = end
        elif tokens[at] == element:
            at += 1
        else:
            return None
    return at, parts


def _end_of(element: str, at: int, trouble: Trouble, lex: Lex) -> int:
    """Returns where a part of a phrase ends, `at` if it does not stand there."""
    kinds, names = trouble.kinds, {"NAME", *trouble.automaton.soft}
    match element:
        case "NAME":
            return at + (kinds[at] in names)
        case "INT" | "STRING":
            return at + (kinds[at] == element)
        case "PATH":
            if kinds[at] in names:
                at += 1
                while kinds[at] == "DOT" and kinds[at + 1] in names:
                    at += 2
            return at
        case "TURNS" | "NAMES":  # with brackets behind them or not, and commas, arrows of any kind, `then` or nothing between them
            end, texts = at, trouble.texts
            while kinds[at] in names:
                at += 1
                if kinds[at] == "LPAR" and "RPAR" in kinds[at:]:
                    at = at + list(kinds[at:]).index("RPAR") + 1
                end = at
                at += 2 if (texts[at], texts[at + 1 : at + 2]) == ("=", [">"]) else kinds[at] in ("COMMA", "ARROW")
            return end
        case _:
            return _end_of_read(element, at, trouble, lex)


def _end_of_read(element: str, at: int, trouble: Trouble, lex: Lex) -> int:
    """The longest run of tokens that is an expression or a domain."""
    automaton, kinds = trouble.automaton, trouble.kinds
    stack: Stack | None = _stack_behind(automaton, element, lex)
    _, closing = READ_BEHIND[element]
    end, depth = at, 0
    while stack is not None and kinds[at] != END and kinds[at] not in BEGINNING:
        depth += (kinds[at] in OPENING) - (kinds[at] in CLOSING)
        if depth < 0:
            break
        stack = read(automaton, stack, kinds[at])
        at += 1
        if stack is not None and read(automaton, stack, closing) is not None:
            end = at
    return end


@cache
def _stack_behind(automaton: Automaton, element: str, lex: Lex) -> Stack:
    stack: Stack | None = Stack(automaton.start, None)
    for token in lex(READ_BEHIND[element][0]):
        stack = None if stack is None else read(automaton, stack, token.type)
    assert stack is not None
    return stack


def negated(value: str) -> str:
    """Returns an expression with the other sign."""
    if value.startswith("-") and value[1:].replace(".", "").isalnum():
        return value[1:]
    return f"-{value}" if re.fullmatch(r"[\w.\[\]]+", value) else f"-({value})"


def idiom_error(idiom: Idiom, diagnostic: Diagnostic, tokens: Sequence[Token], source: Source) -> Diagnostic:
    """Returns a diagnostic that says how the phrase is written here."""
    begin, end = tokens[idiom.start].start_pos or 0, tokens[idiom.end - 1].end_pos or 0
    fix = Fix(source.span(begin, end), idiom.instead)
    last = tokens[idiom.end - 1]
    behind = (last.line or 0) < diagnostic.span.line
    labels = (Label(source.span(last.start_pos or 0, end), "after this"),) if behind else ()
    return replace(diagnostic, help=idiom.help, labels=labels, fix=fix)
