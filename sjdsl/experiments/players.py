"""Pools of policies by name: a single policy, or the seeds of one run; and which seeds of two pools
play together."""

import json
import warnings
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
from jax import Array

from sjdsl.compiler.ir.hash import policy_hash
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.models import HostPolicy, Model, told
from sjdsl.models.roles import wordings
from sjdsl.models.seats import check_playable
from sjdsl.policies.declared import declared_policies
from sjdsl.runtime.policy import Policy, take_actions, unchanged, with_memory
from sjdsl.trainers.environment import (
    Environment,
    abstract_key,
    info_shapes,
    reset_shapes,
)
from sjdsl.trainers.policies.digest import digest_of
from sjdsl.trainers.policies.loading import find_host, find_policy, read_parameters, trained_policy
from sjdsl.trainers.policies.policy_file import POLICIES, SUFFIX, policy_path
from sjdsl.trainers.runs.run_folder import describe_game
from sjdsl.trainers.runs.run_state import run_state
from sjdsl.trainers.runs.seeds_in_words import seeds_in_words, seeds_of_each
from sjdsl.trainers.settings.config import Config
from sjdsl.trainers.settings.extensions import file_of, name_of
from sjdsl.trainers.settings.policy_names import split_name

# Settings that only affect learning and the files of a run: policies that differ in nothing else
# are computed together.
_LEARNING = """
seed seeds total_timesteps num_envs num_steps gamma learning_rate anneal_learning_rate max_gradient_norm
init_from loss reward common_reward reward_smoothing svo_angle svo_weight svo_at_rest svo_quadrant
exchange_ratio inequity_envy inequity_guilt inequity_smoothing match_socialjax
checkpoint_minutes checkpoint_share checkpoint_updates policy_every keep_policies evaluate_every
evaluation_episodes num_epochs num_minibatches gae_lambda clip_epsilon scale_clip_epsilon
clip_value_loss entropy_coefficient value_coefficient spread_starts advantage_floor
adam_epsilon preference_noise replay q_lambda buffer_size batch_size gradient_steps learning_starts double_q
target_update_every target_rate epsilon_start epsilon_fraction
"""
LEARNING = frozenset(_LEARNING.split())


@dataclass(frozen=True, eq=False)
class Player:
    """One policy that can be put into a slot."""

    name: str  # of its pool
    seed: int | None  # it was trained with; None for a policy that was not trained
    digest: str | None  # SHA-256 of the file that holds it; of a Python function, `program_digest`
    kind: Hashable  # players of one kind differ in parameters only
    policy_of: Callable[[Any], Policy]  # returns the policy with the given parameters
    parameters: Any = ()
    host: HostPolicy | None = None  # asked in words; then `policy_of` only holds its slot


@dataclass(frozen=True, eq=False)
class Pool:
    """The policies of one name: several if they are the seeds of one run."""

    name: str
    players: tuple[Player, ...]
    notes: tuple[str, ...] = ()  # warnings about them
    diverged: tuple[int, ...] = ()  # seeds left out because they diverged

    @property
    def seeds(self) -> tuple[int, ...]:
        """The training seeds of its players."""
        return tuple(player.seed for player in self.players if player.seed is not None)

    @property
    def is_trained(self) -> bool:
        """Whether its players are trained policies, which have seeds."""
        return self.players[0].seed is not None

    def describe(self) -> dict[str, Any]:
        """Returns its players as JSON values."""
        return {
            "name": self.name,
            "players": [{"seed": player.seed, "digest": player.digest} for player in self.players],
        }


