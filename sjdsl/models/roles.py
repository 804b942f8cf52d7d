"""Parts that a player may play, in words."""

from sjdsl.compiler import ir
from sjdsl.models.errors import ModelError
from sjdsl.near_names import meant

# In two wordings each, so that a result doesn't rest on one.
BUILT_IN = {
    "cooperator": (
        "You care about the rewards of all agents together as much as about your own.",
        "What counts for you is the sum of everybody's rewards, not your own part of it.",
    ),
    "defector": (
        "You care about your own reward only, whatever it costs others.",
        "What counts for you is your own part of the rewards, not what others get.",
    ),
}


def wordings(role: str, game: ir.Game) -> tuple[str, ...]:
    """Returns what a player of a role is told; episode e has wording e modulo their number.

    Those of the game's file, `about player_ROLE "…"` and `about player_ROLE_2 "…"`, replace those
    that are built in.

    Raises:
      ModelError: nobody says what the role is.
    """
    if not role:
        return ("",)
    about = dict(game.about)
    names = (f"player_{role}", f"player_{role}_2")
    of_game = tuple(about[name] for name in names if name in about)
    if of_game:
        return of_game
    if role not in BUILT_IN:
        raise ModelError(
            f"there is no role `{role}`, and the game's file has no "
            f'`about player_{role} "…"`{meant(role, BUILT_IN)}'
        )
    return BUILT_IN[role]
