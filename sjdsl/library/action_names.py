"""Reads names of actions that stand in a row, such as `zap, offer(1, 2), stay`."""

import re

_INSIDE = r"(?![^()]*\))"  # not between the brackets of an action with arguments


def split_actions(text: str, apart: str = ",") -> list[str]:
    """Returns the names in a text as the game spells them, without layout; a missing one is empty.

    Args:
      apart: the pattern of what stands between two names; inside the brackets of an action it is part of its name.
    """
    found = []
    for name in re.split(apart + _INSIDE, text):
        action, bracket, arguments = name.strip().partition("(")
        found.append(
            f"{action.strip()}({', '.join(a.strip() for a in arguments.rstrip(') ').split(','))})"
            if bracket
            else action
        )
    return found
