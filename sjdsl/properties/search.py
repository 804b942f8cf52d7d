"""Looks for courses that break a promise, guided by what has not happened yet, and shrinks them; all on the interpreter."""

import math
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from sjdsl.compiler import ir
from sjdsl.interpreter.state import World
from sjdsl.properties.biased_words import LUCKS
from sjdsl.properties.corpus import Corpus, Kept
from sjdsl.properties.coverage import MANY, places_run
from sjdsl.properties.distance import Chains, Distances
from sjdsl.properties.goals import random_stretch
from sjdsl.properties.instances import Ground
from sjdsl.properties.monitors import STATES, Break, find_break
from sjdsl.properties.multiplicity import is_always_once
from sjdsl.properties.preconditions import NEVER, Goal, Recipe, recipes_of
from sjdsl.properties.random_starts import own_start, random_start
from sjdsl.properties.shrinking import shrink
from sjdsl.properties.statements import STARTING, Place, leaves_of
from sjdsl.properties.trajectory import Course, Played, play
from sjdsl.properties.verdict import Effort

AGAIN = 0.75  # how often an older course goes on
ERRANDS = 0.75  # how often agents have errands
CLOSEST = 0.6  # how often these go on from the course nearest to what they are for
OWN = 0.05  # how often, while lines are missing after all courses asked for, one begins on the game's own map
MOST_STEPS = 18  # in one stretch of a course towards a goal
FEW_STEPS = 10  # of those without a goal, or with one that was often reached or often missed
LEAST_STEPS = 10  # of the others
SELDOM = 10  # so often a goal is reached and courses still look for it by its distance
GIVEN_UP = 24  # so often a goal is missed, since a course came nearer to it than ever before, and then no more
VAIN = 1.0  # how fast a goal is given up, the more often courses came no nearer to it
NEARER = 0.5  # by so much a course comes nearer to a goal if it has done something towards it, and not only gone there
STARTS = 4  # starts of which one is looked for from which there is a way to a goal
GOALS = 4  # goals that are tried until there is a way to one
LONGEST = 64  # steps added to a course while it comes nearer to a goal
FLOATS = -1  # stands for the promise that every real stays inside float32
Breaks = Callable[[ir.Check, Played, Course, int], Break | None]  # the last one: the first state that is new


@dataclass(frozen=True)
class Broken:
    """A course that breaks a promise: which one (its place among the game's checks, or FLOATS), and where."""

    promise: int
    course: Course
    played: Played
    where: Break


@dataclass
class Tried:
    """How many courses were played, `refused` ones, with a map the game does not take, among them; `ran`: how often each sentence did.

    triggers: for each `once`, in how many courses its first condition held.
    """

    played: int = 0
    refused: int = 0
    ran: Counter[Place] = field(default_factory=Counter)
    corpus: Corpus = field(default_factory=Corpus)
    triggers: Counter[int] = field(default_factory=Counter)


def breaks_in_states(check: ir.Check, played: Played, course: Course, since: int) -> Break | None:
    """Returns where a promise about states breaks in a course."""
    del course, since
    return find_break(check, played.values(check))


