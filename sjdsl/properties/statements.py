"""The sentences of a game that change something: each with what stands around it, and with what a promise depends on."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from sjdsl.compiler import ir
from sjdsl.properties.effects import Part, reads, written_by
from sjdsl.properties.multiplicity import Quantifier

Place = tuple[str, str, int]  # (the turn of the schedule as written there, the file, where in it): one sentence in one use of a phase
STARTING = "start"


@dataclass(frozen=True)
class Leaf:
    """A sentence that changes something, in one use of its phase.

    around: the domains, guards, chances and values on which it depends whether, and on whom, the sentence works; outermost first.
    quantifiers: those for each of whose members it works.
    """

    place: Place
    sentence: ir.Stmt
    around: tuple[ir.Node, ...]
    quantifiers: tuple[Quantifier, ...] = ()


def place_of(label: str, sentence: ir.Node) -> Place:
    """Returns the name of a sentence in one use of a phase, the same on every map."""
    origin = sentence.origin
    return (label, "", -1) if origin is None else (label, origin.file, origin.start)


def leaves_of(game: ir.Game) -> tuple[Leaf, ...]:
    """Returns the sentences of the phase `start` and of the schedule that change the state, pay, count or end, in that order."""
    found = list(_leaves(game.start.body, STARTING, (), ()))
    for turn in game.schedule:
        if isinstance(turn, ir.Phase):
            found += _leaves(turn.body, turn.label, (), ())
    return tuple(found)


def _leaves(body: Iterable[ir.Stmt], label: str, around: tuple[ir.Node, ...], each: tuple[Quantifier, ...]) -> Iterator[Leaf]:
    for sentence in body:
        match sentence:
            case ir.Let():
                around = (*around, sentence.value)
            case ir.Draw():
                around = (*around, *ir.children(sentence))
            case ir.Each():
                yield from _leaves(sentence.body, label, (*around, sentence.domain), (*each, sentence))
            case ir.First():
                yield from _leaves((*sentence.body, *sentence.otherwise), label, (*around, sentence.domain), (*each, sentence))
            case ir.Pick():
                inside = (*around, sentence.number, sentence.domain)
                yield from _leaves(sentence.body, label, inside, (*each, sentence))
                yield from _leaves(sentence.otherwise, label, inside, each)
            case ir.Match():
                yield from _leaves(sentence.body, label, (*around, sentence.left, sentence.right), (*each, sentence))
            case ir.When() | ir.Chance():
                tests: tuple[ir.Node, ...] = ()
                for branch in sentence.branches:
                    tests = (*tests, branch.test)
                    yield from _leaves(branch.body, label, (*around, *tests), each)
                yield from _leaves(sentence.otherwise, label, (*around, *tests), each)
            case ir.Mark():
                pass  # for the picture only
            case _:
                yield Leaf(place_of(label, sentence), sentence, around, each)


def needed_by(check: ir.Check, game: ir.Game, leaves: Iterable[Leaf]) -> frozenset[Place]:
    """Returns the sentences on which a promise depends: those that write what it reads, those that write what these read, and so on.

    A symmetry speaks of everything that a step does.
    """
    leaves = tuple(leaves)
    if check.sort == "symmetric":
        return frozenset(leaf.place for leaf in leaves)
    wanted: set[Part] = {part for e in check.values for part in reads(e)}
    waiting, found = {i: set(written_by(leaf.sentence)) for i, leaf in enumerate(leaves)}, set()
    while True:
        now = [i for i, written in waiting.items() if written & wanted]
        if not now:
            return frozenset(found)
        for i in now:
            del waiting[i]
            found.add(leaves[i].place)
            wanted |= set(_read_by(leaves[i], game))


def _read_by(leaf: Leaf, game: ir.Game) -> Iterator[Part]:
    """Yields what decides whether, where and with which value a sentence works."""
    nodes = [n for node in (*leaf.around, leaf.sentence) for n in ir.walk(node)]
    for node in (*leaf.around, leaf.sentence):
        yield from reads(node)
    if any(isinstance(n, ir.Chose | ir.Move) for n in nodes):
        for forbid in game.agents.forbids:
            yield from reads(forbid.condition)
    if any(isinstance(n, ir.Near | ir.Move) for n in nodes):
        for block in (b for kind in game.kinds for b in kind.blocks if b.condition is not None):
            yield from reads(block)
