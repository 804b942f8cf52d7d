"""Finds and loads policies by name: random, constant, scripted or stored in a file."""

import inspect
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.compiler.lower import NotSupported
from sjdsl.models import HostPolicy, ModelError, find_model, is_model_name
from sjdsl.policies.compiled import scripted_policy
from sjdsl.policies.declared import declared_policies
from sjdsl.runtime.policy import (
    UNTRAINED,
    MemoryPolicy,
    Policy,
    mixed_policy,
    random_policy,
    stay_policy,
    with_memory,
)

from ..algorithms.own_algorithm import make_own
from ..algorithms.partners import NOBODY, Partners
from ..algorithms.training_functions import Train
from ..environment import Environment, abstract_key, reset_shapes
from ..networks.action_values import best_action, explore, make_action_values
from ..networks.actor_critics import make_actor_critics
from ..networks.masks import masked, wants_masks
from ..networks.teams import learning_agents
from ..networks.value_scale import converted
from ..settings.config import Config, ConfigError, PPOConfig, VDNConfig
from ..settings.extensions import find, is_own
from ..settings.policy_names import split_name, unknown_policy
from ..settings.stage_settings import SHAPING_NETWORKS
from .policy_file import Described, PolicyError, policy_path, read_policy

__all__ = [
    "MemoryPolicy",
    "Policy",
    "PolicyError",
    "find_policy",
    "load_policy",
    "mixed_policy",
    "random_policy",
    "stay_policy",
    "trained_policy",
    "with_memory",
]


def find_policy(
    policy: str | Path | Policy, env: Environment, greedy: bool | None = None
) -> Policy:
    """Returns a policy by name; a policy is returned unchanged.

    Args:
      policy: `random`, `stay`, the name of a policy in the game's file, the folder of a run,
        `RUN@best`, `RUN@UPDATE`, `RUN/seed_N`, a `.safetensors` file, `FILE.py:FUNCTION`, or a
        registered name; or a function `(key, observation [N, P, V, V]) -> actions [N]`, or a
        `MemoryPolicy`.
      env: the environment to act in.
      greedy: for a trained policy, as in `trained_policy`.
    Raises:
      PolicyError: there is no such policy, or it doesn't fit `env`.
    """
    refuse_host(policy)
    if not isinstance(policy, str | Path):
        return policy
    name = str(policy)
    if name in UNTRAINED:
        try:
            return UNTRAINED[name](env)
        except ValueError as error:
            raise PolicyError(str(error)) from None
    declared = declared_policies(env)
    if name in declared:
        return _compile_scripted(name, env)
    path, which = split_name(name)
    if path.exists() or path.suffix == ".safetensors":
        return load_policy(path, env, greedy, which)
    if is_own("policy", name):
        users: Policy = find("policy", name)  # there is one, or `refuse_host` would have raised
        _check_arguments(name, users)
        return users
    raise PolicyError(unknown_policy(name, tuple(declared)))


def find_host(policy: Any) -> HostPolicy | None:
    """Returns a policy that is asked in words: `FILE.toml:NAME[+ROLE]`, `FILE.py:NAME`, or one itself.

    None for every other policy.

    Raises:
      PolicyError: its file is wrong.
    """
    if isinstance(policy, HostPolicy):
        return policy
    if not isinstance(policy, str | Path):
        return None
    name = str(policy)
    try:
        if is_model_name(name):
            return find_model(name)
        if is_own("policy", name) and not Path(name).exists():
            users = find("policy", name)
            return users if isinstance(users, HostPolicy) else None
    except (ConfigError, ModelError) as error:
        raise PolicyError(str(error)) from None
    return None


def refuse_host(policy: Any) -> None:
    """Raises PolicyError for a policy that is asked in words."""
    if find_host(policy) is not None:
        raise PolicyError(
            f"{policy} is asked in words, outside of compiled code, so it can't act in it, neither "
            "as a partner in training nor in `evaluate` without --scenario; it can play in "
            "crossplay, schelling, evaluate --scenario, play, record and render"
        )


def _compile_scripted(name: str, env: Environment) -> Policy:
    """Returns a policy of the game's file, compiled. Raises PolicyError if it can't be."""
    try:
        return scripted_policy(env, name)
    except NotSupported as refused:
        reason = f"{refused.feature} is not supported yet"
        if refused.origin is not None:
            reason += f" ({refused.origin.file}, line {refused.origin.line})"
        if refused.instead:
            reason += f"; {refused.instead}"
        raise PolicyError(f"the policy `{name}` can't be compiled: {reason}") from None


