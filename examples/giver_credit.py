"""A reward for Gift Refinement that credits the giver: `--reward examples/giver_credit.py:giver_credit`."""

import jax.numpy as jnp

from sjdsl.trainers import Step

CREATED = 2  # tokens by a gift that is refined: three for one


def giver_credit(step: Step, *, credit: float = 2.0):
    """Returns `[N]`: what an agent consumes, and `credit` for each token that its gifts create; those of the finest create none."""
    before, after = (
        state.agent_bag.astype(jnp.int32) for state in (step.state, step.next_state)
    )  # stored as bytes
    events = step.events
    received = sum(events[f"received[{level}]"] for level in ("raw", "cut", "fine"))
    collected = (after - before).sum(axis=-1) - received + events["given"] + events["consumed"]
    refinable = before[:, 0] + before[:, 1] + collected > 0  # the least refined token is given
    return step.reward + credit * CREATED * jnp.where(refinable, events["given"], 0)
