"""Loading a policy runs no code that only its files name, and a damaged one is refused with a message."""

import json
import sys
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import matching
from safetensors.numpy import load_file, save_file

from sjdsl.cli import run as command_line
from sjdsl.trainers import (
    Config,
    PolicyError,
    RunError,
    allow_code,
    find_policy,
    load_policy,
    make_config,
    resume,
)
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.policies.policy_file import DIGEST, digests_of, read_policy, write_policy
from sjdsl.trainers.runs.run_folder import describe_game, versions

SMALL = {"algorithm": "ippo", "network": "mlp", "network_width": 4}
SEEN = jnp.zeros((2, 1, 1, 1), jnp.uint8)
CODE = """
from pathlib import Path
Path(__file__).with_suffix(".ran").touch()
import flax.linen as nn
import jax.numpy as jnp

class Net(nn.Module):
    width: int = 4

    @nn.compact
    def __call__(self, tokens):
        return nn.Dense(self.width)(tokens.reshape(len(tokens), -1).astype(jnp.float32))

def reward(step):
    return step.reward

def act(key, observation):
    return jnp.ones(len(observation), jnp.int32)

def told(update):
    pass

def learner(env, config):
    from sjdsl.trainers import make_train
    return make_train(env, config)
"""


def store(folder: Path, **values: object) -> Path:
    config = make_config(SMALL)
    parameters = jax.tree.map(
        lambda leaf: np.zeros(leaf.shape, leaf.dtype), parameter_shapes(matching(), config)
    )
    path = folder / "policies" / "last.safetensors"
    described = {
        "game": describe_game(matching()),
        "config": config.model_dump(mode="json"),
        "update": 3,
        "env_steps": 192,
        "seed": 0,
    }
    write_policy(path, parameters, described)
    if values:
        rewrite(path, {**described, "config": {**described["config"], **values}})
    return path


def rewrite(path: Path, content: object) -> None:
    """Writes what stands beside a policy, with digests that fit: as a stranger would."""
    text = json.dumps(content).encode()
    path.with_suffix(".json").write_bytes(text)
    tensors = load_file(path)
    save_file(tensors, path, {DIGEST: digests_of(tensors, text)})


@pytest.fixture
def code(tmp_path: Path) -> Path:
    path = tmp_path / "theirs.py"
    path.write_text(CODE)
    return path


def ran(code: Path) -> bool:
    return code.with_suffix(".ran").exists()


def test_a_reward_of_ones_own_is_no_part_of_acting(tmp_path: Path, code: Path) -> None:
    path = store(tmp_path, reward=f"{code}:reward", loss=f"{code}:reward")
    assert np.asarray(load_policy(path, matching())(jax.random.key(0), SEEN)).shape == (2,)
    assert not ran(code)
    path = store(tmp_path, reward="registered in another process")
    load_policy(path, matching())


@pytest.mark.parametrize("which", ["algorithm", "network", "partners"])
def test_code_that_only_the_files_of_a_policy_name_does_not_run(
    which: str, tmp_path: Path, code: Path
) -> None:
    name = f"{code}:{ {'algorithm': 'learner', 'network': 'Net', 'partners': 'act'}[which] }"
    path = store(tmp_path, **{which: name if which != "partners" else [[1, name]]})
    for load in (load_policy, find_policy):
        with pytest.raises(
            PolicyError,
            match=rf"last\.json names an? .* of your own, `.*{name[-8:]}`.*: --allow-code .*allow_code\('",
        ) as refused:
            load(path, matching())
        assert str(refused.value).count("theirs.py") == 3
    assert not ran(code)


def test_a_module_that_could_be_imported_is_not(
    tmp_path: Path, code: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(code.parent))
    for name in ("theirs:Net", "theirs:reward", "os:system"):
        with pytest.raises(PolicyError, match="of your own"):
            load_policy(store(tmp_path, network=name), matching())
    assert not ran(code)
    assert "theirs" not in sys.modules


def test_what_the_caller_names_runs(tmp_path: Path, code: Path) -> None:
    allow_code(f"{code}:act")
    policy = load_policy(store(tmp_path, partners=[[1, f"{code}:act"]]), matching())
    assert ran(code)
    assert policy.act(policy.start, jax.random.key(0), SEEN)[1][1] == 1  # type: ignore[union-attr]
    with pytest.raises(PolicyError, match="names a network of your own"):
        load_policy(store(tmp_path, network=f"{code}:Net"), matching())
    config = make_config(SMALL, network=f"{code}:Net")  # which names it
    parameters = jax.tree.map(
        lambda leaf: np.zeros(leaf.shape, leaf.dtype), parameter_shapes(matching(), config)
    )
    described = {
        "game": describe_game(matching()),
        "config": config.model_dump(mode="json"),
        "update": 3,
        "env_steps": 192,
        "seed": 0,
    }
    write_policy(tmp_path / "own.safetensors", parameters, described)
    load_policy(tmp_path / "own.safetensors", matching())


