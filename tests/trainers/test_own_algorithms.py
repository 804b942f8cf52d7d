"""One's own algorithms and losses, and the settings of one's own that hooks take by name."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import FAST_TO_COMPILE, QUICK, matching
from run_outcomes import assert_same_end, compiled_matching, read_lines, read_manifest
from run_outcomes import counting as learns_nothing

from sjdsl.cli import run as command_line
from sjdsl.trainers import (
    Batch,
    Config,
    ConfigError,
    Metrics,
    Played,
    RunError,
    Step,
    Train,
    TrainState,
    evaluate,
    find_policy,
    load_policy,
    load_preset,
    make_config,
    make_train,
    ppo_loss,
    resume,
    train,
)
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.runs import run
from sjdsl.trainers.runs.compiled import compile_train
from sjdsl.trainers.settings.own_settings import taken_settings

SMALL = {
    **QUICK,
    "num_envs": 4,
    "num_steps": 4,
    "num_epochs": 1,
    "total_timesteps": 16 * 4,
    "checkpoint_updates": 1,
    "policy_every": 1,
}


def as_it_is(env: Any, config: Any) -> Train:
    return make_train(env, config)


def counting(env: Any, config: Any, *, factor: float, start: int = 3) -> Train:
    """IPPO of rewards times a factor, which counts its updates from `start`."""
    base = make_train(env, config)

    def init(key: jax.Array) -> TrainState:
        return replace(base.init(key), own=jnp.int32(start))

    def learn(state: TrainState, played: Played) -> tuple[TrainState, Metrics]:
        rollout = replace(played.rollout, shaped_reward=factor * played.rollout.shaped_reward)
        state, metrics = base.learn(
            replace(state, own=state.own + 1), replace(played, rollout=rollout)
        )
        return state, metrics | {"counted": state.own, "each": jnp.arange(2.0)}

    return replace(base, init=init, learn=learn)


def penalised(
    parameters: Any, apply: Any, batch: Batch, config: Config, *, penalty: float = 0.0
) -> tuple[jax.Array, Metrics]:
    loss, metrics = ppo_loss(parameters, apply, batch, config)  # type: ignore[arg-type]
    return loss + penalty * metrics["kl"], metrics | {"paid": penalty * metrics["kl"]}


def weighed(step: Step, *, weight: float = 0.5) -> jax.Array:
    return weight * step.reward


class Wide(nn.Module):
    width: int
    times: int = 1

    @nn.compact
    def __call__(self, tokens: jax.Array) -> jax.Array:
        return nn.Dense(self.width * self.times)(
            tokens.reshape(len(tokens), -1).astype(jnp.float32)
        )


@pytest.fixture(scope="module", autouse=True)
def compiled_once() -> Iterator[None]:
    """Runs of one configuration share what is compiled."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "compile_train", lambda _, config, __: compiled_matching(config))
        yield


@pytest.fixture(scope="module")
def counted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    run_dir = tmp_path_factory.mktemp("runs") / "counted"
    train(matching(), make_config(SMALL, algorithm=counting, own={"factor": 2}), run_dir, "none")
    return run_dir


@pytest.mark.thorough
def test_what_changes_nothing_learns_as_the_bundled_one() -> None:
    """Bit for bit: an algorithm that is IPPO's, with a loss that is PPO's."""

    def learnt(config: Config) -> tuple[Any, Metrics]:
        program = make_train(matching(), config)
        state, metrics = jax.jit(program.update, compiler_options=FAST_TO_COMPILE)(
            program.init(jax.random.key(0))
        )
        return program.parameters(state), metrics

    bundled, own = (
        learnt(make_config(SMALL)),
        learnt(make_config(SMALL, algorithm=as_it_is, loss=penalised)),
    )
    assert own[1].pop("paid") == 0
    jax.tree.map(np.testing.assert_array_equal, own, bundled)


def test_a_run_of_ones_own_algorithm_is_an_ordinary_one(counted: Path, tmp_path: Path) -> None:
    """Its manifest, metrics and policies; stopped, it goes on to the same end, with what it keeps besides."""
    config = read_manifest(counted)["config"]
    assert (config["algorithm"], config["own"]) == (f"{__name__}:counting", {"factor": 2})
    rows = read_lines(counted / "metrics.jsonl")
    assert [row["counted"] for row in rows] == [4, 5, 6, 7]
    assert [rows[0][f"each_agent_{agent}"] for agent in (0, 1)] == [0.0, 1.0]
    asked = make_config(SMALL, algorithm=counting, own={"factor": 2})
    train(matching(), asked, tmp_path / "run", "none", callback=lambda update: update.number == 2)
    assert resume(matching(), tmp_path / "run", "none").updates == 4
    assert_same_end(tmp_path / "run", counted)
    assert evaluate(
        matching(), find_policy(counted, matching()), jax.random.key(0), 4
    ).returns.shape == (4, 2)


