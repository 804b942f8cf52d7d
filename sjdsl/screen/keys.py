"""Key bindings of the terminal: the action of the game for each key."""

import re
from collections.abc import Iterator, Sequence

FACING = {"up": "forward", "down": "backward", "left": "turn_left", "right": "turn_right", "comma": "step_left", "full_stop": "step_right"}
COMPASS = {"up": "forward", "down": "backward", "left": "step_left", "right": "step_right", "comma": "turn_left", "full_stop": "turn_right"}
STAY = {"space": "stay"}
OWN = [*"123456789", *"abcdefghijklmnoprstuvwxyz", *"ABCDEFGHIJKLMNOPQRSTUVWXYZ"]  # q quits
SHOWN = {"up": "↑", "down": "↓", "left": "←", "right": "→", "comma": ",", "full_stop": "."}
ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
PASTED = {",": "comma", ".": "full_stop", " ": "space", "\r": "enter", "\n": "enter"}


def action_keys(action_names: Sequence[str], relative: bool) -> dict[str, int]:
    """Returns the number of the action of each key, by the terminal's name for the key.

    Arrows go where they point if agents move by the compass, or cannot turn; otherwise left and right turn. The game's own actions have
    the digits from 1, then the letters from a, then the capital ones; the first has the enter key as well.
    """
    names = list(action_names)
    built_in = (FACING if relative and "turn_left" in names else COMPASS) | STAY
    keys = {key: names.index(name) for key, name in built_in.items() if name in names}
    own = [number for number, name in enumerate(names) if name not in built_in.values()]
    return keys | dict(zip(OWN, own, strict=False)) | ({"enter": own[0]} if own else {})


def describe_keys(keys: dict[str, int], action_names: Sequence[str]) -> list[tuple[str, str]]:
    """Returns the keys of each action as they are shown, and its name; last, how many actions have no key, if some have none."""
    by_action: dict[int, list[str]] = {}
    for key, number in keys.items():
        by_action.setdefault(number, []).append(SHOWN.get(key, key))
    missing = len(action_names) - len(by_action)
    said = [(" ".join(shown), action_names[number]) for number, shown in by_action.items()]
    return said + ([("", f"{missing} actions have no key")] if missing else [])


def pasted_keys(text: str) -> Iterator[str]:
    """Yields the keys that a pasted text would be, were it typed."""
    for arrow, letter in re.findall(r"\x1b[\[O]([ABCD])|([^\x1b])", text):
        yield ARROWS[arrow] if arrow else PASTED.get(letter, letter)
