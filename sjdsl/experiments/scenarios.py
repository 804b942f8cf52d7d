"""Scenarios of a game: plays a policy as the focal agents among scripted ones, and scores it between random and the best scripted policy."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sjdsl.compiler import ir
from sjdsl.experiments.folder import read_json, record_experiment, require_same, write_compact_json
from sjdsl.experiments.playing import Experiment, Tell, check_episodes, find_pools, play_experiment
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.experiments.scenario_scores import (
    RANDOM,
    ScenarioScores,
    line_up,
    report_of,
    score_of,
    slots_of,
)
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
        """Returns everything that the results depend on; a policy with a digest is identified by it, wherever its file is."""
        described = self.experiment.describe()
        focal = self.experiment.pools[0].describe()
        if all(player["digest"] for player in focal["players"]):
            focal["name"] = None
        described["policies"] = [focal, *described["policies"][1:]]
        return {
            "experiment": NAME,
            "scenarios": {each.name: slots_of(each) for each in self.fitting},
            **described,
        }


def play_scenarios(
    env: Environment,
    policy: str | Path | Policy,
    names: str | Sequence[str] = ALL,
    episodes: int = 30,
    seed: int = 0,
    folder: Path | str | None = None,
    tell: Tell = lambda _: None,
) -> ScenarioScores:
    """Plays a policy as the focal agents of scenarios, whose other slots have the policies that the game's file gives them.

    Each episode draws who has which slot. For the score, `random`, each policy of the file and `stay` are also played as focal agents, in
    episodes with the same start. Each seed of a run is played, in episodes of its own.

    Args:
      env: one environment of N agents, two at least, whose game has scenarios.
      policy: what the focal agents play, as `find_pool` takes it.
      names: the scenarios: `all`, one name or several.
      episodes: E, of each line-up and training seed.
      seed: of the episodes.
      folder: where `scenarios.json` is written; scenarios that are in it already, played in the same way, stay. None: nothing is written.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: something doesn't fit. OSError: the disk is full.
    """
    return play_planned(plan_scenarios(env, policy, names, episodes, seed), folder, tell)


def plan_scenarios(
    env: Environment,
    policy: str | Path | Policy,
    names: str | Sequence[str],
    episodes: int,
    seed: int,
) -> Plan:
    """Plans `play_scenarios`, and raises the same errors."""
    check_episodes(episodes)
    chosen = choose_scenarios(env, names)
    fitting = tuple(
        scenario for scenario in scenarios_of(env) if not unfilled(scenario, env.num_agents)
    )
    names_of_scripted = (RANDOM, *declared_policies(env), "stay")
    found = find_pools((policy, *names_of_scripted), env)
    pools = tuple(dict.fromkeys(found))
    scripted = {
        name: pools.index(pool) for name, pool in zip(names_of_scripted, found[1:], strict=True)
    }
    lineups = dict.fromkeys(
        line_up(scenario, pool, scripted) for scenario in chosen for pool in (0, *scripted.values())
    )
    experiment = Experiment(env, pools, tuple(lineups), episodes, seed, permuted=True)
    return Plan(experiment, chosen, fitting, scripted)


def play_planned(
    plan: Plan, folder: Path | str | None, tell: Tell, name: str = NAME
) -> ScenarioScores:
    """Plays a plan of `plan_scenarios`; see `play_scenarios`. `name`: the name of the results in the folder."""
    if folder is not None:
        require_same(Path(folder) / name, plan.describe())
    parts = play_experiment(plan.experiment, tell)
    found = ScenarioScores(
        plan.experiment,
        {scenario.name: score_of(scenario, plan.scripted, parts) for scenario in plan.scenarios},
    )
    if folder is not None:
        file = Path(folder) / f"{name}.json"
        known = (
            (read_json(file) or {}).get("scenarios", {}) if (Path(folder) / name).is_dir() else {}
        )
        record_experiment(Path(folder) / name, plan.describe())
        report = report_of(found)
        scores = {**known, **report["scenarios"]}
        ordered = {
            scenario.name: scores[scenario.name]
            for scenario in plan.fitting
            if scenario.name in scores
        }
        write_compact_json(file, {**report, "scenarios": ordered})
    return found


def scenarios_of(env: Environment) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios that the game's file declares; none if its rules aren't available."""
    game = getattr(env, "game", None)
    return () if game is None else game.scenarios


def choose_scenarios(env: Environment, names: str | Sequence[str]) -> tuple[ir.Scenario, ...]:
    """Returns the named scenarios, each once, in the file's order.

    Args:
      names: `all`, a name, or several.
    Raises:
      ExperimentError: the game has one agent or no scenarios, or none is named, or one is unknown or doesn't fit the number of agents.
    """
    declared = {scenario.name: scenario for scenario in scenarios_of(env)}
    if env.num_agents < 2:
        raise ExperimentError(
            f"a scenario needs at least two agents, and {env.name} has one here; ask for more with --agents"
        )
    if not declared:
        raise ExperimentError(
            f"{env.name} has no scenarios; write one into the game's file, such as `{EXAMPLE}`"
        )
    given = several(names)
    wanted = list(declared) if ALL in given else list(given)
    if not wanted:
        raise ExperimentError("name at least one scenario, or `all`")
    for name in wanted:
        if name not in declared:
            raise ExperimentError(
                f"there is no scenario `{name}`{meant(name, declared, f'those of {env.name} are')}"
            )
        reason = unfilled(declared[name], env.num_agents)
        if reason:
            fitting = [
                scenario.name
                for scenario in declared.values()
                if not unfilled(scenario, env.num_agents)
            ]
            instead = (
                f"name another, such as {fitting[0]}"
                if fitting
                else "choose another number of agents"
            )
            raise ExperimentError(
                f"the scenario `{name}` doesn't fit {env.num_agents} agents: {reason}; {instead}"
            )
    return tuple(scenario for scenario in declared.values() if scenario.name in wanted)


def unfilled(scenario: ir.Scenario, agents: int) -> str:
    """Returns why a scenario can't be played by this many agents; empty if it can."""
    numbers = [part.number for part in scenario.slots]
    least = min(scenario.slots, key=lambda part: part.number)
    if least.number < 0:
        return f"it would have {least.number} slots of {least.policy or 'focal agents'}"
    if sum(numbers) != agents:
        return f"it has {sum(numbers)} slots"
    return (
        ""
        if any(part.number for part in scenario.slots if not part.policy)
        else "it has no focal slot"
    )