def find_pool(policy: str | Path | Policy, env: Environment) -> Pool:
    """Returns the pool of a name, or of a policy.

    Stored policies are read by this function, so that those of one network are computed together;
    `find_policy` resolves all other names.

    Args:
      policy: what `find_policy` takes; or the folder of a run of several seeds, `RUN`, `RUN@best`
        or `RUN@UPDATE`, for all of them.
    Raises:
      PolicyError: there is no such policy, or it or its run's manifest can't be read, or it doesn't
        fit `env`.
      ExperimentError: it was trained on another game, or its training diverged, or no seed of the
        run is left.
    """
    host = find_host(policy)
    if host is not None:
        return _host_pool(policy, host, env)
    if not isinstance(policy, str | Path):
        return _untrained_pool(name_of("policy", policy), policy, program_digest(policy, env))
    name = str(policy)
    declared = declared_policies(env)
    if name in declared:
        return _untrained_pool(name, find_policy(name, env), policy_hash(declared[name]))
    path, which = split_name(name)
    if path.suffix != SUFFIX and not path.is_dir():
        file = file_of(name)
        digest = _file_digest(file) if file is not None and file.is_file() else None
        return _untrained_pool(name, find_policy(name, env), digest)
    folders, diverged, notes = _seed_folders(path, which)
    for update, seeds in seeds_of_each(diverged.items()).items():
        notes.append(
            f"left out of {path}: {seeds_in_words(seeds)}, which diverged (non-finite loss) in "
            f"update {update}"
        )
    players = []
    seed_warnings: list[tuple[int, str]] = []  # a seed, and a warning about its policy
    for folder in folders:
        file = policy_path(folder, which)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            parameters, description = read_parameters(file, env)
        _require_same_game(file, description.game.model_dump(), env)
        for warning in caught:
            text = str(warning.message).replace(str(file), str(path))
            seed_warnings.append((description.seed, text))
        players.append(
            Player(
                name=name,
                seed=description.seed,
                digest=_file_digest(file),
                kind=acting_config(description.config),
                policy_of=partial(trained_policy, env, description.config),
                parameters=parameters,
            )
        )
    for text, seeds in seeds_of_each(seed_warnings).items():
        notes.append(f"{seeds_in_words(seeds)}: {text}" if len(folders) > 1 else text)
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return Pool(name, tuple(players), tuple(notes), tuple(diverged))


def _untrained_pool(name: str, policy: Policy, digest: str | None) -> Pool:
    """Returns the pool of a policy without parameters, which is computed with no other."""
    kind = ("a kind of its own", name)
    player = Player(name, seed=None, digest=digest, kind=kind, policy_of=lambda _: policy)
    return Pool(name, (player,))


def _host_pool(policy: Any, host: HostPolicy, env: Any) -> Pool:
    """Returns the pool of a policy that is asked in words.

    The digest is of all that its replies depend on: the settings of a model, and its texts.
    """
    check_playable(env)
    name = policy if isinstance(policy, str) else name_of("policy", policy)
    digest = None
    if isinstance(host, Model):
        if not isinstance(policy, str) and host.name:
            name = f"{host.name}+{host.role}" if host.role else host.name
        texts = [told(env, None, words, host.notebook) for words in wordings(host.role, env.game)]
        content = json.dumps([host.settings(), texts], sort_keys=True)
        digest = sha256(content.encode()).hexdigest()

    def waiting(key: Array, observation: Array) -> Array:
        del key, observation
        return jnp.zeros(env.num_agents, jnp.int32)

    kind = ("a kind of its own", name)
    player = Player(name, None, digest, kind, lambda _: waiting, host=host)
    return Pool(name, (player,))


def _file_digest(file: Path) -> str:
    return sha256(file.read_bytes()).hexdigest()


def _require_same_game(file: Path, trained_on: Mapping[str, Any], env: Environment) -> None:
    """Raises ExperimentError if the policy in `file` was trained on another game than `env`."""
    game = describe_game(env)
    for key, difference in (
        ("name", "another game"),
        ("action_names", "other actions"),
        ("observation_shape", "other observations"),
    ):
        if trained_on[key] != game[key]:
            there = _as_text(trained_on[key])
            here = _as_text(game[key])
            raise ExperimentError(f"{file} was trained on {difference}: {there} there, {here} here")