class Search:
    """Courses played for some promises of a game together, until all are broken or there have been enough."""

    def __init__(self, ground: Ground, promises: list[int], effort: Effort, breaks: Breaks, needed: Mapping[int, Collection[Place]]):
        self.ground, self.effort, self.breaks = ground, effort, breaks
        self.left, self.found, self.tried = list(promises), list[Broken](), Tried()
        self.recipes = recipes_of(leaves_of(ground.own))
        self._needed, self._random = dict(needed), Random(effort.seed)
        self._chains = Chains(self.recipes)
        self._beside = _blocks(self.recipes)
        self._aims = [i for i in self._beside if self.recipes[i].place[0] != STARTING] or list(self._beside)
        self._latest: tuple[World, Distances] | None = None
        self._nearest = dict[Goal, float]()
        self._vain = Counter[Goal | None]()

    def run(self) -> None:
        """Plays as many courses as asked for, and up to as many again while lines that promises depend on never ran."""
        while self.tried.played < 2 * self.effort.examples:
            missing = {place for places in self._needed.values() for place in places} - set(self.tried.ran)
            if not missing and (not self.left or self.tried.played >= self.effort.examples):
                break
            self.one(missing if self.tried.played >= self.effort.examples else set())

    def one(self, missing: Collection[Place] = ()) -> None:
        """Plays one more stretch of a course."""
        self.tried.played += 1
        random = self._random
        goal = self._choose_goal(missing) if self.recipes and random.random() < ERRANDS else None
        begun = self._begin(bool(missing), goal, random.random() < CLOSEST)
        if begun is None:
            self.tried.refused += 1
            return
        course, since = begun
        if self._is_hot(goal) and self.tried.corpus.kept and self._distance(since, goal) == math.inf:
            older = self.tried.corpus.choose(random, self._chains, goal)
            course, since = older.course, older.played
        played = since
        if since.worlds and not since.is_over:
            for _ in range(GOALS):
                if not self._is_hot(goal) or self._distance(since, goal) < math.inf:
                    break
                goal = self._choose_goal(missing)
            course, played = self._go_on(course, since, goal)
        self._look(course, played, len(since.outcomes))

    def _go_on(self, course: Course, played: Played, goal: Goal | None) -> tuple[Course, Played]:
        """Returns a course with one more stretch; with several as long as each comes nearer to the goal."""
        game, random, corpus = played.game, self._random, self.tried.corpus
        hot = self._is_hot(goal)
        near, most = self._distance(played, goal) if hot else math.inf, LONGEST
        steps = random.randint(LEAST_STEPS, MOST_STEPS) if hot else random.randint(1, FEW_STEPS)
        while steps > 0 and most > 0:
            first = len(played.outcomes)
            driver = random_stretch(game, self.recipes, goal, self.tried.ran, steps, random)
            course = replace(course, luck=course.luck + (random.choice(LUCKS),) * steps)
            played = play(game, course, first + steps, self._checks(game), played, driver)
            course = replace(course, actions=tuple(played.actions), luck=course.luck[: len(played.actions)])
            taken = len(played.outcomes) - first
            steps, most = steps - max(1, taken), most - max(1, taken)
            if goal is None or played.is_over:
                break
            now = self._distance(played, goal) if hot else math.inf
            if now < near - NEARER:
                near, steps, corpus.vain[course.rows] = now, MOST_STEPS, 0
                corpus.add_nearer(course, played, goal)
                if now < self._nearest.get(goal, math.inf) - NEARER:
                    self._nearest[goal], self._vain[goal] = now, 0
            elif steps <= 0:
                corpus.vain[course.rows] += hot and 0 < near < math.inf
                self._vain[goal] += 1
        return course, played

    def _distance(self, played: Played, goal: Goal | None) -> float:
        if goal is None or played.is_over:
            return math.inf
        world = played.worlds[-1]
        if self._latest is None or self._latest[0] is not world:
            self._latest = (world, Distances(self._chains, played.game, world))
        return self._latest[1].of(goal.recipe, goal.many)

    def _times(self, goal: Goal) -> int:
        """Returns how often a goal was reached, as far as that is counted."""
        place = self.recipes[goal.recipe].place
        return self.tried.ran[place] if goal.many == 1 else self.tried.corpus.seen["times", place, goal.many]

    def _is_hot(self, goal: Goal | None) -> bool:
        """Returns whether distances are measured for a goal: it was seldom reached, and not often missed since a course came nearest to it."""
        return goal is not None and self._times(goal) < SELDOM and self._vain[goal] < GIVEN_UP

    def _choose_goal(self, missing: Collection[Place]) -> Goal:
        """Returns a goal, rather one that was seldom reached and seldom tried; of the missing sentences, if any can be a goal."""
        goals = dict[Goal, float]()
        wanted = [i for i in self._aims if any(self.recipes[j].place in missing for j in self._beside[i])] or self._aims
        for i in wanted:
            for many in range(1, 2 if is_always_once(self.recipes[i].quantifiers) else MANY + 1):
                times = self._times(Goal(i, many))
                goals[Goal(i, many)] = (1 / (1 + times) ** 0.5 if times else NEVER) / (1 + self._vain[Goal(i, many)]) ** VAIN
                if not times:
                    break
        return self._random.choices(list(goals), list(goals.values()))[0]

    def _begin(self, on_own: bool, goal: Goal | None, closest: bool) -> tuple[Course, Played] | None:
        """Returns the course to go on with, an older one or a new start; None if the game does not take its map.

        A start from which a way to the goal is seen, if that is soon found; an older course is rather a close one for `closest`.
        """
        random, kept = self._random, self.tried.corpus.kept
        if kept and random.random() < AGAIN:
            older: Kept = self.tried.corpus.choose(random, self._chains, goal if closest and self._is_hot(goal) else None)
            return older.course, older.played
        found: tuple[Course, Played] | None = None
        for _ in range(STARTS):
            course = own_start(self.ground, random) if on_own and random.random() < OWN else random_start(self.ground, random)
            game = None if course is None else self.ground.on(course.rows, course.agents)
            if course is None or game is None:
                return found
            found = course, play(game, course, 0, self._checks(game))
            if not self._is_hot(goal) or self._distance(found[1], goal) < math.inf:
                break
        return found

    def _checks(self, game: ir.Game) -> list[ir.Check]:
        return [game.checks[number] for number in self.left if game.checks[number].sort in STATES]

    def _look(self, course: Course, played: Played, first: int) -> None:
        """Counts what happened in the new steps of a course, looks for promises that it breaks, and keeps it if it has something new."""
        self.tried.ran.update(place for t in range(first, len(played.happened)) for place in places_run(played.happened[t]))
        if not first:
            self.tried.ran.update(places_run(played.began))
        checks = played.game.checks
        for number in self.left:
            if checks[number].sort == "once":
                self.tried.triggers[number] += any(trigger for trigger, _ in played.values(checks[number])[first + 1 :])
        unbroken = [*self.left, *([] if any(b.promise == FLOATS for b in self.found) else [FLOATS])]
        for number in unbroken:
            broken = first_broken(played, [number], course, self.breaks, first)
            if broken is not None:
                self.found.append(simplest(self.ground, broken, self.breaks, self.effort.tries))
                self.left = [left for left in self.left if left != number]
                self._needed.pop(number, None)
        self.tried.corpus.add(course, played, first, [n for n in self.left if checks[n].sort in STATES])


