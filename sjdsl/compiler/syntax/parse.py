"""Parses a text: returns its AST, or every independent syntax error at once.

Source -> ast.File
"""

import os
import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from importlib.resources import files
from pathlib import Path

from lark import Lark, Token, Tree, UnexpectedToken

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import CompileError, Diagnostic, Fix, Label
from sjdsl.compiler.diagnostics.limits import MAX_PROBLEMS, check_text
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.build import build_file
from sjdsl.compiler.syntax.recovery.automaton import (
    END,
    Automaton,
    Stack,
    make_automaton,
    open_marks,
    read,
)
from sjdsl.compiler.syntax.recovery.messages import word_error
from sjdsl.compiler.syntax.recovery.repair import ENOUGH, Repair, Trouble, find_repair
from sjdsl.compiler.syntax.soft_words import SOFT, as_name, as_names, can_come
from sjdsl.compiler.syntax.tokens import Scan, scan

HERE = Path(__file__).parent
VERSION = "1"  # of the language
FIRST_LINE = re.compile(r"^[ \t\r\f\ufeff]*([^\s#].*)$", re.MULTILINE)  # that is no comment


def parse(source: Source) -> ast.File:
    """Returns the tree of one `.sj` text. Raises CompileError with every syntax error it has."""
    found = _parsed(source)
    if isinstance(found, ast.File):
        return found
    raise CompileError(found)


@lru_cache(maxsize=16)  # a game is parsed once, however many of its variants are looked at
def _parsed(source: Source) -> ast.File | tuple[Diagnostic, ...]:
    """Returns the tree of a text, or its syntax errors."""
    try:
        return _file(source)
    except CompileError as error:
        return error.diagnostics


def _file(source: Source) -> ast.File:
    problems = check_text(source)
    if problems:
        raise CompileError(problems)
    wrong_version = _check_version(source)
    if isinstance(wrong_version, errors.NewerLanguage):
        raise CompileError([wrong_version])
    found = scan(source, parser())
    if not wrong_version and not found.problems:
        with suppress(UnexpectedToken):
            _, tree = tree_of(found.tokens)
            return build_file(tree, source)
    raise CompileError(_mistakes(found, wrong_version))


def _mistakes(found: Scan, wrong_version: Diagnostic | None) -> list[Diagnostic]:
    """Returns what is wrong with a text that is no game."""
    if wrong_version and not _skip_to_game(found):
        return [wrong_version]
    others = found.problems or _find_errors(found, has_version=wrong_version is None)
    return [wrong_version, *others] if wrong_version else others


def read_tree(source: Source) -> tuple[list[Token], Tree[Token]]:
    """Returns the tokens of one `.sj` text and the grammar's own tree of them, for its layout. Raises CompileError as `parse` does."""
    parse(source)
    return tree_of(scan(source, parser()).tokens)


@cache
def parser() -> Lark:
    """Returns the parser of the language, made once a process; its tables are kept from one process to the next."""
    folder, kept = (
        HERE / "__pycache__",
        str(HERE / "__pycache__" / "sj.lark.tables"),
    )  # beside the compiled Python files
    with suppress(OSError):
        folder.mkdir(exist_ok=True)
    grammar = files("sjdsl.grammar").joinpath("sj.lark").read_text("utf-8")
    cache = kept if os.access(folder, os.W_OK) else False  # nowhere if nothing can be written there
    return Lark(
        grammar, parser="lalr", lexer="basic", strict=True, propagate_positions=True, cache=cache
    )


@cache
def automaton() -> Automaton:
    """Returns the parser's table, for finding errors."""
    return make_automaton(parser(), SOFT)


def as_read(tokens: list[Token]) -> list[Token]:
    """Returns the tokens of any text, with soft words as names where they are names, as far as it has no error."""
    return as_names(automaton(), tokens)


def _check_version(source: Source) -> Diagnostic | None:
    """Returns what is wrong with the version line; nothing if it is there and for this language."""
    first = FIRST_LINE.search(source.text)
    if first is None:
        but = ": it holds only comments" if "#" in source.text else ": it is empty"
        return errors.NoVersion(source.span(0, 0), known=VERSION, but=but)
    line, start = first.group(1), first.start(1)
    number = re.match(r"sj\s+([0-9][0-9._]*)", line)
    if number and number.group(1) != VERSION:
        return errors.NewerLanguage(
            source.span(start, start + number.end()), version=number.group(1)[:20], known=VERSION
        )
    if number or re.match(r"sj\b", line):
        return None
    word = re.match(r"[\w.]+|.", line).group()[:40]  # type: ignore[union-attr]
    fix = (
        Fix(source.span(start, start), f"sj {VERSION}\n")
        if word in ("game", "agents", "kind")
        else None
    )
    return errors.NoVersion(
        source.span(start, start + len(word)),
        known=VERSION,
        but=f": it begins with `{word}`",
        fix=fix,
    )


