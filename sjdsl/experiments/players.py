"""Pools of policies by name: a policy alone, or the seeds of one run."""

import json
import warnings
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

from sjdsl.compiler.ir.hash import policy_hash
from sjdsl.experiments.program_digest import program_digest
from sjdsl.experiments.refusals import ExperimentError
from sjdsl.policies.declared import declared_policies
from sjdsl.runtime.policy import Policy
from sjdsl.trainers.config import Config
from sjdsl.trainers.environment import Environment
from sjdsl.trainers.extensions import file_of, name_of
from sjdsl.trainers.policies import find_policy, read_parameters, trained_policy
from sjdsl.trainers.policy_file import POLICIES, SUFFIX, policy_path
from sjdsl.trainers.policy_names import split_name
from sjdsl.trainers.run_folder import describe_game
from sjdsl.trainers.run_state import run_state

# Keys of a configuration that say how a policy learns and what is written of it: policies that differ in them alone are computed together.
LEARNING = frozenset(
    {
        *(
            "seed",
            "seeds",
            "total_timesteps",
            "num_envs",
            "num_steps",
            "gamma",
            "learning_rate",
            "anneal_learning_rate",
            "max_gradient_norm",
        ),
        *("init_from", "loss", "reward", "common_reward", "reward_smoothing", "svo_angle", "svo_weight", "svo_at_rest", "svo_quadrant"),
        *("exchange_ratio", "inequity_envy", "inequity_guilt", "inequity_smoothing", "match_socialjax"),
        *("checkpoint_minutes", "checkpoint_share", "checkpoint_updates", "policy_every", "keep_policies"),
        *("evaluate_every", "evaluation_episodes", "num_epochs", "num_minibatches", "gae_lambda", "clip_epsilon", "scale_clip_epsilon"),
        *("clip_value_loss", "entropy_coefficient", "value_coefficient", "joint_optimiser", "spread_starts", "advantage_floor"),
        *("team_reward", "similarity_clip", "individual_kl", "team_kl"),
        *("buffer_size", "batch_size", "gradient_steps", "learning_starts", "double_q", "target_update_every", "target_rate"),
        *("epsilon_start", "epsilon_fraction"),
    }
)


@dataclass(frozen=True, eq=False)
class Player:
    """One policy that can be put into a slot."""

    name: str  # of its pool
    seed: int | None  # that it was trained with
    digest: str | None  # SHA-256 of the file that it is stored, or written, in; of a function of Python, of what it does
    kind: Hashable  # players of one kind differ in parameters only
    policy_of: Callable[[Any], Policy]  # the policy of parameters
    parameters: Any = ()


@dataclass(frozen=True, eq=False)
class Pool:
    """The policies of one name: several where they are the seeds of one run."""

    name: str
    players: tuple[Player, ...]
    notes: tuple[str, ...] = ()  # what is to be said about them
    diverged: tuple[int, ...] = ()  # seeds that are left out, as their loss was not finite

    @property
    def seeds(self) -> tuple[int, ...]:
        """Of its trained players."""
        return tuple(player.seed for player in self.players if player.seed is not None)

    @property
    def is_trained(self) -> bool:
        """Whether its players are stored policies, which have training seeds."""
        return self.players[0].seed is not None

    def describe(self) -> dict[str, Any]:
        """Returns its players as JSON values."""
        return {"name": self.name, "players": [{"seed": player.seed, "digest": player.digest} for player in self.players]}