def _check_arguments(name: str, policy: Any) -> None:
    """Raises PolicyError for a function that can't be called as a policy.

    JAX would print a long traceback for it.
    """
    if hasattr(policy, "act"):
        return
    if not callable(policy):
        raise PolicyError(f"the policy `{name}` must be a function, not {policy!r}")
    try:
        arguments = inspect.signature(policy)
    except ValueError:  # some functions of C extensions have no signature
        return
    try:
        arguments.bind(None, None)
    except TypeError:
        raise PolicyError(
            f"the policy `{name}` is called with a key and an observation, but takes {arguments}"
        ) from None


def trained_policy(
    env: Environment, config: Config, parameters: Any, greedy: bool | None = None
) -> Policy:
    """Returns the policy with the given parameters.

    Args:
      config: of the run; agents that it held fixed act by their own policies.
      greedy: whether to take the best action instead of drawing one. None: as the algorithm
        intends, that is, actors draw their actions, and action values take the best. Action values
        with `greedy=False` explore as the run did at its end.
    """
    # Parameters from a file are NumPy arrays, which some transformations reject.
    parameters = jax.tree.map(jnp.asarray, parameters)
    match config:
        case PPOConfig() if "algorithm" in config.hooks:
            make_policy = _own_program(env, config).policy
            assert make_policy is not None
            policy = make_policy(parameters, greedy)
        case PPOConfig():
            policy = _actor_policy(env, config, parameters, bool(greedy))
        case VDNConfig():
            policy = _value_policy(env, config, parameters, greedy is None or greedy)
    return with_partners(env, config, policy)


def _own_program(env: Environment, config: PPOConfig) -> Train:
    """Returns the run of a custom algorithm, just for its policy.

    A custom reward or loss isn't imported.
    """
    return make_own(env, config.model_copy(update={"reward": "individual", "loss": "ppo"}))


def _actor_policy(env: Environment, config: PPOConfig, parameters: Any, greedy: bool) -> Policy:
    """Returns the policy of actors: it draws its actions, or takes the most probable."""
    networks = make_actor_critics(env, config)

    def act(
        memory: Any, key: Array, observation: Array, allowed: Array | None = None
    ) -> tuple[Any, Array]:
        """Returns the memory afterwards and an action for each agent, `[N]` int32."""
        # An episode starts with the memory `start`, so no step has to reset it.
        never_reset = jnp.zeros((1, 1), bool)
        memory, logits, _ = networks.apply(
            parameters, memory, observation[None, None], networks.blank_joint, never_reset
        )
        logits = masked(logits[0, 0], allowed)
        action = jnp.argmax(logits, axis=-1) if greedy else jax.random.categorical(key, logits)
        return memory, action.astype(jnp.int32)

    def after_step(memory: Any, actions: Array, reward: Array, info: Mapping[str, Any]) -> Any:
        actions, reward, info = jax.tree.map(lambda leaf: leaf[None], (actions, reward, info))
        return networks.after_step(memory, actions, reward, info)

    policy = _simplest_policy(networks.start_memory(1), act, networks.masks)
    if not config.memory_reads:
        return policy
    return replace(with_memory(policy), after_step=after_step)


def _value_policy(env: Environment, config: VDNConfig, parameters: Any, greedy: bool) -> Policy:
    """Returns the policy of action values: it takes the best action, or explores."""
    network = make_action_values(env, config)

    def act(
        memory: Any, key: Array, observation: Array, allowed: Array | None = None
    ) -> tuple[Any, Array]:
        """Returns the action of each agent, `[N]` int32; there is no memory."""
        values = cast(Array, network.apply(parameters, observation))
        if greedy:
            return memory, best_action(values, allowed)
        return memory, explore(key, values, allowed, config.epsilon_end)

    return _simplest_policy((), act, wants_masks(env, config))


def _simplest_policy(
    start: Any, act: Callable[..., tuple[Any, Array]], reads_allowed: bool
) -> Policy:
    """Returns a policy in its simplest form.

    It is a function of key and observation if it has no memory and needs no masks.
    """
    if reads_allowed or jax.tree.leaves(start):
        return MemoryPolicy(start, act, reads_allowed)
    return lambda key, observation: act(start, key, observation)[1]


def parameter_shapes(env: Environment, config: Config) -> Any:
    """Returns the shapes and dtypes of the parameters of a configuration's policy."""
    key = abstract_key()
    if isinstance(config, VDNConfig):
        observation, _ = reset_shapes(env)
        return jax.eval_shape(make_action_values(env, config).init, key, observation)
    assert isinstance(config, PPOConfig)
    if "algorithm" in config.hooks:
        program = _own_program(env, config)
        return jax.eval_shape(lambda key: program.parameters(program.init(key)), key)
    return jax.eval_shape(partial(make_actor_critics(env, config).init, env=env), key)


