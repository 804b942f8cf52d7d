"""The policy of a line-up that names who plays each agent, a person among them."""

from collections.abc import Callable, Sequence

from sjdsl.models.asking import PARALLEL, Ask, ask_policy
from sjdsl.models.hosted import hosted_policy
from sjdsl.runtime.env import Environment
from sjdsl.runtime.policy import MemoryPolicy, Policy, mixed_policy

from ..settings.policy_names import YOU
from .loading import find_host, find_policy


def seated_policy(
    seats: Sequence[str],
    env: Environment,
    find: Callable[[str, Environment], Policy] = find_policy,
    ask: Ask = ask_policy,
    parallel: int = PARALLEL,
) -> MemoryPolicy:
    """Returns the policy of a line-up; the agent of a person, `you`, takes action 0.

    Args:
      seats: the name of who plays each agent.
      find: returns a policy by its name, unless it is asked in words.
      ask: answers what those are asked, `parallel` at once at most.

    Raises:
      PolicyError: there is no such policy, or it doesn't fit `env`.
      ModelError: the agents of `env` can't be asked in words.
    """
    hosts = {}
    agents_of: dict[str, list[int]] = {}
    for agent, name in enumerate(seats):
        host = find_host(name)
        if host is not None:
            hosts[agent] = host
        elif name != YOU:
            agents_of.setdefault(name, []).append(agent)
    parts = [(agents, find(name, env)) for name, agents in agents_of.items()]
    others = mixed_policy(env.num_agents, parts)
    return hosted_policy(env, hosts, others, lambda _: ask, parallel) if hosts else others