def find_pool(policy: str | Path | Policy, env: Environment) -> Pool:
    """Returns the pool of a name, or of a policy.

    Stored policies are read here, for those of one network are computed together. All other names are for `find_policy`, the one place
    where a name becomes a policy.

    Args:
      policy: what `find_policy` takes; or the folder of a run of several seeds, `RUN`, `RUN@best` or `RUN@UPDATE`, for all of them.
    Raises:
      PolicyError: there is none of that name, or it or its run's manifest cannot be read, or it does not fit `env`. ExperimentError: it was
      trained on another game, or its loss was not finite, or no seed of the run is left.
    """
    if not isinstance(policy, str | Path):
        own = name_of("policy", policy)
        return Pool(own, (replace(_untrained(own, policy), digest=program_digest(policy, env)),))
    name = str(policy)
    declared = declared_policies(env)
    if name in declared:
        scripted = replace(_untrained(name, find_policy(name, env)), digest=policy_hash(declared[name]))
        return Pool(name, (scripted,))
    path, which = split_name(name)
    if path.suffix != SUFFIX and not path.is_dir():
        return Pool(name, (_untrained(name, find_policy(name, env)),))
    folders, diverged, notes = _seed_folders(path, which)
    notes += [f"seed {seed} of {path} is left out: its loss was not finite in update {update}" for seed, update in diverged.items()]
    players = []
    for folder in folders:
        player, said = _stored(name, policy_path(folder, which), env)
        players.append(player)
        notes += said
    for note in notes:
        warnings.warn(note, stacklevel=2)
    return Pool(name, tuple(players), tuple(notes), tuple(diverged))


def _untrained(name: str, policy: Policy) -> Player:
    file = file_of(name)
    digest = sha256(file.read_bytes()).hexdigest() if file is not None and file.is_file() else None
    return Player(name, None, digest, ("one of its own", name), lambda _: policy)


def _seed_folders(path: Path, which: str | int) -> tuple[list[Path], dict[int, int], list[str]]:
    """Returns the folders of the seeds of a run that did not diverge, the updates in which the others did, and notes; else `path` alone."""
    state = run_state(path) if path.is_dir() else None
    diverged = {} if state is None else dict(state.diverged)
    named = isinstance(which, int)  # a policy of before may be meant
    notes = (
        [] if named or state is None or not state.unfinished else [f"{path} is not known to have ended its training: {state.unfinished}"]
    )
    folders = sorted((folder for folder in path.glob("seed_*") if folder.is_dir()), key=_number) if path.is_dir() else []
    if not folders or (path / POLICIES).is_dir():
        if diverged and not named:
            (update,) = diverged.values()
            raise ExperimentError(f"{path} has failed: its loss was not finite in update {update}; {path}@UPDATE is a policy of before")
        return [path], {}, notes
    left = [folder for folder in folders if _number(folder) not in diverged]
    if not left:
        raise ExperimentError(f"the loss of every seed of {path} was not finite at some point: there is no policy to play")
    return left, diverged, notes


def _number(folder: Path) -> int:
    """Returns the seed that a folder `seed_N` is of."""
    number = folder.name.removeprefix("seed_")
    return int(number) if number.isdecimal() else -1


def _stored(name: str, file: Path, env: Environment) -> tuple[Player, list[str]]:
    """Returns a stored policy, and the warnings about it."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        parameters, described = read_parameters(file, env)
    _check_game(file, described.game, env)
    player = Player(
        name=name,
        seed=described.seed,
        digest=sha256(file.read_bytes()).hexdigest(),
        kind=acting_kind(described.config),
        policy_of=partial(trained_policy, env, described.config),
        parameters=parameters,
    )
    return player, [str(warning.message) for warning in caught]


def acting_kind(config: Config) -> str:
    """Returns what policies have alike that differ in their parameters only."""
    acting = {key: value for key, value in config.model_dump(mode="json").items() if key not in LEARNING}
    return json.dumps(acting, sort_keys=True)


def _check_game(file: Path, trained_on: Any, env: Environment) -> None:
    """Raises ExperimentError where a policy is one of another game, or of other actions or observations: it would act, and mean nothing."""
    here = describe_game(env)
    for key, of_what in (("name", "another game"), ("action_names", "other actions"), ("observation_shape", "other observations")):
        there, now = trained_on.get(key), here[key]
        if there != now:
            raise ExperimentError(f"{file} was trained on {of_what}: {_shown(there)} there, {_shown(now)} here")


def _shown(value: Any) -> str:
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def replicates_of(pools: Sequence[Pool]) -> int:
    """Returns R, the number of training seeds of pools that `pair_pools` made equal; replicate i plays player i of each.

    A policy that was not trained plays with every seed.
    """
    return max(len(pool.players) for pool in pools)


def player_of(pool: Pool, replicate: int) -> Player:
    """Returns whom of a pool a replicate plays with."""
    return pool.players[replicate] if len(pool.players) > 1 else pool.players[0]
