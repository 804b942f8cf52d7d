"""Shrinks a counterexample: fewer steps, agents, cells and actions, as long as it still violates the check.

Hypothesis shrinks what it drew; it does not know that a row can be taken out of a map, or that a policy can be written as actions.
"""

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from sjdsl.compiler import ir
from sjdsl.properties.biased_draws import Bias
from sjdsl.properties.trajectory import Scenario

GOOD: tuple[Bias, ...] = ("good",)
BAD: tuple[Bias, ...] = ("bad",)
SHORT = 5  # steps of a counterexample on which more is tried
SHORTCUTS = 3  # replaced actions are tried in the first so many steps, where agents get into place
SEEDS = 6  # seeds tried for each change of the layout
Try = Callable[[Scenario], Scenario | None]  # the scenario, cut off at the violation and its actions written down; None if there is none


def size(scenario: Scenario, stay: int) -> tuple[int, ...]:
    """Returns the complexity of a scenario, the worst part first."""
    acting = sum(action != stay for step in scenario.actions for action in step)
    scripted = sum(policy is not None for policy in scenario.policies)
    cells = len(scenario.rows) * len(scenario.rows[0])
    kinds = len(set("".join(scenario.rows)))
    return (
        len(scenario.actions),
        scenario.agents,
        scripted,
        len(scenario.params) + len(scenario.sizes),
        cells,
        acting,
        kinds,
        sum(bias != "fair" for bias in scenario.bias),
        scenario.seed,
    )


def shrink(scenario: Scenario, game: ir.Game, plain: str | None, attempt: Try, most: int) -> Scenario:
    """Returns a simpler scenario that violates the check.

    Args:
      scenario: one that does.
      plain: the glyph that a map may have everywhere; None: the map stays.
      attempt: plays a scenario.
      most: scenarios to try.
    """
    stay = game.agents.actions.index("stay")
    best, tries, changed = scenario, 0, True
    seen = {scenario}
    while changed:
        changed = False
        for candidate in _simpler(best, game, stay, plain):
            if candidate in seen:
                continue
            seen.add(candidate)
            tries += 1
            if tries > most:
                return best
            found = attempt(candidate)
            if found is not None and size(found, stay) < size(best, stay):
                best, changed = found, True
                break
    return best


def _simpler(scenario: Scenario, game: ir.Game, stay: int, plain: str | None) -> Iterator[Scenario]:
    yield from _quieter(scenario, stay)
    for smaller in (*_fewer_agents(scenario), *(() if plain is None else _smaller_maps(scenario))):
        yield from (replace(smaller, seed=seed) for seed in _seeds(scenario))
    yield from _fewer_steps(scenario, stay)
    yield from _shortcuts(scenario, len(game.agents.actions))
    for i in range(len(scenario.params)):
        yield replace(scenario, params=scenario.params[:i] + scenario.params[i + 1 :])
    for i in range(len(scenario.sizes)):
        yield replace(scenario, sizes=scenario.sizes[:i] + scenario.sizes[i + 1 :])
    yield from _plainer_actions(scenario, stay)
    yield from () if plain is None else _plainer_maps(scenario, plain)
    for seed in range(min(scenario.seed, SEEDS)):
        yield replace(scenario, seed=seed)
    for t, bias in enumerate(scenario.bias):
        if bias != "fair":
            yield replace(scenario, bias=(*scenario.bias[:t], "fair", *scenario.bias[t + 1 :]))


def _seeds(scenario: Scenario) -> tuple[int, ...]:
    return tuple(dict.fromkeys((scenario.seed, *range(SEEDS))))


def _quieter(scenario: Scenario, stay: int) -> Iterator[Scenario]:
    """Yields scenarios in which nobody acts at all, or that are over sooner."""
    still = tuple((stay,) * scenario.agents for _ in scenario.actions)
    for length in sorted({1, 2, len(still) // 2, len(still) - 1} - {0, -1}):
        yield replace(scenario, actions=still[:length], bias=scenario.bias[:length])
        yield replace(scenario, actions=scenario.actions[-length:], bias=scenario.bias[-length:])
        yield replace(scenario, actions=scenario.actions[:length], bias=GOOD * length)
    yield replace(scenario, actions=still)


def _fewer_agents(scenario: Scenario) -> Iterator[Scenario]:
    for out in reversed(range(scenario.agents)):
        if scenario.agents > 1:
            actions = tuple(step[:out] + step[out + 1 :] for step in scenario.actions)
            policies = scenario.policies[:out] + scenario.policies[out + 1 :]
            yield replace(scenario, agents=scenario.agents - 1, actions=actions, policies=policies)


def _smaller_maps(scenario: Scenario) -> Iterator[Scenario]:
    height, width = len(scenario.rows), len(scenario.rows[0])
    for r in range(height if height > 1 else 0):
        yield replace(scenario, rows=scenario.rows[:r] + scenario.rows[r + 1 :])
    for c in range(width if width > 1 else 0):
        yield replace(scenario, rows=tuple(row[:c] + row[c + 1 :] for row in scenario.rows))


def _fewer_steps(scenario: Scenario, stay: int) -> Iterator[Scenario]:
    """Yields scenarios without one step, or with one in which nobody acts."""
    short = len(scenario.actions) <= SHORT  # with another seed an agent may start with the heading it first turns to
    yield from _without_a_step(scenario, _seeds(scenario) if short else (scenario.seed,))
    for t, step in enumerate(scenario.actions):
        if any(action != stay for action in step):
            yield replace(scenario, actions=(*scenario.actions[:t], (stay,) * scenario.agents, *scenario.actions[t + 1 :]))


def _without_a_step(scenario: Scenario, seeds: Iterable[int]) -> Iterator[Scenario]:
    """Yields scenarios without one step. Later steps then draw other numbers: so also with chances that happen at the end only."""
    for t in range(len(scenario.actions) if len(scenario.actions) > 1 else 0):
        shorter = replace(
            scenario, actions=scenario.actions[:t] + scenario.actions[t + 1 :], bias=scenario.bias[:t] + scenario.bias[t + 1 :]
        )
        late = replace(shorter, bias=(*BAD * (len(shorter.bias) - 1), *GOOD))
        yield from (replace(one, seed=seed) for seed in seeds for one in (shorter, late))


def _shortcuts(scenario: Scenario, count: int) -> Iterator[Scenario]:
    """Yields scenarios without one step, in which one agent acts otherwise in the next: one move for a turn and a move."""
    for shorter in _without_a_step(scenario, (scenario.seed,)):
        for t, step in enumerate(shorter.actions[:SHORTCUTS]):
            for agent, action in itertools.product(range(scenario.agents), range(count)):
                if action != step[agent]:
                    other = (*step[:agent], action, *step[agent + 1 :])
                    yield replace(shorter, actions=(*shorter.actions[:t], other, *shorter.actions[t + 1 :]))


def _plainer_actions(scenario: Scenario, stay: int) -> Iterator[Scenario]:
    for t, step in enumerate(scenario.actions):
        for agent, action in enumerate(step):
            if action != stay:
                still = (*step[:agent], stay, *step[agent + 1 :])
                yield replace(scenario, actions=(*scenario.actions[:t], still, *scenario.actions[t + 1 :]))


def _plainer_maps(scenario: Scenario, plain: str) -> Iterator[Scenario]:
    for r, row in enumerate(scenario.rows):
        for c, glyph in enumerate(row):
            if glyph != plain:
                yield replace(scenario, rows=(*scenario.rows[:r], row[:c] + plain + row[c + 1 :], *scenario.rows[r + 1 :]))
