"""Makes a failing program small: parts of its text are left out, or give way to what is inside them, as long as it still fails."""

from collections.abc import Callable, Iterator
from dataclasses import replace

from lark import Token, Tree

from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import read_tree
from tests.fuzz.programs import Program

Fails = Callable[[Program], bool]
NEVER_ALONE = ("start", "game", "map", "rows", "acts", "unit", "schedule")  # a game needs them


def reduced(program: Program, fails: Fails, tries: int = 3000) -> Program:
    """Returns a program that fails in the same way and from which nothing more can be left out (or for which the tries ran out)."""
    if program.variants and fails(replace(program, variants=())):
        program = replace(program, variants=())
    for name in list(program.files):
        fewer = replace(program, files={n: t for n, t in program.files.items() if n != name})
        program = fewer if fails(fewer) else program
    left = tries
    while left > 0:
        before = program
        for name in ("", *program.files):
            text, left = _reduced_text(
                _text(program, name),
                lambda t, n=name: fails(_with(program, n, t)),  # noqa: B023
                left,
            )
            program = _with(program, name, text)
        if program == before:
            break
    return program


def _text(program: Program, name: str) -> str:
    return program.files[name] if name else program.text


def _with(program: Program, name: str, text: str) -> Program:
    return (
        replace(program, files={**program.files, name: text})
        if name
        else replace(program, text=text)
    )


def _reduced_text(text: str, fails: Callable[[str], bool], left: int) -> tuple[str, int]:
    """Goes through the nodes of the text's tree, the largest first; after each success the tree is made anew."""
    seen: set[str] = {text}
    number = 0
    while left > 0:
        nodes = _nodes(text)
        if number >= len(nodes):
            break
        for candidate in _smaller(nodes[number], text):
            if candidate in seen or len(candidate) >= len(text) or not _parses(candidate):
                continue
            seen.add(candidate)
            left -= 1
            if fails(candidate):
                text = candidate
                break
        else:
            number += 1
    return text, left


def _nodes(text: str) -> list[Tree[Token]]:
    try:
        tree = read_tree(Source("game.sj", text))[1]
    except CompileError:
        return []  # a map in a file of its own
    found = [
        n
        for n in tree.iter_subtrees_topdown()
        if n.data not in ("start", "game") and not n.meta.empty
    ]
    return sorted(found, key=lambda n: n.meta.start_pos - n.meta.end_pos)


def _parses(text: str) -> bool:
    try:
        read_tree(Source("game.sj", text))
    except CompileError:
        return False
    return True


def _smaller(node: Tree[Token], text: str) -> Iterator[str]:
    """Yields the text without a node, with a part of the node in its place, or with a plain number."""
    start, end = node.meta.start_pos, node.meta.end_pos
    before, after = text[:start], text[end:]
    yield before.rstrip() + "\n" + after if node.data not in NEVER_ALONE else text
    if before.rstrip().endswith(","):
        yield before.rstrip()[:-1] + after
    if after.lstrip().startswith(","):
        yield before + after.lstrip()[1:]
    for part in node.iter_subtrees():
        if part is node or part.meta.empty:
            continue
        inside = text[part.meta.start_pos : part.meta.end_pos]
        if part.data == "block":
            yield f"{before} {inside.strip()[1:-1]} {after}"
        yield before + inside + after
    for plain in ("1", "0.5", "nobody"):
        yield before + plain + after