@pytest.mark.thorough
def test_a_run_starts_from_a_policy_with_an_algorithm_of_ones_own(counted: Path) -> None:
    config = make_config(SMALL, algorithm=counting, own={"factor": 1}, init_from=str(counted))
    program = make_train(matching(), config)
    started = program.init(jax.random.key(3))
    stored = load_policy(counted, matching())
    assert callable(stored)
    again = make_train(
        matching(), make_config(SMALL, init_from=str(counted))
    )  # of the same networks
    same = jax.tree.map(
        lambda a, b: bool((a == b).all()),
        program.parameters(started),
        again.parameters(again.init(jax.random.key(4))),
    )
    assert jax.tree.all(same)
    assert int(started.own) == 3
    with pytest.raises(ConfigError, match="can't start from a policy: its `Train` has no `adopt`"):
        make_train(
            matching(),
            make_config(
                SMALL,
                algorithm=lambda *given: replace(as_it_is(*given), adopt=None),
                init_from=str(counted),
            ),
        )


def test_settings_reach_the_hooks_that_take_them() -> None:
    own = {"factor": 1.0, "weight": 0.25, "times": 3, "penalty": 0.5}
    config = make_config(
        SMALL, algorithm=counting, reward=weighed, network=Wide, loss=penalised, own=own
    )
    assert dict(config.own) == own
    assert {
        name: default for name, default, _ in taken_settings(config.hooks) if name != "factor"
    } == {
        "start": 3,
        "weight": 0.5,
        "times": 1,
        "penalty": 0.0,
    }
    shapes = {leaf.shape for leaf in jax.tree.leaves(parameter_shapes(matching(), config))}
    assert (1, 1, 3 * 16) in shapes
    program = make_train(matching(), config)
    state, metrics = jax.jit(program.update, compiler_options=FAST_TO_COMPILE)(
        program.init(jax.random.key(0))
    )
    assert np.allclose(metrics["shaped_agent_return"], 0.25 * metrics["agent_return"])
    assert np.isclose(metrics["paid"], 0.5 * metrics["kl"]) and metrics["paid"] != 0
    assert jax.tree.all(
        jax.tree.map(lambda leaf: bool(jnp.isfinite(leaf).all()), program.parameters(state))
    )


@pytest.mark.parametrize(
    ("given", "read"),
    [
        ({"own": {"weight": 2}}, 2),
        ({"own.weight": "2.5e-1"}, 0.25),
        ({"own": {"weight": 1}, "own.weight": "true"}, True),
        ({"own": {"weight": "soft"}}, "soft"),
    ],
)
def test_settings_are_numbers_texts_and_truths(given: dict[str, Any], read: Any) -> None:
    config = make_config(given, reward=weighed)
    assert config.own == (("weight", read),) and type(config.own[0][1]) is type(read)
    assert json.loads(json.dumps(config.model_dump(mode="json")))["own"] == {"weight": read}
    assert make_config(config.model_dump(mode="json")) == make_config(config.record()) == config


@pytest.mark.parametrize(
    ("values", "said"),
    [
        (
            {"own.wieght": 1, "reward": weighed},
            "weighed` has no keyword-only argument of that name; did you mean `weight`?",
        ),
        (
            {"own.other": 1, "reward": weighed},
            "weighed` has no keyword-only argument of that name; the settings are weight",
        ),
        (
            {"algorithm": counting},
            "the algorithm `test_own_algorithms:counting` requires `own.factor`, which has no default: --set own.factor=",
        ),
        (
            {"own": {"weight": [1]}, "reward": weighed},
            "`own` must be a table of numbers, texts, true or false, by name, not {'weight': [1]}",
        ),
        ({"own": {"weight": float("nan")}, "reward": weighed}, "`own` must be a table of numbers"),
        ({"own": 3}, "`own` must be a table of numbers, texts, true or false, by name, not 3"),
        (
            {"algorithm": "vdn", "loss": penalised},
            "unknown key `loss` here: it is one of ippo and mappo",
        ),
        (
            {"algorithm": as_it_is, "critic": "state"},
            "`critic` has no effect while `algorithm` is test_own_algorithms:as_it_is",
        ),
        ({"algorithm": "dqn"}, "unknown algorithm 'dqn'; did you mean `vdn`?"),
        ({"algorithm": "vdn", "reward": weighed}, "`reward` must be 'common' with VDN"),
    ],
)
def test_what_cannot_be_is_said_at_once(values: dict[str, Any], said: str) -> None:
    """`tests/cli/refused.txt` has names that are not there."""
    with pytest.raises(ConfigError) as error:
        make_config(values)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("hooks", "said"),
    [
        (
            {"algorithm": lambda *given: given[1]},
            r"must return a sjdsl\.trainers\.Train that has a `policy`, not PPOConfig",
        ),
        (
            {"loss": lambda *_: jnp.ones(())},
            r"must return a number and a dict of numbers, its metrics, not \(\)",
        ),
        (
            {"loss": lambda *_: (jnp.ones(3), {})},
            r"must return a number and a dict of numbers, its metrics, not \(\(3,\), \{\}\)",
        ),
        (
            {
                "algorithm": lambda *given: replace(
                    as_it_is(*given), learn=lambda state, _: (state, {"loss": 0.0})
                )
            },
            "lack episodes, collective_return, agent_return; `mean_episode` has all but the loss",
        ),
    ],
)
def test_hooks_that_make_something_else_are_named(hooks: dict[str, Any], said: str) -> None:
    def traced(key: jax.Array) -> Any:
        program = make_train(matching(), make_config(SMALL, **hooks))
        return program.update(program.init(key))

    with pytest.raises(ConfigError, match=said):
        jax.eval_shape(traced, jax.random.key(0))


