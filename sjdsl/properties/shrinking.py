"""Makes a course that breaks a promise as simple as it can be made: what Hypothesis leaves, with what is known of games.

Hypothesis shrinks what it drew; it does not know that a row can be taken out of a map, or that a policy can be written down as actions.
"""

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.properties.trajectory import Course

SHORT = 5  # steps of a course on which more is tried
SHORTCUTS = 3  # in the first so many steps: agents get where they are wanted
SEEDS = 6  # other words tried for each change of the layout
Try = Callable[[Course], Course | None]  # the course, cut off where it breaks and its actions written down; None if it does not


def size(course: Course, stay: int) -> tuple[int, ...]:
    """Returns what makes a course complicated, the worst first."""
    acting = sum(action != stay for step in course.actions for action in step)
    scripted = sum(policy is not None for policy in course.policies)
    cells = len(course.rows) * len(course.rows[0])
    kinds = len(set("".join(course.rows)))
    return (
        len(course.actions),
        course.agents,
        scripted,
        len(course.params),
        cells,
        acting,
        kinds,
        sum(luck != "fair" for luck in course.luck),
        course.seed,
    )


def shrink(course: Course, game: ir.Game, plain: str, attempt: Try, most: int) -> Course:
    """Returns a simpler course that breaks the promise.

    Args:
      course: one that does.
      plain: the glyph that a map may have everywhere.
      attempt: plays a course.
      most: courses to try.
    """
    stay = game.agents.actions.index("stay")
    best, tries, changed = course, 0, True
    seen = {course}
    while changed:
        changed = False
        for candidate in _simpler(best, game, stay, plain):
            if candidate in seen:
                continue
            seen.add(candidate)
            tries += 1
            if tries > most:
                return best
            broken = attempt(candidate)
            if broken is not None and size(broken, stay) < size(best, stay):
                best, changed = broken, True
                break
    return best


def _simpler(course: Course, game: ir.Game, stay: int, plain: str) -> Iterator[Course]:
    yield from _quieter(course, stay)
    for smaller in (*_fewer_agents(course), *_smaller_maps(course)):
        yield from (replace(smaller, seed=seed) for seed in _seeds(course))
    yield from _fewer_steps(course, stay)
    yield from _shortcuts(course, len(game.agents.actions))
    for i in range(len(course.params)):
        yield replace(course, params=course.params[:i] + course.params[i + 1 :])
    yield from _plainer_actions(course, stay)
    yield from _plainer_maps(course, plain)
    for seed in range(min(course.seed, SEEDS)):
        yield replace(course, seed=seed)
    for t, luck in enumerate(course.luck):
        if luck != "fair":
            yield replace(course, luck=(*course.luck[:t], "fair", *course.luck[t + 1 :]))


def _seeds(course: Course) -> tuple[int, ...]:
    return tuple(dict.fromkeys((course.seed, *range(SEEDS))))


def _quieter(course: Course, stay: int) -> Iterator[Course]:
    """Yields courses in which nobody acts at all, or that are over sooner."""
    still = tuple((stay,) * course.agents for _ in course.actions)
    for length in sorted({1, 2, len(still) // 2, len(still) - 1} - {0, -1}):
        yield replace(course, actions=still[:length], luck=course.luck[:length])
        yield replace(course, actions=course.actions[-length:], luck=course.luck[-length:])
        yield replace(course, actions=course.actions[:length], luck=("good",) * length)
    yield replace(course, actions=still)


def _fewer_agents(course: Course) -> Iterator[Course]:
    for out in reversed(range(course.agents)):
        if course.agents > 1:
            actions = tuple(step[:out] + step[out + 1 :] for step in course.actions)
            policies = course.policies[:out] + course.policies[out + 1 :]
            yield replace(course, agents=course.agents - 1, actions=actions, policies=policies)


def _smaller_maps(course: Course) -> Iterator[Course]:
    height, width = len(course.rows), len(course.rows[0])
    for r in range(height if height > 1 else 0):
        yield replace(course, rows=course.rows[:r] + course.rows[r + 1 :])
    for c in range(width if width > 1 else 0):
        yield replace(course, rows=tuple(row[:c] + row[c + 1 :] for row in course.rows))


def _fewer_steps(course: Course, stay: int) -> Iterator[Course]:
    """Yields courses without one step, or with one in which nobody acts."""
    short = len(course.actions) <= SHORT  # an agent that turns first may stand that way from the start, with another seed
    yield from _without_a_step(course, _seeds(course) if short else (course.seed,))
    for t, step in enumerate(course.actions):
        if any(action != stay for action in step):
            yield replace(course, actions=(*course.actions[:t], (stay,) * course.agents, *course.actions[t + 1 :]))


def _without_a_step(course: Course, seeds: Iterable[int]) -> Iterator[Course]:
    """Yields courses without one step. Later steps then draw other words: so also with chances that come at the end and not before."""
    for t in range(len(course.actions) if len(course.actions) > 1 else 0):
        shorter = replace(course, actions=course.actions[:t] + course.actions[t + 1 :], luck=course.luck[:t] + course.luck[t + 1 :])
        late = replace(shorter, luck=("bad",) * (len(shorter.luck) - 1) + ("good",))
        yield from (replace(one, seed=seed) for seed in seeds for one in (shorter, late))


def _shortcuts(course: Course, count: int) -> Iterator[Course]:
    """Yields courses without one step, in which one agent does something else in the next: one move for a turn and a move."""
    for shorter in _without_a_step(course, (course.seed,)):
        for t, step in enumerate(shorter.actions[:SHORTCUTS]):
            for agent, action in itertools.product(range(course.agents), range(count)):
                if action != step[agent]:
                    other = (*step[:agent], action, *step[agent + 1 :])
                    yield replace(shorter, actions=(*shorter.actions[:t], other, *shorter.actions[t + 1 :]))


def _plainer_actions(course: Course, stay: int) -> Iterator[Course]:
    for t, step in enumerate(course.actions):
        for agent, action in enumerate(step):
            if action != stay:
                still = (*step[:agent], stay, *step[agent + 1 :])
                yield replace(course, actions=(*course.actions[:t], still, *course.actions[t + 1 :]))


def _plainer_maps(course: Course, plain: str) -> Iterator[Course]:
    for r, row in enumerate(course.rows):
        for c, glyph in enumerate(row):
            if glyph != plain:
                yield replace(course, rows=(*course.rows[:r], row[:c] + plain + row[c + 1 :], *course.rows[r + 1 :]))