def search(
    ground: Ground,
    promises: list[int],
    effort: Effort,
    breaks: Breaks = breaks_in_states,
    needed: Mapping[int, Collection[Place]] | None = None,
) -> tuple[list[Broken], Tried]:
    """Returns for each promise that courses break the simplest course found, and what was played.

    Args:
      promises: places among the game's checks.
      breaks: where a promise breaks in a course.
      needed: sentences on which promises depend, perhaps others than those: while one never ran, more courses are played.
    """
    searching = Search(ground, promises, effort, breaks, needed or {})
    searching.run()
    return searching.found, searching.tried


def simplest(ground: Ground, broken: Broken, breaks: Breaks, tries: int) -> Broken:
    """Returns the break of a promise in the simplest course that can be made of one."""

    def attempt(course: Course) -> Broken | None:
        game = ground.on(course.rows, course.agents)
        if game is None or course.agents not in (*ground.few_agents, broken.course.agents):
            return None
        checks = [game.checks[broken.promise]] if broken.promise != FLOATS and game.checks[broken.promise].sort in STATES else []
        return first_broken(play(game, course, None, checks), [broken.promise], course, breaks, 0)

    def shorter(course: Course) -> Course | None:
        found = attempt(course)
        return (
            None if found is None else replace(found.course, actions=course.actions[: _length(found)], luck=course.luck[: _length(found)])
        )

    first = shorter(broken.course)
    assert first is not None, "a course that is played again goes another way"
    found = attempt(shrink(first, ground.own, ground.glyphs[0], shorter, tries))
    assert found is not None
    return found


def _blocks(recipes: Sequence[Recipe]) -> dict[int, list[int]]:
    """Returns the sentences that always take place together, by the first of them: one goal."""
    firsts: dict[tuple[object, ...], int] = {}
    found: dict[int, list[int]] = {}
    for i, recipe in enumerate(recipes):
        found.setdefault(firsts.setdefault(recipe.block, i), []).append(i)
    return found


def _length(broken: Broken) -> int:
    return max(1, broken.where.at)


def first_broken(played: Played, promises: Collection[int], course: Course, breaks: Breaks, since: int) -> Broken | None:
    """Returns the first of the promises that a course breaks, if any."""
    for number in promises:
        if number == FLOATS:
            where = None if played.left is None else Break(len(played.worlds))
        else:
            where = breaks(played.game.checks[number], played, course, since)
        if where is not None:
            return Broken(number, course, played, where)
    return None
