"""Which scenarios of a game are asked for, and which of them its number of agents fills."""

from collections.abc import Sequence

from sjdsl.compiler import ir
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.near_names import meant
from sjdsl.trainers.environment import Environment

ALL = "all"
EXAMPLE = 'scenario visitors "one among agents who stay" { slots 1 focal  slots players - 1 policy stay }'


def scenarios_of(env: Environment) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios that the game's file declares; none where its rules are not at hand."""
    game = getattr(env, "game", None)
    return () if game is None else game.scenarios


def choose_scenarios(env: Environment, names: str | Sequence[str]) -> tuple[ir.Scenario, ...]:
    """Returns the scenarios of these names, each once, in the file's order.

    Args:
      names: `all`, a name, or several.
    Raises:
      ExperimentError: the game has one agent or no scenarios, none is named, there is none of a name, or the agents do not fill it.
    """
    declared = {scenario.name: scenario for scenario in scenarios_of(env)}
    if env.num_agents < 2:
        raise ExperimentError(f"a scenario needs two agents at least, and {env.name} has one here; ask for more with --agents")
    if not declared:
        raise ExperimentError(f"{env.name} has no scenarios; write one into the game's file, such as `{EXAMPLE}`")
    given = [names] if isinstance(names, str) else list(names)
    wanted = list(declared) if ALL in given else given
    if not wanted:
        raise ExperimentError("name one scenario at least, or `all`")
    for name in wanted:
        if name not in declared:
            near = meant(name, declared, f"those of {env.name} are")
            raise ExperimentError(f"there is no scenario `{name}`{near}")
        reason = unfilled(declared[name], env.num_agents)
        if reason:
            fitting = [scenario.name for scenario in declared.values() if not unfilled(scenario, env.num_agents)]
            instead = f"name another, such as {fitting[0]}" if fitting else "choose another number of agents"
            raise ExperimentError(f"the scenario `{name}` does not fit {env.num_agents} agents: {reason}; {instead}")
    return tuple(scenario for scenario in declared.values() if scenario.name in wanted)


def unfilled(scenario: ir.Scenario, agents: int) -> str:
    """Returns why a scenario cannot be played by so many agents; nothing if it can."""
    numbers = [part.number for part in scenario.slots]
    if min(numbers) < 0:
        return f"it would have {min(numbers)} slots of {_played_by(min(scenario.slots, key=lambda part: part.number))}"
    if sum(numbers) != agents:
        return f"it has {sum(numbers)} slots"
    if not any(part.number for part in scenario.slots if not part.policy):
        return "it has no focal slot"
    return ""


def _played_by(part: ir.Slots) -> str:
    return part.policy or "focal agents"