def load_policy(
    source: Path | str, env: Environment, greedy: bool | None = None, which: str | int = "last"
) -> Policy:
    """Returns a stored policy.

    Args:
      source: the folder of a run, or one of the `.safetensors` files in its `policies`, with the
        `.json` file beside it.
      env: the environment to act in, with the same actions and observation planes as in training.
        Another variant or other parameters are allowed, with a warning.
      greedy: whether to take the best action or draw one; None: as the algorithm intends, see
        `trained_policy`.
      which: for a folder, `last`, `best` (by its evaluations), or the number of an update.
    Raises:
      PolicyError: there is no such policy, or it can't be read, or it doesn't fit `env`; or it
        needs custom code, a network or a partner's policy, that `allow_code` has not allowed.
    """
    path = policy_path(Path(source), which)
    parameters, described = read_parameters(path, env)
    with _refusing_circles(path.resolve()):
        return trained_policy(env, described.config, parameters, greedy)


# The files of the policies that are being loaded: one, its partner, and so on.
_LOADING: ContextVar[frozenset[Path]] = ContextVar("_LOADING", default=frozenset())


@contextmanager
def _refusing_circles(path: Path) -> Iterator[None]:
    """Raises PolicyError if a policy is among its own partners, directly or through theirs."""
    if path in _LOADING.get():
        raise PolicyError(
            f"{path} is its own partner, directly or through others, so it can't be loaded"
        )
    before = _LOADING.set(_LOADING.get() | {path})
    try:
        yield
    finally:
        _LOADING.reset(before)


def load_parameters(name: str, env: Environment, config: Config) -> Any:
    """Returns the parameters of the policy that a run with `config` starts from.

    Raises:
      ConfigError: its networks differ from the run's.
      PolicyError: it isn't a stored policy, or can't be read.
    """
    file = policy_path(*split_name(name))
    parameters, described = read_parameters(file, env)
    stored = described.config
    is_own_algorithm = "algorithm" in config.hooks
    if isinstance(config, PPOConfig) and isinstance(stored, PPOConfig) and not is_own_algorithm:
        parameters = converted(parameters, config.normalise_values)
    wanted = jax.tree.map(lambda leaf: leaf.shape, parameter_shapes(env, config))
    if jax.tree.map(jnp.shape, parameters) == wanted:
        return parameters
    differences = []
    for setting in SHAPING_NETWORKS:
        there = getattr(stored, setting, "none")
        here = getattr(config, setting, "none")
        if there != here:
            differences.append(f"{setting} = {there} there and {here} here")
    reason = "; ".join(differences) or "it is for another game"
    raise ConfigError(f"a run can't start from {file}, whose networks differ: {reason}")


def read_parameters(path: Path, env: Environment) -> tuple[Any, Described]:
    """Returns the parameters and the description of a stored policy.

    Raises:
      PolicyError: it can't be read, or doesn't fit `env`.
    """
    parameters, described = read_policy(path, lambda config: parameter_shapes(env, config))
    game = described.game
    if game.hash != env.hash:
        warnings.warn(
            f"{path} was trained on another form of the game: {game.name} {game.hash}, "
            f"not {env.name} {env.hash}",
            stacklevel=2,
        )
    if parameters is None:
        observation, _ = reset_shapes(env)
        raise PolicyError(
            f"{path} doesn't fit {env.name}: it was trained on {game.name} with "
            f"{len(game.action_names)} actions and observations {game.observation_shape}; "
            f"here are {env.num_actions} actions and observations {list(observation.shape)}. If "
            "these are equal, windows show other things: name the variant, map and observation "
            "that it was trained with"
        )
    return parameters, described


def make_partners(env: Environment, config: Config) -> Partners:
    """Returns the agents that are held fixed, and their policies.

    Raises:
      ConfigError: they are not agents of the game.
      PolicyError: a policy can't be found, or doesn't fit.
    """
    if not config.partners:
        return NOBODY
    learning_agents(env.num_agents, config)  # raises
    agents = tuple(agent for agent, _ in config.partners)
    policy = mixed_policy(env.num_agents, _partners_policies(env, config))
    return Partners(agents, policy)


def with_partners(env: Environment, config: Config, policy: Policy) -> Policy:
    """Returns a policy of all agents.

    The learning ones act by `policy`, and their partners as in training.
    """
    if not config.partners:
        return policy
    learning = (learning_agents(env.num_agents, config), with_memory(policy))
    return mixed_policy(env.num_agents, [learning, *_partners_policies(env, config)])


def _partners_policies(env: Environment, config: Config) -> list[tuple[tuple[int, ...], Policy]]:
    """Returns the policies of partners, each with the agents that act by it."""
    agents_of: dict[str, list[int]] = {}
    for agent, name in config.partners:
        agents_of.setdefault(name, []).append(agent)
    return [(tuple(agents), find_policy(name, env)) for name, agents in agents_of.items()]
