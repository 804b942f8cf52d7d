"""Stored policies: found, loaded in a line, refused when they are damaged or of another game."""

import dataclasses
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import QUICK, matching

from sjdsl.cli.evaluate import stored_policy
from sjdsl.runtime.planes import TokenPlane
from sjdsl.trainers import (
    MemoryPolicy,
    PolicyError,
    evaluate,
    load_policy,
    make_config,
    trained_policy,
)
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.policies.policy_file import write_policy
from sjdsl.trainers.runs.run_folder import describe_game

ALWAYS_ONE = {
    "algorithm": "vdn",
    "network": "mlp",
    "network_width": 4,
    "buffer_size": 32,
    "epsilon_end": 0.0,
}


def _store(folder: Path, fill: float = 0.0, **values: object) -> Path:
    """Stores a policy of `matching` all of whose parameters are `fill`."""
    config = make_config(ALWAYS_ONE, **values)
    parameters = jax.tree.map(
        lambda leaf: np.full(leaf.shape, fill, leaf.dtype), parameter_shapes(matching(), config)
    )
    path = folder / "policies" / "best.safetensors"
    described = {
        "game": describe_game(matching()),
        "config": config.model_dump(mode="json"),
        "update": 3,
        "env_steps": 192,
        "seed": 0,
    }
    write_policy(path, parameters, described)
    return path


def test_three_lines_load_one(tmp_path: Path) -> None:
    path = _store(tmp_path)
    env = matching()
    policy = load_policy(str(path), env)
    actions = policy(jax.random.key(0), jnp.zeros((2, 1, 1, 1), jnp.uint8))
    assert actions.tolist() == [0, 0], "of equal values the first action is the best"


@pytest.mark.parametrize("load", [load_policy, stored_policy], ids=["python", "command line"])
@pytest.mark.parametrize(("greedy", "explores"), [(None, False), (True, False), (False, True)])
def test_values_are_played_by_their_best_actions_unless_drawn(
    tmp_path: Path, load: Callable[..., Any], greedy: bool | None, explores: bool
) -> None:
    """The run ended with every action explored; the best is the first. What is not named acts as it was meant to: an evaluation, a film."""
    policy = load(
        _store(tmp_path, epsilon_end=1.0),
        matching(),
        **({} if greedy is None else {"greedy": greedy}),
    )
    seen = jnp.zeros((2, 1, 1, 1), jnp.uint8)
    actions = np.asarray(
        jax.vmap(lambda key: policy(key, seen))(jax.random.split(jax.random.key(0), 64))
    )
    assert actions.any() == explores


@pytest.mark.parametrize(
    "damage", ["cut", "empty", "flipped", "no json", "json cut", "json of a future version"]
)
def test_what_is_damaged_is_refused_by_name(tmp_path: Path, damage: str) -> None:
    path = _store(tmp_path)
    content, beside = path.read_bytes(), path.with_suffix(".json")
    match damage:
        case "cut":
            path.write_bytes(content[: len(content) // 2])
        case "empty":
            path.write_bytes(b"")
        case "flipped":
            path.write_bytes(b"\xff" + content[1:])
        case "no json":
            beside.unlink()
        case "json cut":
            beside.write_text(beside.read_text()[:40])
        case _:
            read = json.loads(beside.read_text())
            beside.write_text(json.dumps(read | {"config": read["config"] | {"plasticity": 1}}))
    with pytest.raises(PolicyError, match=r"best\.safetensors cannot be read"):
        load_policy(path, matching())


def test_what_does_not_fit_is_refused(tmp_path: Path) -> None:
    path = _store(tmp_path)
    with pytest.raises(
        PolicyError,
        match=r"doesn't fit matching: it was trained on matching with 2 actions .*; here are 3 actions",
    ):
        load_policy(path, dataclasses.replace(matching(), num_actions=3))
    with pytest.warns(
        UserWarning, match=r"another form of the game: matching probe, not matching changed"
    ):
        load_policy(path, dataclasses.replace(matching(), hash="changed"))
    others = dataclasses.replace(
        matching(), hash="changed", token_planes=(TokenPlane("shown", "word", tuple("abc")),)
    )
    with (
        pytest.warns(UserWarning, match="another form of the game"),
        pytest.raises(
            PolicyError,
            match=r"with 2 actions .*; here are 2 actions .* If these are equal, windows show other things",
        ),
    ):
        load_policy(path, others)
    with pytest.raises(PolicyError, match="does not exist"):
        load_policy(tmp_path / "none.safetensors", matching())


def test_a_folder_says_what_it_has(tmp_path: Path) -> None:
    with pytest.raises(
        PolicyError, match=r"is not the folder of a training run: it has no manifest\.json"
    ):
        load_policy(tmp_path, matching())
    (tmp_path / "manifest.json").write_text("{}")
    _store(tmp_path)
    with pytest.raises(PolicyError, match="has no policy called last, but of best"):
        load_policy(tmp_path, matching())
    assert load_policy(tmp_path, matching(), which="best") is not None
    shutil.rmtree(tmp_path / "policies")
    with pytest.raises(PolicyError, match="holds no policy yet"):
        load_policy(tmp_path, matching())


def test_a_policy_with_memory_starts_each_episode_afresh() -> None:
    """And is told from one without: its actions come with what it remembers."""
    config = make_config({**QUICK, "memory": "gru"})
    parameters = jax.tree.map(
        lambda leaf: np.full(leaf.shape, 0.1, leaf.dtype), parameter_shapes(matching(), config)
    )
    policy = trained_policy(matching(), config, parameters)
    assert isinstance(policy, MemoryPolicy)
    memory, actions = jax.jit(policy.act)(
        policy.start, jax.random.key(0), jnp.zeros((2, 1, 1, 1), jnp.uint8)
    )
    assert actions.shape == (2,)
    assert jax.tree.map(jnp.shape, memory) == jax.tree.map(jnp.shape, policy.start)
    assert any(
        (old != new).any()
        for old, new in zip(jax.tree.leaves(policy.start), jax.tree.leaves(memory), strict=True)
    )
    returns = evaluate(matching(), policy, jax.random.key(1), 50).returns
    assert returns.shape == (50, 2)
    assert 0 < returns.mean() < 1


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_numbers_that_are_not_finite_are_refused(tmp_path: Path, number: float) -> None:
    path = _store(tmp_path, fill=number)
    with pytest.raises(
        PolicyError, match=r"best\.safetensors holds non-finite numbers, in .*kernel"
    ):
        load_policy(path, matching())


def test_names_are_stored_by_their_whole_paths(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = tmp_path / "runs" / "a"
    run.mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    names = ("runs/a", "./runs/a/", "./runs/a@best", "runs//a@7")
    partners = make_config(algorithm="vdn", partners=dict(enumerate(names))).partners
    assert partners == tuple(enumerate((f"{run}", f"{run}", f"{run}@best", f"{run}@7")))
