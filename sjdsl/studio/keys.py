"""The keys of the board: which action each key takes."""

from collections.abc import Sequence

ARROWS = {"up": "forward", "down": "backward"}
FACING = {  # arrows turn the agent
    **ARROWS,
    "left": "turn_left",
    "right": "turn_right",
    "comma": "step_left",
    "full_stop": "step_right",
}
COMPASS = {  # arrows point where the agent goes
    **ARROWS,
    "left": "step_left",
    "right": "step_right",
    "comma": "turn_left",
    "full_stop": "turn_right",
}
STAY = {"space": "stay"}
# For the game's own actions.
CHARACTERS = [*"123456789", *"abcdefghijklmnoprstuvwxyz", *"ABCDEFGHIJKLMNOPQRSTUVWXYZ"]


def action_keys(action_names: Sequence[str], relative: bool) -> dict[str, int]:
    """Returns the number of each key's action, by the page's name for the key.

    Arrows go where they point if agents move by the compass, or can't turn; otherwise left and
    right turn. The game's own actions have the digits from 1, then the letters from a, then the
    capital ones; the first has the enter key as well.
    """
    names = list(action_names)
    built_in = (FACING if relative and "turn_left" in names else COMPASS) | STAY
    keys = {key: names.index(name) for key, name in built_in.items() if name in names}
    own_actions = [number for number, name in enumerate(names) if name not in built_in.values()]
    keys |= zip(CHARACTERS, own_actions, strict=False)  # actions beyond them have no key
    if own_actions:
        keys["enter"] = own_actions[0]
    return keys
