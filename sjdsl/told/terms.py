"""The defines of a game that its text explains once: those that rules use twice, or long ones."""

from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.compiler.ir.free_variables import Variable, free_variables, renamed
from sjdsl.doc.wording import joined
from sjdsl.told.naming import Naming
from sjdsl.told.phrases import English

PLACEHOLDERS = "xyzuvw"
LONGEST = 60  # characters of a define's English that may stand in a rule


@dataclass(frozen=True)
class Meaning:
    """What a define means.

    names: what it is about, as it is called in `text`; nouns: what each of these is.
    """

    names: tuple[str, ...]
    nouns: tuple[str, ...]
    text: str


def with_terms(naming: Naming, parts: tuple[ir.Node, ...]) -> Naming:
    """Returns the naming with the terms of these parts of the rules."""
    english = English(naming)
    uses: dict[str, list[str]] = {}
    for node in _named(parts):
        if not _is_constant(node, english):
            uses.setdefault(node.name, []).append(_meaning(node, english).text)
    terms = {
        name
        for name, found in uses.items()
        if len(set(found)) == 1 and (len(found) > 1 or len(found[0]) > LONGEST)
    }
    return Naming(naming.game, naming.values, frozenset(terms))


def explained(naming: Naming, parts: tuple[ir.Node, ...]) -> list[str]:
    """Returns a sentence on each term, in the order in which the rules use them.

    Such as `near(x) of a tree cell x is …`, or `blocked(x, y) of agent x, agent y holds if …`.
    """
    english = English(naming)
    found: dict[str, list[Meaning]] = {}
    is_condition = {}
    for node in _named(parts):
        if node.name in naming.terms:
            found.setdefault(node.name, []).append(_meaning(node, english))
            is_condition[node.name] = node.type.kind == "condition"
    lines = []
    for name, meanings in found.items():
        names = meanings[0].names
        columns = zip(*(meaning.nouns for meaning in meanings), strict=True)
        nouns = [_one_noun(set(column)) for column in columns]
        both = zip(nouns, names, strict=True)
        about = f" of {joined(f'{noun} {letter}' for noun, letter in both)}" if names else ""
        arguments = f"({', '.join(names)})" if names else ""
        verb = "holds if" if is_condition[name] else "is"
        lines.append(f"{name}{arguments}{about} {verb} {meanings[0].text}")
    return lines


def _one_noun(nouns: set[str]) -> str:
    """Returns the noun of what a define is about in all its uses."""
    if len(nouns) == 1:
        return nouns.pop()
    return "cell" if all("cell" in noun for noun in nouns) else "thing"


def _named(parts: tuple[ir.Node, ...]) -> list[ir.Named]:
    return [node for part in parts for node in ir.walk(part) if isinstance(node, ir.Named)]


def _is_constant(node: ir.Named, english: English) -> bool:
    return node.name.startswith("count(") or english.constant(node) is not None


def _meaning(node: ir.Named, english: English) -> Meaning:
    general, letters = _generalised(node)
    nouns = [
        english.naming.noun(free) if isinstance(free, ir.Member) else "a value"
        for free, _ in letters
    ]
    text = english.text(general)
    return Meaning(tuple(name for _, name in letters), tuple(nouns), text)


def _generalised(node: ir.Named) -> tuple[ir.Expr, list[tuple[Variable, str]]]:
    """Returns a define's value with `x`, `y`, … for what it is about, and what each stands for.

    Variables beyond the number of letters keep their names.
    """
    taken = {n.name for n in ir.walk(node.value) if isinstance(n, ir.Member | ir.Local)}
    letters = (letter for letter in PLACEHOLDERS if letter not in taken)
    variables = free_variables(node.value)
    letter_of = {variable.name: next(letters, variable.name) for variable in variables}
    names = [(variable, letter_of[variable.name]) for variable in variables]
    return renamed(node.value, letter_of), names
