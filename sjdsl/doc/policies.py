"""The sections of a rule sheet on scripted policies and scenarios."""

from sjdsl.compiler import ir
from sjdsl.doc.quoted import laid_out, written_text
from sjdsl.doc.wording import Line, bullets, code, fenced, joined, plain, table
from sjdsl.doc.written import Written

READING = (
    "A policy says how an agent may play. It is no rule of the game, and the game is the same without it. Before each step an agent that "
    "follows a policy looks at the true state, also at what it could not observe. It does what the first line says that applies; if none "
    "applies, it stays. `agent` is the one that follows the policy. An agent that is away stays."
)
RULES = {
    ir.Act: Line("`when C choose ACTION` applies if C holds: the agent chooses the action"),
    ir.Go: Line("`seek D` walks to the nearest D, and stays there"),
    ir.Aim: Line(
        "`aim S at D choose ACTION` walks, and turns if S has a direction, until a D is in the S of the agent; then it chooses the action"
    ),
}
AVOIDING = Line("`avoiding D`: no D is entered, unless it is what is sought")
WALKING = (
    Line("a line with `seek` or `aim` applies if a path leads to what is sought, or if the agent has arrived"),
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
    "A scenario is a line-up of agents. A policy under evaluation plays the focal agents, and the other agents follow the policy that "
    "is named, `random` (all actions equally likely) or `stay`. Scenarios change nothing in the game."
)


def policies(w: Written) -> list[str]:
    """Returns the policies of a game as they are written, after how they are read."""
    rules = [rule for policy in w.game.policies for rule in policy.rules]
    sorts = {type(rule) for rule in rules}
    lines = [line for sort, line in RULES.items() if sort in sorts]
    lines += [AVOIDING] if any(isinstance(rule, ir.Go | ir.Aim) and rule.avoided is not None for rule in rules) else []
    lines += [*(WALKING if {ir.Go, ir.Aim} & sorts else ()), *([AIMING] if ir.Aim in sorts else [])]
    found = [READING, "", *bullets(lines), ""]
    for policy in w.game.policies:
        text = written_text(w.composition, w.composition.policies[policy.name].rules)
        found += [f"### {heading(policy.name, policy.title)}", "", *fenced(laid_out(text, "policy p")), ""]
    return found


def heading(name: str, title: str) -> str:
    """Returns a name with what is said of it: `greedy`: eats all there is."""
    return f"{code(name)}: {plain(title)}" if title else code(name)


def scenarios(w: Written) -> list[str]:
    """Returns the line-ups of a game."""
    rows = [(code(s.name), plain(s.title), joined(map(_slots, s.slots))) for s in w.game.scenarios]
    return [LINE_UPS, "", *table(("scenario", "what it is", "who plays"), rows), ""]


def _slots(part: ir.Slots) -> str:
    return f"{part.number} {code(part.policy) if part.policy else 'focal'}"
