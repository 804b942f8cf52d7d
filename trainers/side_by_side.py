"""Runs side by side: those that differ only in numbers without shape are one program, with a lane for each seed of each run."""

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

# Keys of a configuration that losses and rewards only reckon with: they may be traced. All others shape arrays, or choose the program.
TRACED = (
    *("gamma", "learning_rate", "max_gradient_norm", "reward_smoothing", "svo_angle", "svo_weight", "exchange_ratio"),
    *(
        "inequity_envy",
        "inequity_guilt",
        "inequity_smoothing",
        "gae_lambda",
        "advantage_floor",
        "clip_epsilon",
        "entropy_coefficient",
        "value_coefficient",
    ),
    *("target_rate", "epsilon_start", "epsilon_end", "epsilon_fraction"),
)


@dataclass(frozen=True, eq=False)
class Part:
    """One of the runs that are trained by one program: most often the only one."""

    env: Environment
    config: Config
    run_dir: Path
    manifest: dict[str, Any]  # brought up to date as the run goes on

    @property
    def folders(self) -> tuple[Path, ...]:
        """Of each seed."""
        return seed_folders(self.run_dir, self.config)


def kind_of(env: Environment, config: Config) -> Hashable:
    """Returns what runs have alike that can be trained side by side: all but the seed, and numbers that may be traced."""
    own = None if hasattr(env, "with_params") else id(env)  # without it the game's numbers cannot be traced
    return env.hash, own, kind_of_config(config)


def kind_of_config(config: Config) -> Hashable:
    """Returns what configurations have alike of runs that can be trained side by side."""
    alike = {key: value for key, value in config.model_dump().items() if key not in TRACED and key != "seed"}
    return len(config.svo_angle), tuple(sorted((key, repr(value)) for key, value in alike.items()))


def joint_config(parts: Sequence[Part]) -> Config:
    """Returns the configuration of all parts together, with the lanes, from 0, for its seeds; of one part its own."""
    first = parts[0].config
    return first if len(parts) == 1 else first.model_copy(update={"seed": 0, "seeds": first.seeds * len(parts)})


def of_part(tree: Any, index: int, parts: Sequence[Part]) -> Any:
    """Returns one part's share of a tree that has all lanes', as its run would have it alone."""
    if len(parts) == 1:
        return tree
    seeds = parts[0].config.seeds
    lanes = index if seeds == 1 else slice(index * seeds, (index + 1) * seeds)
    return jax.tree.map(lambda leaf: leaf[lanes], tree)


def compile_parts(parts: Sequence[Part]) -> Compiled:
    """Compiles several runs of one kind as one program.

    Raises:
      NoMemoryError: they do not fit into memory together. ConfigError, PolicyError: as `make_train`.
    """
    first = parts[0]
    base = _with_roles(first.env, first.config)
    program = make_train(first.env, base)
    structure = _structure(program)
    numbers = _numbers(parts)

    def program_of(own: Mapping[str, Any]) -> Train:
        env: Any = first.env
        env = env.with_params(own["params"]) if "params" in own else env
        return _with_structure(make_train(env, base.model_copy(update=own["config"])), structure)

    seeds = [seed for part in parts for seed in part.config.seed_numbers]
    return compile_train(_with_structure(program, structure), joint_config(parts), Lanes(seeds, numbers, program_of))


def _with_roles(env: Environment, config: Config) -> Config:
    """Returns a configuration that says the agents' roles: they cannot be looked up where the game's numbers are traced."""
    asks = getattr(config, "sharing", "") == "by_role" and not getattr(config, "roles", ())
    return config.model_copy(update={"roles": getattr(env, "roles", None) or ()}) if asks else config


def _numbers(parts: Sequence[Part]) -> dict[str, Any]:
    """Returns the numbers in which the parts differ, `[L, ...]` each: of the configuration, and of the game if any does."""
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
    same = all(np.array_equal(one, other) for own in params for one, other in zip(own, params[0], strict=True))
    if same:
        return {"config": found}
    stacked = jax.tree.map(lambda *leaves: jnp.repeat(jnp.stack(leaves), seeds, axis=0), *(part.env.params for part in parts))
    return {"config": found, "params": stacked}


def _structure(program: Train) -> Any:
    return jax.tree.structure(jax.eval_shape(program.init, abstract_key()))


def _with_structure(program: Train, structure: Any) -> Train:
    """Returns a run whose states have a given structure.

    The structure of a state has the optimiser in it, a function, and that may hold a traced learning rate: outside it is another's.
    """
    own = _structure(program)

    def inside(state: TrainState) -> TrainState:
        result: TrainState = jax.tree.unflatten(own, jax.tree.leaves(state))
        return result

    def outside(state: TrainState) -> TrainState:
        result: TrainState = jax.tree.unflatten(structure, jax.tree.leaves(state))
        return result

    def collect(state: TrainState) -> tuple[TrainState, Any]:
        after, played = program.collect(inside(state))
        return outside(after), played

    def learn(state: TrainState, played: Any) -> tuple[TrainState, Any]:
        after, metrics = program.learn(inside(state), played)
        return outside(after), metrics

    return replace(program, init=lambda key: outside(program.init(key)), collect=collect, learn=learn, adopt=None)


class CheckpointsOfParts:
    """The checkpoints of runs that are trained side by side: each in the folder of its own run, as if it had been trained alone."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self._parts = parts
        self._each = [Checkpoints(part.run_dir) for part in parts]

    def save(self, update: int, state: Any, known: Mapping[str, Any]) -> None:
        """Writes the checkpoint of each part. Raises OSError when there is no room."""
        for index, checkpoints in enumerate(self._each):
            checkpoints.save(update, of_part(state, index, self._parts), known)

    def restore_last(self, compiled: Compiled) -> tuple[TrainState, int]:
        """Returns the state after the last update of which all have a checkpoint, and that update; the first state if none has any.

        A process that was killed while it saved leaves some runs a checkpoint further than others: these go back to the one before.

        Raises:
          RunError: they are not equally far, or a checkpoint cannot be read.
        """
        start = compiled.start()
        saved = [set(checkpoints.updates()) for checkpoints in self._each]
        if not any(saved):
            return start, 0
        common = set.intersection(*saved)
        if not common:
            raise RunError("runs that are not equally far cannot be gone on with side by side")
        update = max(common)
        for checkpoints, own in zip(self._each, saved, strict=True):
            for later in own:
                if later > update:
                    checkpoints.drop(later)
        try:
            states = [each.restore(update, of_part(start, index, self._parts))[0] for index, each in enumerate(self._each)]
        except CheckpointError as error:
            raise RunError(f"{error}; runs cannot be gone on with side by side without it") from None
        join = jnp.concatenate if self._parts[0].config.seeds > 1 else jnp.stack
        together = jax.tree.map(lambda *leaves: join(leaves), *states)
        return jax.device_put(together, jax.tree.map(lambda leaf: leaf.sharding, compiled.state)), update

    def close(self) -> None:
        for checkpoints in self._each:
            checkpoints.close()
