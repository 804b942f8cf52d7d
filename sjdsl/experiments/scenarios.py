"""Scenarios of a game: plays a policy as focal agents among scripted ones, and scores it between random and the best scripted focal agents."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sjdsl.compiler import ir
from sjdsl.experiments.folder import open_folder
from sjdsl.experiments.lineups import Lineup
from sjdsl.experiments.playing import Experiment, Tell, check_episodes, find_pools, play_experiment
from sjdsl.experiments.result_files import write_compact_json
from sjdsl.experiments.scenario_choice import ALL, choose_scenarios, scenarios_of, unfilled
from sjdsl.experiments.scenario_scores import RANDOM, ScenarioScores, line_up, report_of, score_of, slots_of
from sjdsl.policies.declared import declared_policies
from sjdsl.runtime.policy import Policy
from sjdsl.trainers.environment import Environment

NAME = "scenarios"


@dataclass(frozen=True)
class Plan:
    """The line-ups of all scenarios that the number of agents fills, and which of these scenarios are asked for."""

    experiment: Experiment
    scenarios: tuple[ir.Scenario, ...]
    asked: tuple[str, ...]
    scripted: dict[str, int]  # the pools of `random`, the file's policies and `stay`

    def lineups_of(self, scenario: ir.Scenario) -> tuple[Lineup, ...]:
        """Returns a scenario with the policy that is evaluated, and with each scripted one, as its focal agents."""
        return tuple(line_up(scenario, pool, self.scripted) for pool in (0, *self.scripted.values()))

    def describe(self) -> dict[str, Any]:
        """Returns all that the results depend on; a policy that has a digest is known by it, wherever its file is."""
        described = self.experiment.describe()
        focal = self.experiment.pools[0].describe()
        if all(player["digest"] for player in focal["players"]):
            focal["name"] = None
        described["policies"] = [focal, *described["policies"][1:]]
        return {"experiment": NAME, "scenarios": {each.name: slots_of(each) for each in self.scenarios}, **described}


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

    Each episode draws who has which slot. So that a score can be given, `random`, each policy of the file and `stay` are played as focal
    agents besides, in episodes that begin alike. Of a run of several seeds, each is played, and each with episodes of its own.

    Args:
      env: one environment of N agents, two at least, whose game has scenarios.
      policy: what the focal agents play, as `find_pool` takes it.
      names: of scenarios; `all`, one or several.
      episodes: E, of each line-up and training seed.
      seed: of the episodes.
      folder: where what is played is kept (in `scenarios/`), and looked for first; then `scenarios.json`, which has all scenarios of the
        game that were played there. None: nothing is written.
      tell: called with a line before each line-up.
    Raises:
      ExperimentError, PolicyError: what does not fit. OSError: the disk is full; what was played stays.
    """
    return play_planned(plan_scenarios(env, policy, names, episodes, seed), folder, tell)


def plan_scenarios(env: Environment, policy: str | Path | Policy, names: str | Sequence[str], episodes: int, seed: int) -> Plan:
    """Returns what would be played. Raises as `play_scenarios` does."""
    check_episodes(episodes)
    asked = choose_scenarios(env, names)
    fitting = tuple(scenario for scenario in scenarios_of(env) if not unfilled(scenario, env.num_agents))
    names_of_scripted = (RANDOM, *declared_policies(env), "stay")
    found = find_pools((policy, *names_of_scripted), env)
    pools = tuple(dict.fromkeys(found))
    scripted = {name: pools.index(pool) for name, pool in zip(names_of_scripted, found[1:], strict=True)}
    lineups = dict.fromkeys(line_up(scenario, pool, scripted) for scenario in fitting for pool in (0, *scripted.values()))
    experiment = Experiment(env, pools, tuple(lineups), episodes, seed, permuted=True)
    return Plan(experiment, fitting, tuple(scenario.name for scenario in asked), scripted)


def play_planned(plan: Plan, folder: Path | str | None, tell: Tell, name: str = NAME) -> ScenarioScores:
    """Plays what `plan_scenarios` planned; see `play_scenarios`. `name`: of the results in the folder."""
    wanted = {lineup for scenario in plan.scenarios if scenario.name in plan.asked for lineup in plan.lineups_of(scenario)}
    with open_folder(None if folder is None else Path(folder) / name, plan.describe()) as kept:
        parts = play_experiment(plan.experiment, kept, tell, wanted)
        scores = {scenario.name: score_of(scenario, plan.scripted, parts, plan.experiment.replicates) for scenario in plan.scenarios}
        found = ScenarioScores(plan.experiment, plan.asked, {name: score for name, score in scores.items() if score is not None})
        if folder is not None:
            write_compact_json(Path(folder) / f"{name}.json", report_of(found))
    return found