def test_names_of_code_have_a_form() -> None:
    for name in ("mine", "mine.py", "", ":act", "mine.py:"):
        with pytest.raises(ValueError, match=r"doesn't name code: it must be FILE\.py:NAME"):
            allow_code(name)
    assert command_line(["render", "coins", "--allow-code", "mine"]) == 2


@pytest.mark.parametrize(
    ("key", "name"),
    [
        ("network", "Net"),
        ("reward", "reward"),
        ("loss", "reward"),
        ("algorithm", "learner"),
        ("partners", "act"),
    ],
)
def test_resuming_runs_no_code_that_only_the_folder_names(
    key: str, name: str, tmp_path: Path, code: Path
) -> None:
    value: Any = f"{code}:{name}" if key != "partners" else [[1, f"{code}:{name}"]]
    config = {**make_config(SMALL).model_dump(mode="json"), key: value}
    manifest = {
        "game": describe_game(matching()),
        "config": config,
        "versions": versions(),
        "provenance": {},
        "status": "interrupted",
    }
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(
        RunError, match=r"manifest\.json names an? .* of your own, `.*: --allow-code"
    ):
        resume(matching(), tmp_path, "none")
    assert not ran(code)


def test_a_callback_that_only_the_folder_names_does_not_run(
    tmp_path: Path, code: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    manifest = {
        "game": {},
        "config": {},
        "versions": {},
        "provenance": {"game": "coins"},
        "asked": {"callback": f"{code}:told"},
    }
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    assert command_line(["train", "--resume", str(tmp_path)]) == 1
    assert "names a callback of your own" in capsys.readouterr().err
    assert not ran(code)


def test_partners_that_act_by_the_policy_itself_are_refused(tmp_path: Path) -> None:
    path = store(tmp_path)
    with pytest.raises(PolicyError, match="is its own partner"):
        load_policy(store(tmp_path, partners=[[1, str(path)]]), matching())


# damage


@lru_cache
def shapes(config: Config) -> Any:
    return parameter_shapes(matching(), config)


def read(path: Path) -> None:
    if read_policy(path, shapes)[0] is None:
        raise PolicyError("it does not fit")


def flips(content: bytes) -> Iterator[bytes]:
    """Yields the content with a bit of every third byte flipped."""
    for place in range(0, len(content), 3):
        yield content[:place] + bytes([content[place] ^ 1 << place % 8]) + content[place + 1 :]


def test_no_byte_of_the_description_can_change(tmp_path: Path) -> None:
    path = store(tmp_path)
    beside = path.with_suffix(".json")
    whole = beside.read_bytes()
    for damaged in (
        *flips(whole),
        b"",
        whole[:-1],
        whole + b" ",
        b"\xff" * 9,
        b"[" * 100_000,
        b"null",
    ):
        beside.write_bytes(damaged)
        with pytest.raises(
            PolicyError, match=r"last\.json is damaged: it isn't the one that was written"
        ):
            read(path)
    beside.write_bytes(b" " * 2**21)
    with pytest.raises(PolicyError, match="more than 1,048,576 bytes"):
        read(path)


TENSORS = r"last\.safetensors (cannot be read|is damaged: its tensors aren't those)|it has no digests|it does not fit|last\.json is damaged"


def test_no_byte_of_the_tensors_can_change(tmp_path: Path) -> None:
    path = store(tmp_path)
    whole = path.read_bytes()
    for damaged in flips(whole):
        path.write_bytes(damaged)
        with pytest.raises(PolicyError, match=TENSORS):
            read(path)


@pytest.mark.parametrize(
    ("metadata", "message"),
    [
        (None, "it has no digests"),
        ({DIGEST: ""}, r"last\.json is damaged"),
        ({DIGEST: "tensors"}, r"last\.json is damaged"),
    ],
)
def test_a_policy_without_digests_is_refused(
    tmp_path: Path, metadata: dict[str, str] | None, message: str
) -> None:
    path = store(tmp_path)
    save_file(load_file(path), path, metadata)
    with pytest.raises(PolicyError, match=message):
        read(path)


STRANGE = [
    None,
    True,
    5,
    -1,
    10**400,
    1e308,
    "x",
    "\udcff",
    [],
    {},
    [[]],
    {"a": 1},
    "random",
    ["a", 1],
    [[0, "random"]],
    [[9, "stay"]],
    [[1, 2]],
]


@pytest.mark.parametrize("part", ["", "game", pytest.param("config", marks=pytest.mark.thorough)])
def test_whatever_a_stranger_writes_is_a_message(part: str, tmp_path: Path) -> None:
    """Each part of the description is put in place of by values of other kinds, with digests that fit."""
    path = store(tmp_path)
    content = json.loads(path.with_suffix(".json").read_text())
    places = [(part, key) for key in content[part]] if part else [(), *((key,) for key in content)]
    for place in places:
        for value in STRANGE:
            changed: Any = json.loads(json.dumps(content))
            inner = changed
            for key in place[:-1]:
                inner = inner[key]
            if place:
                inner[place[-1]] = value
            rewrite(path, changed if place else value)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                with suppress(PolicyError):
                    read(path)
