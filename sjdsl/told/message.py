"""What an agent is told at a step: what it sees, earned and may do, its own past and its notes."""

from collections.abc import Sequence
from dataclasses import dataclass

from sjdsl.doc.wording import number
from sjdsl.told.legal import action_lines
from sjdsl.told.phrases import shortest
from sjdsl.told.window import Planes, Window

HISTORY = 15  # of its own steps that an agent is reminded of


@dataclass(frozen=True)
class Past:
    """One step of an agent's own: the action that it took, what it earned, and a remark.

    remark: such as that its reply couldn't be read.
    """

    action: str
    reward: float
    remark: str = ""


def message(
    window: Window,
    seen: Planes,
    allowed: Sequence[bool],
    past: Sequence[Past] = (),
    notes: Sequence[str] = (),
    ledger: Sequence[str] = (),
    trial: int = 0,
) -> str:
    """Returns the message to one agent before a step.

    Args:
      seen: `[P, rows, cols]` uint8, the agent's token planes.
      allowed: for each action whether it may take it, a row of `env.allowed_actions`.
      past: its own last steps, the last one last.
      notes: its own notes, as it wrote them.
      ledger: what its actions paid, a line each.
      trial: which one it is in, in a game with trials.
    """
    parts = []
    if window.game.trials is not None:
        parts.append(f"TRIAL: {trial}, of 0 to {window.game.trials.number - 1}")
    parts += own_past(past, notes, ledger)
    parts.append(f"WHAT YOU SEE NOW:\n{window.text(seen)}")
    parts.append("\n".join(["YOUR ACTIONS NOW:", *action_lines(window, seen, allowed)]))
    return "\n\n".join(parts) + "\n"


def own_past(past: Sequence[Past], notes: Sequence[str], ledger: Sequence[str]) -> list[str]:
    """Returns the parts of a message about what an agent did, earned and noted."""
    parts = []
    if past:
        parts.append(f"YOUR LAST REWARD: {_reward(past[-1].reward)}")
        parts.append("\n".join(["YOUR LAST STEPS, newest first:", *_recent(past)]))
    if ledger:
        title = "YOUR MEAN REWARD SO FAR, by what you did or what you stepped onto:"
        parts.append("\n".join([title, *ledger]))
    if notes:
        numbered = [f"{place}. {note}" for place, note in enumerate(notes, 1)]
        parts.append("\n".join(["YOUR NOTES:", *numbered]))
    return parts


def _recent(past: Sequence[Past]) -> list[str]:
    lines = []
    for ago, step in enumerate(reversed(past), 1):
        remark = f"; {step.remark}" if step.remark else ""
        lines.append(f"{ago} ago: {step.action}, reward {_reward(step.reward)}{remark}")
    return lines


def _reward(reward: float) -> str:
    return number(shortest(reward))
