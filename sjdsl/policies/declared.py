"""The policies that the file of a game declares."""

from typing import Any

from sjdsl.compiler import ir


def declared_policies(env: Any) -> dict[str, ir.ScriptedPolicy]:
    """Returns the policies of an environment's file by name; none if it has no attribute `game`."""
    game = getattr(env, "game", None)
    return {} if game is None else {policy.name: policy for policy in game.policies}
