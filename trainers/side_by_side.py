"""Runs side by side: those that differ only in numbers without shape are one program, with a lane for each seed of each run."""

import warnings
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from .algorithms import make_train
from .checkpoints import CheckpointError, Checkpoints
from .compiled import Compiled, Lanes, compile_train
from .config import Config
from .environment import Environment, abstract_key
from .run_errors import RunError
from .run_folder import seed_folders
from .training_functions import Train, TrainState

# Keys of a configuration that losses and rewards only calculate with, so that they may be traced. All others shape arrays, or choose the program.
TRACED = (
    *("gamma", "learning_rate", "max_gradient_norm", "reward_smoothing", "svo_angle", "svo_weight", "exchange_ratio"),
    *("inequity_envy", "inequity_guilt", "inequity_smoothing", "gae_lambda", "advantage_floor", "clip_epsilon"),
    *("entropy_coefficient", "value_coefficient", "target_rate", "epsilon_start", "epsilon_end", "epsilon_fraction"),
)


@dataclass(frozen=True, eq=False)
class Part:
    """One of the runs that one program trains, most often the only one."""

    env: Environment
    config: Config
    run_dir: Path
    manifest: dict[str, Any]  # updated as the run goes on

    @property
    def folders(self) -> tuple[Path, ...]:
        """Of each seed."""
        return seed_folders(self.run_dir, self.config)


def kind_of(env: Environment, config: Config) -> Hashable:
    """Returns what runs must share to be trained side by side: everything but the seed and numbers that may be traced."""
    own = None if hasattr(env, "with_params") else id(env)  # without it the game's numbers cannot be traced
    return env.hash, own, kind_of_config(config)


def kind_of_config(config: Config) -> Hashable:
    """Returns what configurations must share for their runs to be trained side by side."""
    shared = {key: value for key, value in config.model_dump().items() if key not in TRACED and key != "seed"}
    return len(config.svo_angle), tuple(sorted((key, repr(value)) for key, value in shared.items()))


def joint_config(parts: Sequence[Part]) -> Config:
    """Returns the configuration of all parts together, whose seeds are the lanes from 0; of a single part, its own."""
    first = parts[0].config
    return first if len(parts) == 1 else first.model_copy(update={"seed": 0, "seeds": first.seeds * len(parts)})


def of_part(tree: Any, index: int, parts: Sequence[Part]) -> Any:
    """Returns one part's share of a tree of all lanes, as its run would have it alone."""
    if len(parts) == 1:
        return tree
    seeds = parts[0].config.seeds
    lanes = index if seeds == 1 else slice(index * seeds, (index + 1) * seeds)
    return jax.tree.map(lambda leaf: leaf[lanes], tree)


def compile_parts(parts: Sequence[Part]) -> Compiled:
    """Compiles several runs of one kind as one program.

    Raises:
      NoMemoryError: they don't fit into memory together. ConfigError, PolicyError: as `make_train`.
    """
    first = parts[0]
    base = first.config
    if getattr(base, "sharing", "") == "by_role" and not getattr(
        base, "roles", ()
    ):  # can't be looked up while the game's numbers are traced
        base = base.model_copy(update={"roles": getattr(first.env, "roles", None) or ()})
    program = make_train(first.env, base)
    structure = _structure(program)
    numbers = _numbers(parts)

    def program_of(own: Mapping[str, Any]) -> Train:
        env: Any = first.env
        env = env.with_params(own["params"]) if "params" in own else env
        return _with_structure(make_train(env, base.model_copy(update=own["config"])), structure)

    seeds = [seed for part in parts for seed in part.config.seed_numbers]
    return compile_train(_with_structure(program, structure), joint_config(parts), Lanes(seeds, numbers, program_of))