def _as_text(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def program_digest(policy: Policy, env: Environment) -> str:
    """Returns the SHA-256 of the program that JAX compiles a policy to, with its constants, and of
    its initial memory.

    It tells whether a Python function is the one that a folder was started with. A policy that
    calls back into Python has a different digest in every process.
    """
    recurrent = with_memory(policy)

    def act(memory: Any, key: Array, observation: Array, state: Any) -> tuple[Any, Array]:
        return take_actions(env, recurrent, memory, key, observation, state)

    program = jax.jit(act).lower(recurrent.start, abstract_key(), *reset_shapes(env)).as_text()
    if recurrent.after_step is not unchanged:
        actions = jax.ShapeDtypeStruct((env.num_agents,), jnp.int32)
        reward = jax.ShapeDtypeStruct((env.num_agents,), jnp.float32)
        of_step = (actions, reward, info_shapes(env))
        program += jax.jit(recurrent.after_step).lower(recurrent.start, *of_step).as_text()
    leaves = enumerate(jax.tree.leaves(recurrent.start))
    start = digest_of({str(number): leaf for number, leaf in leaves})
    return sha256(f"{start}\n{program}".encode()).hexdigest()


def _seed_folders(path: Path, which: str | int) -> tuple[list[Path], dict[int, int], list[str]]:
    """Returns the folders of the seeds that did not diverge (or just `path`), the updates in which
    the others diverged, and notes."""
    if not path.is_dir():
        return [path], {}, []
    state = run_state(path)
    diverged = {} if state is None else dict(state.diverged)
    is_update = isinstance(which, int)  # the policy of an update may be from before the divergence
    notes = []
    if not is_update and state is not None and state.unfinished:
        notes.append(f"{path} may not have finished its training: {state.unfinished}")
    folders = [folder for folder in path.glob("seed_*") if folder.is_dir()]
    folders.sort(key=_seed_number)
    if not folders or (path / POLICIES).is_dir():
        if diverged and not is_update:
            (update,) = diverged.values()
            raise ExperimentError(
                f"{path} diverged (non-finite loss) in update {update}; "
                f"name an earlier policy as {path}@UPDATE"
            )
        return [path], {}, notes
    remaining = [folder for folder in folders if _seed_number(folder) not in diverged]
    if not remaining:
        raise ExperimentError(
            f"every seed of {path} diverged (non-finite loss), so there is no policy to play"
        )
    return remaining, diverged, notes


def _seed_number(folder: Path) -> int:
    """Returns N of a folder `seed_N`; -1 if N is no number."""
    number = folder.name.removeprefix("seed_")
    return int(number) if number.isdecimal() else -1


def acting_config(config: Config) -> str:
    """Returns the settings that decide how a policy acts, as JSON: without those of learning.

    Policies with the same ones differ in their parameters only.
    """
    settings = config.model_dump(mode="json", exclude=set(LEARNING))
    return json.dumps(settings, sort_keys=True)


def replicates_of(pools: Sequence[Pool]) -> int:
    """Returns R, the number of training seeds of pools that `pair_pools` paired.

    Replicate i plays player i of each pool; a policy that was not trained plays with every seed.
    """
    return max(len(pool.players) for pool in pools)


def player_of(pool: Pool, replicate: int) -> Player:
    """Returns the player of a pool that a replicate uses."""
    return pool.players[replicate] if len(pool.players) > 1 else pool.players[0]


def pair_pools(pools: Sequence[Pool]) -> tuple[Pool, ...]:
    """Returns pools whose players at the same index play together: seeds with the same number, or
    the only ones.

    If a seed of one pool has diverged, that of the others is left out, with a note.

    Raises:
      ExperimentError: the pools have different seeds, or too few are left to play.
    """
    trained = [pool for pool in pools if pool.is_trained]
    seeds = {pool: sorted({*pool.seeds, *pool.diverged}) for pool in trained}
    if len(trained) < 2 or all(len(numbers) == 1 for numbers in seeds.values()):
        return tuple(pools)
    if len(set(map(tuple, seeds.values()))) > 1:
        raise ExperimentError(
            "pools must have the same seeds, as seed i of one plays with seed i of the others: "
            f"{_listed(seeds)}; name single seeds, such as RUN/seed_0, or train the same"
        )
    common = set.intersection(*(set(pool.seeds) for pool in trained))
    # If a single pair of several is left, the seeds are not the samples any more.
    fewest = min(2, *(len(pool.players) for pool in trained))
    if len(common) < fewest:
        number = "only one is" if common else "none is"
        raise ExperimentError(
            f"seeds with the same number play together, and {number} left in all pools: "
            f"{_listed({pool: pool.seeds for pool in trained})}; "
            "name single seeds, such as RUN/seed_0, or train more"
        )
    return tuple(_only_seeds(pool, common) if pool.is_trained else pool for pool in pools)


def _listed(seeds: Mapping[Pool, Sequence[int]]) -> str:
    """Returns the seeds of each pool, in words."""
    return "; ".join(
        f"{pool.name} has {', '.join(map(str, numbers))}" for pool, numbers in seeds.items()
    )


def _only_seeds(pool: Pool, seeds: set[int]) -> Pool:
    """Returns a pool with some of its seeds; a note and a warning name those left out."""
    left_out = [seed for seed in pool.seeds if seed not in seeds]
    if not left_out:
        return pool
    note = f"left out of {pool.name}: {seeds_in_words(left_out)}, which another pool lacks"
    warnings.warn(note, stacklevel=3)
    players = tuple(player for player in pool.players if player.seed in seeds)
    return replace(pool, players=players, notes=(*pool.notes, note))
