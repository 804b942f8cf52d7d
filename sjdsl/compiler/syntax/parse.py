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
from sjdsl.compiler.syntax.recovery.automaton import END, Automaton, Stack, make_automaton
from sjdsl.compiler.syntax.recovery.messages import word_error
from sjdsl.compiler.syntax.recovery.repair import ENOUGH, Repair, Trouble, find_repair
from sjdsl.compiler.syntax.soft_words import SOFT, as_name, as_names
from sjdsl.compiler.syntax.tokens import Scan, scan

HERE = Path(__file__).parent
VERSION = "1"  # of the language
# The first line that isn't empty and no comment.
FIRST_LINE = re.compile(r"^[ \t\r\f\ufeff]*([^\s#].*)$", re.MULTILINE)


def parse(source: Source) -> ast.File:
    """Returns the tree of one `.sj` text. Raises CompileError with every syntax error it has."""
    result = _parse_once(source)
    if isinstance(result, ast.File):
        return result
    raise CompileError(result)


@lru_cache(maxsize=16)  # a game is parsed once, however many of its variants are looked at
def _parse_once(source: Source) -> ast.File | tuple[Diagnostic, ...]:
    """Returns the tree of a text, or its syntax errors."""
    try:
        return _parse(source)
    except CompileError as error:
        return error.diagnostics


def _parse(source: Source) -> ast.File:
    """Returns the tree of a text. Raises CompileError."""
    problems = check_text(source)
    if problems:
        raise CompileError(problems)
    version_problem = _check_version(source)
    if isinstance(version_problem, errors.NewerLanguage):
        raise CompileError([version_problem])
    scanned = scan(source, parser())
    if not version_problem and not scanned.problems:
        with suppress(UnexpectedToken):
            _, tree = tree_of(scanned.tokens)
            return build_file(tree, source)
    raise CompileError(_mistakes(scanned, version_problem))


def _mistakes(scanned: Scan, version_problem: Diagnostic | None) -> list[Diagnostic]:
    """Returns what is wrong with a text that is no game."""
    if version_problem and not _skip_to_game(scanned):
        return [version_problem]
    others = scanned.problems or _find_errors(scanned, has_version=version_problem is None)
    return [version_problem, *others] if version_problem else others


def read_tree(source: Source) -> tuple[list[Token], Tree[Token]]:
    """Returns the tokens of one `.sj` text and the grammar's own tree of them, for its layout.

    Raises CompileError as `parse` does.
    """
    parse(source)
    return tree_of(scan(source, parser()).tokens)


@cache
def parser() -> Lark:
    """Returns the parser of the language, made once a process.

    Its tables are kept on the disk, beside the compiled Python files if these can be written.
    """
    folder = HERE / "__pycache__"
    with suppress(OSError):
        folder.mkdir(exist_ok=True)
    cache = str(folder / "sj.lark.tables") if os.access(folder, os.W_OK) else False
    grammar = files("sjdsl.grammar").joinpath("sj.lark").read_text("utf-8")
    return Lark(
        grammar, parser="lalr", lexer="basic", strict=True, propagate_positions=True, cache=cache
    )


@cache
def automaton() -> Automaton:
    """Returns the parser's table, for finding errors."""
    return make_automaton(parser(), SOFT)


def as_read(tokens: list[Token]) -> list[Token]:
    """Returns the tokens of any text up to its first error, soft words as names where they are."""
    return as_names(automaton(), tokens)


def _check_version(source: Source) -> Diagnostic | None:
    """Returns what is wrong with the version line; None if it is there and for this language."""
    first = FIRST_LINE.search(source.text)
    if first is None:
        content = ": it holds only comments" if "#" in source.text else ": it is empty"
        return errors.NoVersion(source.span(0, 0), known=VERSION, but=content)
    line = first.group(1)
    start = first.start(1)
    number = re.match(r"sj\s+([0-9][0-9._]*)", line)
    if number and number.group(1) != VERSION:
        span = source.span(start, start + number.end())
        return errors.NewerLanguage(span, version=number.group(1)[:20], known=VERSION)
    if number or re.match(r"sj\b", line):
        return None
    match = re.match(r"[\w.]+|.", line)
    assert match is not None
    word = match.group()[:40]
    fix = None
    if word in ("game", "agents", "kind"):
        fix = Fix(source.span(start, start), f"sj {VERSION}\n")
    span = source.span(start, start + len(word))
    return errors.NoVersion(span, known=VERSION, but=f": it begins with `{word}`", fix=fix)


def _skip_to_game(scanned: Scan) -> bool:
    """Drops what stands in place of the version line; returns whether a game follows at all."""
    kinds = [token.type for token in scanned.tokens[:3]]
    if "GAME" not in kinds:
        return False
    dropped = kinds.index("GAME")
    begin = scanned.tokens[dropped].start_pos or 0
    scanned.problems = [problem for problem in scanned.problems if problem.span.start >= begin]
    del scanned.tokens[:dropped]
    return True


