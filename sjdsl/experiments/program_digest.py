"""What a policy of Python does, as a checksum: by it a folder knows whether a function is the one that it was begun with."""

from hashlib import sha256
from typing import Any

import jax
from jax import Array

from sjdsl.runtime.policy import Policy, take_actions, with_memory
from sjdsl.trainers.digest import digest_of
from sjdsl.trainers.environment import Environment, abstract_key, reset_shapes


def program_digest(policy: Policy, env: Environment) -> str:
    """Returns the SHA-256 of the program that JAX makes of a policy, the numbers in it included, and of its first memory.

    A policy that calls back into Python has another in each process.
    """
    remembering = with_memory(policy)

    def act(memory: Any, key: Array, observation: Array, state: Any) -> tuple[Any, Array]:
        return take_actions(env, remembering, memory, key, observation, state)

    program = jax.jit(act).lower(remembering.start, abstract_key(), *reset_shapes(env)).as_text()
    start = digest_of({str(number): leaf for number, leaf in enumerate(jax.tree.leaves(remembering.start))})
    return sha256(f"{start}\n{program}".encode()).hexdigest()
