"""Reads lists of actions, such as `zap, offer(1, 2), stay`."""

import re

_NOT_IN_BRACKETS = r"(?![^()]*\))"


def split_actions(text: str, separator: str = ",") -> list[str]:
    """Returns the names in a text as the game spells them; a missing one is "".

    Args:
      separator: a pattern; inside the brackets of an action with arguments, it doesn't separate.
    """
    names = []
    for item in re.split(separator + _NOT_IN_BRACKETS, text):
        name, bracket, rest = item.strip().partition("(")
        if bracket:
            arguments = [argument.strip() for argument in rest.rstrip(") ").split(",")]
            name = f"{name.strip()}({', '.join(arguments)})"
        names.append(name)
    return names
