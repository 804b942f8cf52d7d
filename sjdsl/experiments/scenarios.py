"""Scenarios of a game: plays a policy as the focal agents among scripted ones, and scores it
between random and the best scripted policy."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sjdsl.compiler import ir
from sjdsl.experiments.folder import read_json, record_experiment, require_same, write_compact_json
from sjdsl.experiments.playing import (
    Experiment,
    Tell,
    check_episodes,
    find_pools,
    open_talks,
    play_experiment,
)
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.scenario_scores import (
    RANDOM,
    ScenarioScores,
    line_up,
    report_of,
    score_of,
    slots_of,
)
from sjdsl.models import Limits
from sjdsl.near_names import meant
from sjdsl.policies.declared import declared_policies
from sjdsl.runtime.policy import Policy
from sjdsl.several import several
from sjdsl.trainers.environment import Environment

NAME = "scenarios"
ALL = "all"
EXAMPLE = (
    'scenario visitors "one among agents who stay" { slots 1 focal  slots players - 1 policy stay }'
)


@dataclass(frozen=True)
class Plan:
    """The line-ups of the scenarios to play."""

    experiment: Experiment
    scenarios: tuple[ir.Scenario, ...]  # to play
    fitting: tuple[ir.Scenario, ...]  # all that fit the number of agents
    scripted: dict[str, int]  # indices of the pools of `random`, the file's policies and `stay`

    def describe(self) -> dict[str, Any]:
        """Returns everything that the results depend on, as JSON values.

        A policy with a digest is identified by it, wherever its file is.
        """
        description = self.experiment.describe()
        focal = description["policies"][0]
        if all(player["digest"] for player in focal["players"]):
            focal["name"] = None
        return {
            "experiment": NAME,
            "scenarios": {scenario.name: slots_of(scenario) for scenario in self.fitting},
            **description,
        }


def play_scenarios(
    env: Environment,
    policy: str | Path | Policy,
    names: str | Sequence[str] = ALL,
    episodes: int = 30,
    seed: int = 0,
    folder: Path | str | None = None,
    limits: Limits | None = None,
    tell: Tell = lambda _: None,
) -> ScenarioScores:
    """Plays a policy as the focal agents of scenarios; the game's file says what the others play.

    Each episode draws who has which slot. For the score, `random`, each policy of the file and
    `stay` are also played as focal agents, in episodes with the same start. Each seed of a run is
    played, in episodes of its own.

    Args:
      env: one environment of N agents, two at least, whose game has scenarios.
      policy: the policy of the focal agents, as `find_pool` takes it.
      names: the scenarios: `all`, one name or several.
      episodes: E, of each line-up and training seed.
      seed: the seed of the episodes.
      folder: where `scenarios.json` is written; scenarios that are in it already, played in the
        same way, stay. None: nothing is written.
      limits: of the calls of models.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: something doesn't fit. OSError: the disk is full.
      ModelError: a model can't be asked, or a limit is reached.
    """
    plan = plan_scenarios(env, policy, names, episodes, seed)
    return play_planned(plan, folder, tell, limits=limits)


def plan_scenarios(
    env: Environment,
    policy: str | Path | Policy,
    names: str | Sequence[str],
    episodes: int,
    seed: int,
) -> Plan:
    """Plans `play_scenarios`, and raises the same errors."""
    check_episodes(episodes)
    scenarios = choose_scenarios(env, names)
    fitting = fitting_scenarios(env)
    scripted_names = (RANDOM, *declared_policies(env), "stay")
    focal, *scripted_pools = find_pools((policy, *scripted_names), env)
    pools = tuple(dict.fromkeys([focal, *scripted_pools]))
    scripted = {
        name: pools.index(pool) for name, pool in zip(scripted_names, scripted_pools, strict=True)
    }
    lineups = dict.fromkeys(
        line_up(scenario, pool, scripted)
        for scenario in scenarios
        for pool in (0, *scripted.values())
    )
    experiment = Experiment(env, pools, tuple(lineups), episodes, seed, permuted=True)
    return Plan(experiment, scenarios, fitting, scripted)


def play_planned(
    plan: Plan,
    folder: Path | str | None,
    tell: Tell,
    name: str = NAME,
    limits: Limits | None = None,
) -> ScenarioScores:
    """Plays a plan of `plan_scenarios`; see `play_scenarios`.

    `name` is the name of the results in the folder.
    """
    path = None if folder is None else Path(folder) / name
    if path is not None:
        require_same(path, plan.describe())
    with open_talks(plan.experiment, path, plan.describe(), limits, tell) as talks:
        parts = play_experiment(plan.experiment, tell, talks)
    scores = {
        scenario.name: score_of(scenario, plan.experiment, plan.scripted, parts)
        for scenario in plan.scenarios
    }
    results = ScenarioScores(plan.experiment, scores, talks.account.by_policy())
    if folder is not None:
        write_scenarios(results, plan, Path(folder), name)
    return results


def write_scenarios(results: ScenarioScores, plan: Plan, folder: Path, name: str) -> None:
    """Writes the description of the experiment, and adds the scenarios to `NAME.json`, in the order
    of the game; those of an earlier call with the same plan stay.
    """
    file = folder / f"{name}.json"
    entries: dict[str, Any] = {}
    is_same_experiment = (folder / name).is_dir()  # another plan was refused by `require_same`
    if is_same_experiment:
        stored = read_json(file) or {}
        entries.update(stored.get("scenarios", {}))
    record_experiment(folder / name, plan.describe())
    report = report_of(results)
    entries.update(report["scenarios"])
    names = [scenario.name for scenario in plan.fitting]
    ordered = {scenario: entries[scenario] for scenario in names if scenario in entries}
    write_compact_json(file, {**report, "scenarios": ordered})


def scenarios_of(env: Environment) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios that the game's file declares; none if its rules aren't available."""
    game = getattr(env, "game", None)
    return () if game is None else game.scenarios


