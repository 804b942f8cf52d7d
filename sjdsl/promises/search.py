"""Looks for courses that break a promise, and shrinks them: Hypothesis on the interpreter."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from random import Random

import numpy as np
from hypothesis import HealthCheck, Phase, find, settings
from hypothesis.errors import NoSuchExample, Unsatisfiable
from hypothesis.strategies import randoms

from sjdsl.compiler import ir
from sjdsl.interpreter.state import Value
from sjdsl.promises.course import Course, Played, play
from sjdsl.promises.examples import LONGEST, continued, random_course
from sjdsl.promises.ground import Ground
from sjdsl.promises.shrink import shrink
from sjdsl.promises.verdict import Effort
from sjdsl.promises.watch import STATES, Break, find_break

AGAIN = 0.4  # how often an older course goes on
SELDOM = 3  # so often something happens and still makes a course worth going on with
Breaks = Callable[[ir.Check, Played, Course], Break | None]


@dataclass(frozen=True)
class Broken:
    """A course that breaks a promise: which one (its place among the game's checks), and where."""

    promise: int
    course: Course
    played: Played
    where: Break


@dataclass
class Tried:
    """How many courses were played, `refused` ones, with a map the game does not take, among them; `happened`: what happened how often.

    corpus: courses, cut off where something happened that had seldom happened before. triggers: for each `once`, in how many its first
      condition came.
    """

    played: int = 0
    refused: int = 0
    happened: Counter[object] = field(default_factory=Counter)
    corpus: list[Course] = field(default_factory=list)
    triggers: Counter[int] = field(default_factory=Counter)

    def next(self, ground: Ground, random: Random) -> Course | None:
        """Returns the course to play: a new one, or an older one that goes on. None: its map is refused."""
        self.played += 1
        if self.corpus and random.random() < AGAIN:
            late = max(random.randrange(len(self.corpus)), random.randrange(len(self.corpus)))
            return continued(ground, self.corpus[late], random)
        return random_course(ground, random)

    def keep(self, course: Course, played: Played) -> None:
        """Remembers a course if it has something new."""
        before: set[object] = set()
        for t, here in enumerate(played.happened):
            new = (here | _seen(played, t + 1)) - before
            before |= new
            self.triggers.update(
                number
                for number, check in enumerate(played.game.checks)
                if check.sort == "once" and any((number, 0, first, True) in new for first in (False, True))
            )
            over = played.outcomes[t].terminated or played.outcomes[t].truncated
            if t < LONGEST and not over and any(self.happened[feature] < SELDOM for feature in new):
                self.happened.update(new)
                self.corpus.append(replace(course, actions=tuple(played.actions[: t + 1]), luck=course.luck[: t + 1]))


def _seen(played: Played, at: int) -> set[object]:
    """Returns, roughly, what a state is like: which values fields have somewhere, and what the promises read of it and of the start."""
    world = played.worlds[at]
    fields = [*world.cells.items(), *world.agents.items(), *((name, [value]) for name, value in world.fields.items())]
    found: set[object] = {(name, _rough(value)) for name, values in fields for value in values}
    for number, check in enumerate(played.game.checks):
        if check.sort in STATES:
            ends = zip(played.values_at(check, 0), played.values_at(check, at), strict=True)
            found |= {(number, place, _rough(first), _rough(value)) for place, (first, value) in enumerate(ends)}
    return found


def _rough(value: Value) -> object:
    if isinstance(value, tuple):
        return tuple(map(_rough, value))
    if isinstance(value, frozenset):
        return min(len(value), 2)
    if isinstance(value, str | bool) or value is None:
        return value
    return int(np.sign(value)) * min(2, int(abs(value)))


def breaks_in_states(check: ir.Check, played: Played, course: Course) -> Break | None:
    """Returns where a promise about states breaks in a course."""
    del course
    return find_break(check, played.values(check))


def search(ground: Ground, promises: list[int], effort: Effort, breaks: Breaks = breaks_in_states) -> tuple[list[Broken], Tried]:
    """Returns for each promise that random courses break the simplest course found, and what was played until none broke any more.

    Args:
      promises: places among the game's checks.
      breaks: where a promise breaks in a course.
    """
    left, found, tried = list(promises), [], Tried()
    while left and effort.examples:
        tried = Tried()
        broken = _one(ground, left, effort, breaks, tried)
        if broken is None:
            break
        found.append(broken)
        left.remove(broken.promise)
    return found, tried


def _one(ground: Ground, promises: list[int], effort: Effort, breaks: Breaks, tried: Tried) -> Broken | None:
    """Returns the first course found that breaks one of the promises, made simple."""
    found: list[Broken] = []

    def is_broken(drawn: Random) -> bool:
        if not found:
            course = tried.next(ground, drawn)
            game = None if course is None else ground.on(course.rows, course.agents)
            if course is not None and game is not None:
                played = play(game, course)
                tried.keep(course, played)
                found.extend(_first_broken(played, promises, course, breaks))
            tried.refused += course is None
        return bool(found)

    # Hypothesis could shrink what it draws, too: it needs ten times as long as `shrink`, which knows what a map is.
    chosen = settings(
        max_examples=effort.examples, deadline=None, database=None, phases=(Phase.generate,), suppress_health_check=list(HealthCheck)
    )
    try:
        find(randoms(use_true_random=True), is_broken, settings=chosen, random=Random(effort.seed))
    except (NoSuchExample, Unsatisfiable):
        return None
    return _simplest(ground, found[0], breaks, effort.tries)


def _simplest(ground: Ground, broken: Broken, breaks: Breaks, tries: int) -> Broken:
    """Returns the break of a promise in the simplest course that can be made of one."""

    def attempt(course: Course) -> list[Broken]:
        game = ground.on(course.rows, course.agents)
        if game is None or course.agents not in ground.few_agents:
            return []
        return _first_broken(play(game, course), [broken.promise], course, breaks)

    def shorter(course: Course) -> Course | None:
        found = attempt(course)
        return _written(found[0]) if found else None

    first = shorter(broken.course)
    assert first is not None
    (found,) = attempt(shrink(first, ground.own, ground.glyphs[0], shorter, tries))
    return found


def _written(broken: Broken) -> Course:
    """Returns the course up to its break, with the actions of its policies written down."""
    length = max(1, broken.where.at)
    actions, course = tuple(broken.played.actions[:length]), broken.course
    return replace(course, actions=actions, luck=course.luck[:length], policies=(None,) * course.agents)


def _first_broken(played: Played, promises: list[int], course: Course, breaks: Breaks) -> list[Broken]:
    """Returns the first of the promises that a course breaks, if any."""
    for number in promises:
        where = breaks(played.game.checks[number], played, course)
        if where is not None:
            return [Broken(number, course, played, where)]
    return []