def _numbers(parts: Sequence[Part]) -> dict[str, Any]:
    """Returns the numbers in which the parts differ, `[L, ...]` each: of the configuration, and of the game if those differ."""
    configs = [part.config for part in parts]
    seeds = configs[0].seeds

    def by_lane(values: Sequence[Any]) -> jax.Array:
        return jnp.asarray(np.repeat(np.asarray(values, np.float32), seeds))

    found: dict[str, Any] = {}
    for key in TRACED:
        values = [getattr(config, key, None) for config in configs]
        if all(value == values[0] for value in values):
            continue
        found[key] = tuple(map(by_lane, zip(*values, strict=True))) if isinstance(values[0], tuple) else by_lane(values)
    params = [jax.tree.leaves(part.env.params) for part in parts]
    if all(np.array_equal(one, other) for own in params for one, other in zip(own, params[0], strict=True)):
        return {"config": found}
    stacked = jax.tree.map(lambda *leaves: jnp.repeat(jnp.stack(leaves), seeds, axis=0), *(part.env.params for part in parts))
    return {"config": found, "params": stacked}


def _structure(program: Train) -> Any:
    return jax.tree.structure(jax.eval_shape(program.init, abstract_key()))


def _with_structure(program: Train, structure: Any) -> Train:
    """Returns a run whose states have a given structure.

    The structure of a state includes the optimiser, a function, which may hold a traced learning rate: outside it is a different one.
    """
    own = _structure(program)

    def restructured(state: TrainState, structure: Any) -> TrainState:
        result: TrainState = jax.tree.unflatten(structure, jax.tree.leaves(state))
        return result

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        after, played = program.collect(restructured(state, own))
        return restructured(after, structure), played

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Any]:
        after, metrics = program.learn(restructured(state, own), played)
        return restructured(after, structure), metrics

    return replace(program, init=lambda key: restructured(program.init(key), structure), collect=collect, learn=learn, adopt=None)


class PartCheckpoints:
    """The checkpoints of one run, or of runs that are trained side by side: each in its run's folder, as if trained alone."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self._parts = parts
        self._each = [Checkpoints(part.run_dir) for part in parts]

    def save(self, update: int, state: Any) -> None:
        """Writes the checkpoint of each part. Raises OSError when there is no room."""
        for index, checkpoints in enumerate(self._each):
            checkpoints.save(update, of_part(state, index, self._parts))

    def restore_last(self, compiled: Compiled) -> tuple[TrainState, int]:
        """Returns the state after the last update of which all parts have a checkpoint, and that update; else the first state, and 0.

        A process that was killed while it saved leaves some runs one checkpoint further than others: these go back to the one before. An
        unreadable checkpoint of a single run is dropped with a warning; the run reaches the same figures again from the one before.

        Raises:
          RunError: parts stopped at different updates, or a checkpoint of several parts can't be read.
        """
        start = compiled.start()
        saved = [set(checkpoints.updates()) for checkpoints in self._each]
        common = set.intersection(*saved)
        if any(saved) and not common:
            raise RunError("runs stopped at different updates cannot be resumed together")
        for update in sorted(common, reverse=True):
            for checkpoints, own in zip(self._each, saved, strict=True):
                for later in own:
                    if later > update and len(self._parts) > 1:
                        checkpoints.drop(later)
            try:
                states = [each.restore(update, of_part(start, index, self._parts)) for index, each in enumerate(self._each)]
            except CheckpointError as error:
                if len(self._parts) > 1:
                    raise RunError(f"{error}; without it, these runs can't be resumed side by side") from None
                warnings.warn(f"{error}; resuming from the one before", stacklevel=2)
                self._each[0].drop(update)
                continue
            if len(states) == 1:
                return states[0], update
            join = jnp.concatenate if self._parts[0].config.seeds > 1 else jnp.stack
            joined: TrainState = jax.tree.map(lambda *leaves, join=join: join(leaves), *states)
            return jax.device_put(joined, jax.tree.map(lambda leaf: leaf.sharding, compiled.state)), update
        return start, 0

    def close(self) -> None:
        for checkpoints in self._each:
            checkpoints.close()
