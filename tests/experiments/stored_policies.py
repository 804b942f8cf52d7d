"""Policies in files without training: parameters that are drawn, and so large that the same observation leads to the same action."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import jax
import numpy as np

from sjdsl.trainers import make_config
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.policies.policy_file import write_policy
from sjdsl.trainers.runs.run_folder import describe_game

NETWORK = {"network": "mlp", "network_width": 8}
SURE = 30.0  # standard deviation of parameters: actions are as good as certain


def store(
    folder: Path,
    env: Any,
    seed: int,
    game: dict[str, Any] | None = None,
    update: int = 1,
    **values: Any,
) -> Path:
    """Stores a policy as the last of a run in `folder`; returns its file. `game`: in place of what is known of the game."""
    config = make_config(NETWORK, **values)
    drawn = np.random.default_rng(seed)
    parameters = jax.tree.map(
        lambda leaf: drawn.normal(0, SURE, leaf.shape).astype(leaf.dtype),
        parameter_shapes(env, config),
    )
    file = folder / "policies" / "last.safetensors"
    described = {
        "game": describe_game(env) | (game or {}),
        "config": config.model_dump(mode="json"),
        "update": update,
        "env_steps": 8,
    }
    write_policy(file, parameters, {**described, "seed": seed})
    return file


def store_pool(
    folder: Path, env: Any, seeds: Sequence[int], diverged: Sequence[int] = (), **values: Any
) -> Path:
    """Stores a run of several seeds; returns its folder."""
    for seed in seeds:
        store(folder / f"seed_{seed}", env, seed, **values)
    store_manifest(folder, diverged=[{"seed": seed, "update": 3} for seed in diverged])
    return folder


def store_manifest(folder: Path, **parts: Any) -> None:
    """Writes what a manifest must have, and further parts."""
    manifest = {"game": {}, "config": {}, "versions": {}, **parts}
    (folder / "manifest.json").write_text(json.dumps(manifest))