@dataclass
class Search:
    """The errors found so far.

    quiet: errors before this token may follow from the one before, and aren't reported.
    owed: how many braces too many (below 0: too few) the repairs have put in. An error whose repair
    takes one of these back follows from them.
    """

    problems: dict[tuple[int, object], Diagnostic] = field(default_factory=dict)
    quiet: int = 0
    owed: int = 0


def _find_errors(scanned: Scan, has_version: bool) -> list[Diagnostic]:
    """Runs the table over the tokens, past a repair of each error."""
    at = 0
    stack = automaton().stack()
    if not has_version:  # as if the version line were there
        for kind in ("SJ", "INT"):
            stack = stack.read(kind) or stack
    tokens = scanned.tokens
    kinds = [token.type for token in tokens] + [END]
    texts = [str(token) for token in tokens] + [""]
    closing = closing_braces(kinds)
    before: Stack | None = None
    search = Search()
    repairs = 0
    while repairs < MAX_PROBLEMS:
        if kinds[at] in SOFT:
            tokens[at] = as_name(stack, tokens[at])
            kinds[at] = tokens[at].type
        after = stack.read(kinds[at], at)
        if after is not None:
            if kinds[at] == END:
                break
            before = stack
            stack = after
            at += 1
            continue
        trouble = Trouble(scanned.source, tokens, kinds, texts, closing, stack, before, at)
        repair = find_repair(trouble)
        _report(search, trouble, repair)
        if repair is None:
            break
        before = None
        stack = repair.stack
        at = repair.resume
        repairs += 1
    return list(search.problems.values())


def _report(search: Search, trouble: Trouble, repair: Repair | None) -> None:
    """Adds an error, unless it follows from one before."""
    change = 0  # of the number of open braces
    follows = False
    if repair is not None:
        change = _change_of_braces(repair, trouble.kinds)
        follows = _closes_repaired_bracket(repair, trouble)
    is_worse = abs(trouble.unmatched + change) > abs(trouble.unmatched)
    if not is_worse and change * search.owed < 0:
        follows = True
    if is_worse or follows:
        search.owed += change
    if trouble.at >= search.quiet and not follows:
        _add(search, word_error(trouble, repair))
    search.quiet = 0 if repair is None or repair.is_sure else repair.resume + ENOUGH


def _closes_repaired_bracket(repair: Repair, trouble: Trouble) -> bool:
    """Returns whether a repair closes a bracket that another one put in."""
    opening = {"RPAR": "LPAR", "RSQB": "LSQB"}.get(repair.kind)
    if opening is None or repair.sort not in ("insert", "replace"):
        return False
    opened = trouble.stack.open_marks(opening, repair.kind)
    return opened[:1] == [-1]


def _add(search: Search, problem: Diagnostic) -> None:
    """Adds an error, one for each place of the text.

    A reserved word used as a name is one error, with a label at each further place.
    """
    key: tuple[int, object] = (1, problem.span)
    if isinstance(problem, errors.ReservedWord):
        key = (0, problem.word)
    first = search.problems.setdefault(key, problem)
    if isinstance(first, errors.ReservedWord) and first is not problem:
        labels = (*first.labels, Label(problem.span, "used here, too"))
        search.problems[key] = replace(first, labels=labels)


def _change_of_braces(repair: Repair, kinds: Sequence[str]) -> int:
    """Returns how many more braces are open after a repair than a reader would think."""
    if repair.sort == "unclose" or (repair.sort == "delete" and kinds[repair.place] == "RBRACE"):
        return 1
    return repair.times * {"LBRACE": 1, "RBRACE": -1}.get(repair.kind, 0)


def closing_braces(kinds: Sequence[str]) -> list[int]:
    """Returns for each token how many more `}` than `{` there are from it to the end."""
    counts = [0]
    for kind in reversed(kinds):
        counts.append(counts[-1] + {"RBRACE": 1, "LBRACE": -1}.get(kind, 0))
    return counts[::-1]


def tree_of(tokens: list[Token]) -> tuple[list[Token], Tree[Token]]:
    """Returns the tokens of a text without mistakes and their tree.

    Soft words are names where only a name can come.
    """
    reader = parser().parse_interactive("")
    resolved: list[Token] = []
    for token in tokens:
        if token.type in SOFT:
            _, *states = reader.parser_state.state_stack
            token = as_name(automaton().stack(states), token)
        reader.feed_token(token)
        resolved.append(token)
    tree: Tree[Token] = reader.feed_eof(tokens[-1])
    return resolved, tree