def fitting_scenarios(env: Environment) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios that fit the number of agents."""
    agents = env.num_agents
    return tuple(scenario for scenario in scenarios_of(env) if not misfit(scenario, agents))


def choose_scenarios(env: Environment, names: str | Sequence[str]) -> tuple[ir.Scenario, ...]:
    """Returns the named scenarios, each once, in the file's order.

    Args:
      names: `all`, a name, or several.
    Raises:
      ExperimentError: the game has one agent or no scenarios, or none is named, or one is unknown
        or doesn't fit the number of agents.
    """
    declared = {scenario.name: scenario for scenario in scenarios_of(env)}
    if env.num_agents < 2:
        raise ExperimentError(
            f"a scenario needs at least two agents, and {env.name} has one here; "
            "ask for more with --agents"
        )
    if not declared:
        raise ExperimentError(
            f"{env.name} has no scenarios; write one into the game's file, such as `{EXAMPLE}`"
        )
    chosen = several(names)
    if not chosen:
        raise ExperimentError("name at least one scenario, or `all`")
    if ALL in chosen:
        chosen = tuple(declared)
    for name in chosen:
        if name not in declared:
            raise ExperimentError(
                f"there is no scenario `{name}`{meant(name, declared, f'those of {env.name} are')}"
            )
        if reason := misfit(declared[name], env.num_agents):
            remedy = "choose another number of agents"
            if fitting := fitting_scenarios(env):
                remedy = f"name another, such as {fitting[0].name}"
            raise ExperimentError(
                f"the scenario `{name}` doesn't fit {env.num_agents} agents: {reason}; {remedy}"
            )
    return tuple(scenario for scenario in declared.values() if scenario.name in chosen)


def misfit(scenario: ir.Scenario, agents: int) -> str:
    """Returns why a scenario can't be played by this many agents; empty if it can."""
    for slots in scenario.slots:
        if slots.number < 0:
            return f"it would have {slots.number} slots of {slots.policy or 'focal agents'}"
    number = sum(slots.number for slots in scenario.slots)
    if number != agents:
        return f"it has {number} slots"
    has_focal = any(slots.number for slots in scenario.slots if not slots.policy)
    return "" if has_focal else "it has no focal slot"