def test_presets_have_settings_of_ones_own(tmp_path: Path) -> None:
    """Those of a game come over those of all, what is asked for over both; what no hook takes is left out, and named."""
    path = tmp_path / "mine.toml"
    path.write_text(
        "[config.own]\nfactor = 1\nstart = 5\n[games.coins.config.own]\nfactor = 2\n[algorithm.ippo]\nnum_envs = 3\n"
    )
    of = {"algorithm": counting}
    assert dict(load_preset(path, of).config.own) == {"factor": 1, "start": 5}
    mine = load_preset(path, {**of, "own": {"start": 7}}, "coins")
    assert (dict(mine.config.own), mine.config.num_envs, mine.left_out) == (
        {"factor": 2, "start": 7},
        3,
        (),
    )
    assert load_preset(path).left_out == ("own.factor", "own.start")
    with pytest.raises(ConfigError, match=r"`own\.factor` does nothing"):
        load_preset(path, {"own.factor": "1"})


def test_a_manifest_with_a_setting_that_nothing_takes_is_refused(counted: Path) -> None:
    manifest = read_manifest(counted)
    manifest["config"]["own"]["facto"] = 1
    (counted.parent / "other").mkdir()
    (counted.parent / "other" / "manifest.json").write_text(json.dumps(manifest))
    with pytest.raises(
        RunError,
        match=r"`own\.facto` does nothing: the algorithm .* has no keyword-only argument of that name",
    ):
        resume(matching(), counted.parent / "other", "none")


FILE = """
from dataclasses import replace
from sjdsl.trainers import make_train, ppo_loss

def learner(env, config, *, bonus=1):
    return make_train(env, config)

def loss(parameters, apply, batch, config, *, weight=1.0):
    value, metrics = ppo_loss(parameters, apply, batch, config)
    return weight * value, metrics
"""


def test_the_commands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Names and settings on the command line; the keys; code that only the run names is allowed by name."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(FILE)
    hooks = [
        "--algorithm",
        "mine.py:learner",
        "--set",
        "loss=mine.py:loss",
        "--set",
        "own.weight=0.5",
    ]
    assert command_line(["train", "--keys", *hooks]) == 0
    said = capsys.readouterr().out
    here = tmp_path.resolve()
    assert (
        f"own.bonus = 1  # of the algorithm `{here}/mine.py:learner`\nown.weight = 0.5  # of the loss `{here}/mine.py:loss`\n"
        in said
    )
    assert command_line(["train", "coins", *hooks, "--set", "own.wight=1"]) == 1
    assert "did you mean `weight`?" in capsys.readouterr().err
    config = make_config(
        SMALL, algorithm="mine.py:learner", loss="mine.py:loss", own={"weight": 0.5}
    )
    monkeypatch.setattr(run, "compile_train", compile_train)
    monkeypatch.setattr(run, "make_train", lambda *_: learns_nothing())
    train(matching(), config, "run", "none", callback=lambda update: update.number == 1)
    manifest = json.loads(Path("run/manifest.json").read_text())
    assert manifest["config"]["own"] == {"weight": 0.5}
    assert list(manifest["own_files"]) == [f"{here}/mine.py"]
    Path("mine.py").write_text(FILE + "# changed\n")
    with pytest.raises(RunError, match=r"mine\.py has changed"):
        resume(matching(), "run", "none")
    stored = json.loads(Path("run/policies/last.json").read_text())
    assert stored["config"]["algorithm"] == f"{here}/mine.py:learner"
