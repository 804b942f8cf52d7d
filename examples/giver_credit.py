"""A reward for Gift Refinement that credits the giver: `--reward examples/giver_credit.py:giver_credit`."""

import jax.numpy as jnp

from sjdsl.trainers import Step


def giver_credit(step: Step, *, credit: float = 2.0):
    """Returns `[N]`: what an agent consumes, and `credit` for each gift of a token that can still be refined, which becomes three."""
    raw, cut, _ = step.state.agent_bag.T  # [N] tokens before the step
    received = sum(step.events[f"received[{level}]"] for level in ("raw", "cut", "fine"))
    given, consumed = step.events["given"], step.events["consumed"]
    collected = step.next_state.agent_bag.sum(axis=-1) - step.state.agent_bag.sum(axis=-1) - received + given + consumed
    return step.reward + credit * jnp.where(raw + cut + collected > 0, given, 0)
