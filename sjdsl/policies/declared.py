"""The policies that the file of a game declares, and what tells one from another."""

from hashlib import sha256
from typing import Any

from sjdsl.compiler import ir
from sjdsl.compiler.ir.printer import node


def declared_policies(env: Any) -> dict[str, ir.ScriptedPolicy]:
    """Returns the policies of an environment's file by name; none where its rules are not at hand."""
    game = getattr(env, "game", None)
    return {} if game is None else {policy.name: policy for policy in game.policies}


def policy_digest(policy: ir.ScriptedPolicy) -> str:
    """Returns the SHA-256 of a policy's rules: policies are no part of a game's hash."""
    return sha256(node(policy).encode()).hexdigest()