def _skip_to_game(found: Scan) -> bool:
    """Drops what stands in place of the version line; returns whether a game follows at all."""
    kinds = [token.type for token in found.tokens[:3]]
    if "GAME" not in kinds:
        return False
    dropped = kinds.index("GAME")
    begin = found.tokens[dropped].start_pos or 0
    found.problems = [problem for problem in found.problems if problem.span.start >= begin]
    del found.tokens[:dropped]
    return True


@dataclass
class Search:
    """The errors found so far; those before token `quiet` may follow from the one before, `owed` braces certainly do."""

    problems: dict[tuple[int, object], Diagnostic] = field(default_factory=dict)
    quiet: int = 0
    owed: int = 0


def _find_errors(found: Scan, has_version: bool) -> list[Diagnostic]:
    """Runs the table over the tokens; at each error a repair is chosen, and reading resumes behind it."""
    table = automaton()
    at, stack = 0, Stack(table.start, None)
    for kind in () if has_version else ("SJ", "INT"):
        stack = read(table, stack, kind) or stack
    kinds = [token.type for token in found.tokens] + [END]
    texts = [str(token) for token in found.tokens] + [""]
    closing = closing_braces(kinds)
    before: Stack | None = None
    search, repairs = Search(), 0
    while repairs < MAX_PROBLEMS:
        if kinds[at] in SOFT:
            found.tokens[at] = as_name(table, stack, found.tokens[at])
            kinds[at] = found.tokens[at].type
        after = read(table, stack, kinds[at], at)
        if after is not None and kinds[at] == END:
            break
        if after is not None:
            before, stack, at = stack, after, at + 1
            continue
        trouble = Trouble(table, kinds, texts, closing, stack, before, at)
        repair = find_repair(trouble)
        _report(search, trouble, repair, found)
        if repair is None:
            break
        before, stack, at, repairs = None, repair.stack, repair.resume, repairs + 1
    return list(search.problems.values())


def _report(search: Search, trouble: Trouble, repair: Repair | None, found: Scan) -> None:
    """Adds an error, unless it follows from one before."""
    change, forgiven = 0, False
    if repair is not None:
        change = _change_of_braces(repair, trouble.kinds)
        opening = {"RPAR": "LPAR", "RSQB": "LSQB"}.get(repair.kind)
        if opening and repair.sort in (
            "insert",
            "replace",
        ):  # what is to be closed was put in by a repair: the author never wrote it
            forgiven = open_marks(trouble.automaton, trouble.stack, opening, repair.kind)[:1] == [
                -1
            ]
    worse = abs(trouble.unmatched + change) > abs(trouble.unmatched)
    forgiven = forgiven or (not worse and change * search.owed < 0)
    search.owed += change if worse or forgiven else 0
    if trouble.at >= search.quiet and not forgiven:
        problem = word_error(trouble, repair, found.tokens, found.source)
        # a reserved word used as a name is one mistake, however often the name is used
        identity = (
            (0, problem.word) if isinstance(problem, errors.ReservedWord) else (1, problem.span)
        )
        known = search.problems.setdefault(identity, problem)
        if isinstance(known, errors.ReservedWord) and known is not problem:
            search.problems[identity] = replace(
                known, labels=(*known.labels, Label(problem.span, "used here, too"))
            )
    search.quiet = 0 if repair is None or repair.is_sure else repair.resume + ENOUGH


def _change_of_braces(repair: Repair, kinds: Sequence[str]) -> int:
    """How many more braces are open after a repair than a reader of the text would think."""
    if repair.sort == "unclose" or (repair.sort == "delete" and kinds[repair.place] == "RBRACE"):
        return 1
    return repair.times * ((repair.kind == "LBRACE") - (repair.kind == "RBRACE"))


def closing_braces(kinds: Sequence[str]) -> list[int]:
    """Returns for each token how many more `}` than `{` there are from it to the end."""
    counts = [0]
    for kind in reversed(kinds):
        counts.append(counts[-1] + (kind == "RBRACE") - (kind == "LBRACE"))
    return counts[::-1]


def tree_of(tokens: list[Token]) -> tuple[list[Token], Tree[Token]]:
    """Returns the tokens of a text without mistakes, soft words as names where only a name can stand, and their tree."""
    reader = parser().parse_interactive("")
    at, resolved = reader.parser_state, list[Token]()
    states = at.parse_conf.parse_table.states
    for token in tokens:
        if (
            token.type in SOFT
            and not can_come(states, at.state_stack, token.type)
            and can_come(states, at.state_stack, "NAME")
        ):
            token = Token.new_borrow_pos("NAME", token, token)
        reader.feed_token(token)
        resolved.append(token)
    tree: Tree[Token] = reader.feed_eof(tokens[-1])
    return resolved, tree
