"""The English of scripted policies, rule by rule, and of scenarios."""

from typing import assert_never

from sjdsl.compiler import ir
from sjdsl.doc.phrases import arguments, condition, members
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import Line, article, bullets, capital, code, counted, joined, plain

READING = (
    "A policy says how an agent may play. It is no rule of the game, and the game is the same without it. Before each step an agent that "
    "follows a policy looks at the true state, also at what it could not observe. It does what the first line says that applies; if none "
    'applies, it stays. "The agent" is the one that follows the policy. An agent that is away stays.'
)
WALKING = (
    Line("a line about walking applies if a path leads to what is sought, or if the agent has arrived"),
    Line(
        "to walk is to take the first move of a path with the fewest moves, turns included; of moves equally good, the first in the table "
        "of actions is taken"
    ),
    Line(
        "paths lead around cells that no agent can ever enter; cells that stop agents only at times, and other agents, are not considered"
    ),
    Line(
        "if another agent stands on the cell that the move leads to, then with probability 0.5 the move is drawn instead, all moves equally "
        "likely that lead to no cell that is avoided and to none that no agent can ever enter"
    ),
)
AIMING = Line("what ends a lane of a shape at all times is considered when an agent aims, what ends it only at times is not")
LINE_UPS = (
    "A scenario is a line-up of agents. A policy under evaluation plays the focal agents, and the other agents play as the line says. "
    "Scenarios change nothing in the game."
)


def policies(v: Vocabulary) -> list[str]:
    """Returns the policies of a game, and how they are read."""
    found = [READING, ""]
    if v.has(ir.Go, ir.Aim):
        found += [*bullets([*WALKING, *([AIMING] if v.has(ir.Aim) else [])]), ""]
    for policy in v.game.policies:
        found += [
            f"### {heading(policy.name, policy.title)}",
            "",
            *(f"{number}. {capital(line.text)}." for number, line in enumerate(policy_lines(policy, v), 1)),
            "",
        ]
    return found


def heading(name: str, title: str) -> str:
    """Returns a name with what is said of it: `greedy`: eats all there is."""
    return f"{code(name)}: {plain(title)}" if title else code(name)


def policy_lines(policy: ir.ScriptedPolicy, v: Vocabulary) -> list[Line]:
    """Returns the rules of a policy, in order."""
    return [Line(_rule(rule, v)) for rule in policy.rules]


def _rule(rule: ir.PolicyRule, v: Vocabulary) -> str:
    match rule:
        case ir.Act():
            return f"if {condition(rule.condition, v)}, choose {_taken(rule, v)}"
        case ir.Go():
            around = _around(rule.avoided, v, "; what is sought may be entered all the same")
            return f"walk to the nearest {members(rule.domain, v)}{around}, and stay there"
        case ir.Aim():
            directed = v.shapes[rule.shape].directed
            inside = f"in the {code(rule.shape)} {'of' if directed else 'around'} the agent"
            how = "walk and turn" if directed else "walk"
            around = _around(rule.avoided, v)
            return f"{how} until {article(members(rule.domain, v))} is {inside}{around}; then choose {_taken(rule, v)}"
        case _:
            assert_never(rule)


def _taken(rule: ir.Act | ir.Aim, v: Vocabulary) -> str:
    return f"{code(rule.chosen)} with {arguments(rule.given, v)}" if rule.chosen else v.action(rule.action)


def _around(avoided: ir.Domain | None, v: Vocabulary, but: str = "") -> str:
    return "" if avoided is None else f" (without entering {article(members(avoided, v))}{but})"


def scenarios(v: Vocabulary) -> list[str]:
    """Returns the line-ups of a game."""
    return [LINE_UPS, "", *bullets(map(scenario_line, v.game.scenarios)), ""]


def scenario_line(scenario: ir.Scenario) -> Line:
    """Returns one scenario."""
    name = f"{code(scenario.name)} ({plain(scenario.title)})" if scenario.title else code(scenario.name)
    return Line(f"{name}: {joined(_slots(part) for part in scenario.slots)}")


def _slots(part: ir.Slots) -> str:
    if not part.policy:
        return counted(part.number, "focal agent")
    s = "s" if part.number == 1 else ""
    what = {"random": f"choose{s} all actions equally likely", "stay": f"always stay{s}"}.get(part.policy, f"follow{s} {code(part.policy)}")
    return f"{counted(part.number, 'agent')} that {what}"
