"""Keys of the board: the action of the game for each key."""

from collections.abc import Sequence

FACING = {
    "up": "forward",
    "down": "backward",
    "left": "turn_left",
    "right": "turn_right",
    "comma": "step_left",
    "full_stop": "step_right",
}
COMPASS = {
    "up": "forward",
    "down": "backward",
    "left": "step_left",
    "right": "step_right",
    "comma": "turn_left",
    "full_stop": "turn_right",
}
STAY = {"space": "stay"}
OWN = [*"123456789", *"abcdefghijklmnoprstuvwxyz", *"ABCDEFGHIJKLMNOPQRSTUVWXYZ"]


def action_keys(action_names: Sequence[str], relative: bool) -> dict[str, int]:
    """Returns the number of the action of each key, by the page's name for the key.

    Arrows go where they point if agents move by the compass, or cannot turn; otherwise left and right turn. The game's own actions have
    the digits from 1, then the letters from a, then the capital ones; the first has the enter key as well.
    """
    names = list(action_names)
    built_in = (FACING if relative and "turn_left" in names else COMPASS) | STAY
    keys = {key: names.index(name) for key, name in built_in.items() if name in names}
    own = [number for number, name in enumerate(names) if name not in built_in.values()]
    return keys | dict(zip(OWN, own, strict=False)) | ({"enter": own[0]} if own else {})
