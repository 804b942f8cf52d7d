"""What users bring along: networks, rewards, callbacks, policies to start from, partners that do not learn."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import pytest
from probes import QUICK, matching, quick, stream
from run_outcomes import (
    SHORT,
    assert_same_end,
    compiled_matching,
    compiled_once,
    counting,
    outcome,
    read_lines,
    read_manifest,
)
from safetensors.numpy import load_file

from sjdsl.runtime.policy import UNTRAINED
from sjdsl.trainers import (
    ConfigError,
    MemoryPolicy,
    PolicyError,
    RunError,
    Step,
    Update,
    allow_code,
    evaluate,
    find_policy,
    make_config,
    make_train,
    mixed_policy,
    random_policy,
    register,
    resume,
    train,
)
from sjdsl.trainers.algorithms.partners import Partners
from sjdsl.trainers.policies.loading import parameter_shapes
from sjdsl.trainers.runs import run
from sjdsl.trainers.settings.policy_names import UNTRAINED as NEED_NO_FILE

SMALL = {
    **QUICK,
    "num_envs": 4,
    "num_steps": 4,
    "num_epochs": 1,
    "total_timesteps": 16 * 3,
    "checkpoint_updates": 1,
    "policy_every": 1,
}


class Mine(nn.Module):
    """One dense layer on what is seen, as numbers."""

    width: int

    @nn.compact
    def __call__(self, tokens: jax.Array) -> jax.Array:
        return nn.relu(
            nn.Dense(self.width, name="mine")(tokens.reshape(len(tokens), -1).astype(jnp.float32))
        )


def one_for_the_second(step: Step) -> jax.Array:
    return 0.5 * step.reward + step.events["second_action"]


def always_second(key: jax.Array, observation: jax.Array) -> jax.Array:
    del key
    return jnp.ones(len(observation), jnp.int32)


@pytest.fixture(scope="module")
def brought(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Update]]:
    """A run of agent 0 beside a partner, with all that can be brought along, and what its callback was told."""
    told: list[Update] = []
    config = make_config(
        SMALL,
        network=Mine,
        reward=one_for_the_second,
        partners={1: always_second},
        sharing="per_agent",
    )
    run_dir = tmp_path_factory.mktemp("runs") / "brought"
    train(matching(), config, run_dir, "none", callback=told.append)
    return run_dir, told


def test_the_manifest_names_what_was_brought(brought: tuple[Path, list[Update]]) -> None:
    config = read_manifest(brought[0])["config"]
    here = __name__
    assert (config["network"], config["reward"]) == (f"{here}:Mine", f"{here}:one_for_the_second")
    assert config["partners"] == [[1, f"{here}:always_second"]]
    again = make_config(config)
    assert again.model_dump(mode="json") == config
    assert hash(again) == hash(make_config(config))


def test_a_network_of_ones_own_is_what_learns(brought: tuple[Path, list[Update]]) -> None:
    config = make_config(read_manifest(brought[0])["config"])
    names = {
        jax.tree_util.keystr(place): leaf.shape
        for place, leaf in jax.tree_util.tree_leaves_with_path(parameter_shapes(matching(), config))
    }
    own = {name: shape for name, shape in names.items() if "mine" in name}
    assert list(own.values()) == [(1, 16), (1, 1, 16)], (
        "of one agent, the one that learns; as wide as network_width"
    )
    assert not any("Dense" in name for name in names if "torso" in name)


def test_a_reward_of_ones_own_is_learnt_from(brought: tuple[Path, list[Update]]) -> None:
    for row in read_lines(brought[0] / "metrics.jsonl"):
        for agent in (0, 1):
            wanted = 0.5 * row[f"return_agent_{agent}"] + row[f"event_second_action_agent_{agent}"]
            assert row[f"shaped_return_agent_{agent}"] == pytest.approx(wanted, abs=1e-6)


def test_partners_act_by_their_policy(brought: tuple[Path, list[Update]]) -> None:
    """While the run learns, and when its policy is played; the other agent draws its actions."""
    rows = read_lines(brought[0] / "metrics.jsonl")
    assert [row["event_second_action_agent_1"] for row in rows] == [1.0] * 3
    assert 0 < np.mean([row["event_second_action_agent_0"] for row in rows]) < 1
    for policy in (find_policy(brought[0], matching()), brought[1][-1].policy):
        counts = evaluate(matching(), policy, jax.random.key(0), 64).events["second_action"]
        assert (counts[:, 1] == 1).all()
        assert 0 < counts[:, 0].mean() < 1


def test_a_callback_is_told_after_each_update(brought: tuple[Path, list[Update]]) -> None:
    run_dir, told = brought
    rows = read_lines(run_dir / "metrics.jsonl")
    assert [(update.number, update.env_steps, update.run_dir) for update in told] == [
        (n, 16 * n, run_dir) for n in (1, 2, 3)
    ]
    assert [update.row["loss"] for update in told] == [row["loss"] for row in rows]
    assert all(update.rows[0]["loss"] == update.row["loss"] for update in told)


def test_the_value_of_a_team_is_that_of_those_who_learn() -> None:
    """By hand: Q is 1 for every action before, 2 after; one of two agents learns, so y = 3 + 0.5 * 2 and the error 3."""
    from sjdsl.trainers.algorithms.vdn_targets import Team, Transition, bootstrapped, team_loss
    from sjdsl.trainers.networks.teams import learning_agents

    class Network:
        @staticmethod
        def apply(parameters: float, observation: jax.Array) -> jax.Array:
            return jnp.full((*observation.shape[:2], 2), parameters) + observation[..., :1]

    seen = jnp.zeros((4, 2, 1))
    batch = Transition(
        seen, jnp.zeros((4, 2), jnp.int32), jnp.full(4, 3.0), seen + 1.0, jnp.zeros(4, bool)
    )
    config = quick(algorithm="vdn", partners={1: "random"}, gamma=0.5)
    team = Team(Network, jnp.asarray(learning_agents(2, config)))  # type: ignore[arg-type]
    steps = bootstrapped(1.0, 1.0, batch, team, config)  # type: ignore[arg-type]
    loss, parts = team_loss(1.0, team, steps, weight=1.0)
    assert (float(loss), float(parts["team_value"])) == (9.0, 1.0)


def test_partners_that_cannot_be_are_refused() -> None:
    """An action that the game lacks; `tests/cli/refused.txt` has the others."""
    with pytest.raises(
        PolicyError, match="matching has no action `stay`; its actions are action_0, action_1"
    ):
        make_train(matching(), make_config(SMALL, partners={1: "stay"}))


def test_a_partners_memory_begins_anew_with_each_episode() -> None:
    """Its action is how many steps it remembers; the others' actions stay theirs."""
    counting_steps = MemoryPolicy(
        jnp.int32(0),
        lambda memory, _, observation: (memory + 1, jnp.full(len(observation), memory)),
    )
    partners = Partners((1,), mixed_policy(2, [((1,), counting_steps)]))
    memory, taken = partners.policy.starts(3), []
    observation = jnp.zeros((3, 2, 1, 1, 1), jnp.uint8)
    for number, fresh in enumerate(
        ([True, True, True], [False, True, False], [False, False, False])
    ):
        memory, actions = partners.act(
            matching(),
            memory,
            jax.random.key(number),
            observation,
            jnp.zeros(3),
            jnp.array(fresh),
            jnp.full((3, 2), 7),
        )
        taken.append(actions.tolist())
    assert taken == [[[7, 0]] * 3, [[7, 1], [7, 0], [7, 1]], [[7, 2], [7, 1], [7, 2]]]


# rewards and networks that do not fit


def test_a_reward_must_be_one_for_each_agent() -> None:
    program = make_train(matching(), make_config(SMALL, reward=lambda step: step.reward.sum()))
    state = jax.eval_shape(program.init, jax.random.key(0))
    with pytest.raises(
        ConfigError,
        match=r"must give a number for each of the 2 agents, an array of shape \(2,\), not \(\)",
    ):
        jax.eval_shape(program.collect, state)


def test_a_network_must_make_features() -> None:
    register(
        "network",
        "flat",
        lambda: lambda_module(lambda tokens: tokens.reshape(-1).astype(jnp.float32)),
    )
    with pytest.raises(
        ConfigError, match=r"`flat` must return features \[M, K\] for tokens .*; it returned \(2,\)"
    ):
        parameter_shapes(matching(), make_config(SMALL, network="flat"))


def lambda_module(function: Any) -> nn.Module:
    class Plain(nn.Module):
        def __call__(self, tokens: jax.Array) -> jax.Array:
            return function(tokens)

    return Plain()


def test_a_reward_sees_where_its_action_led() -> None:
    """Also in the last step of an episode, after which the environment returns the first state of the next."""

    def steps_forward(step: Step) -> jax.Array:
        return jnp.full(2, step.next_state.step - step.state.step)

    config = make_config(SMALL, num_steps=6, reward=steps_forward)
    program = make_train(stream("truncated"), config)
    play = jax.jit(lambda key: program.collect(program.init(key))[1])
    played = play(jax.random.key(0))
    assert (played.rollout.shaped_reward == 1).all()


# the names of policies


def test_a_policy_is_found_by_its_name(brought: tuple[Path, list[Update]], tmp_path: Path) -> None:
    run_dir, env = brought[0], matching()
    observation = env.observe(env.reset(jax.random.key(0))[1])
    for name in ("", "@best", "@last", "@2", "/policies/last.safetensors"):
        policy = find_policy(f"{run_dir}{name}", env)
        assert policy.act(policy.start, jax.random.key(1), observation)[1].shape == (2,)
    assert find_policy(always_second, env) is always_second
    assert (
        find_policy("random", env)(jax.random.key(0), observation).tolist()
        == random_policy(env)(jax.random.key(0), observation).tolist()
    )
    (tmp_path / "bots.py").write_text(
        "import jax.numpy as jnp\ndef zero(key, observation):\n    return jnp.zeros(2, jnp.int32)\n"
    )
    assert find_policy(f"{tmp_path}/bots.py:zero", env)(
        jax.random.key(0), observation
    ).tolist() == [0, 0]
    with pytest.raises(PolicyError, match="has no policy of update 9, but of 1, 2, 3"):
        find_policy(f"{run_dir}@9", env)
    with pytest.raises(PolicyError, match=r"bots\.py has no `one`"):
        find_policy(f"{tmp_path}/bots.py:one", env)
    assert tuple(UNTRAINED) == NEED_NO_FILE, "what commands take for a name before JAX is imported"
    staying: Any = SimpleNamespace(action_names=("go", "stay"), num_agents=2)
    assert find_policy("stay", staying)(jax.random.key(0), observation).tolist() == [1, 1]


# a start from a policy


@pytest.mark.thorough
def test_a_run_starts_from_a_policy_and_keeps_a_copy(
    brought: tuple[Path, list[Update]], tmp_path: Path
) -> None:
    source = shutil.copytree(brought[0], tmp_path / "source")
    alike = read_manifest(source)["config"]
    config = make_config(alike | {"init_from": f"{source}@2", "reward": "individual"})
    program = make_train(matching(), config)
    started = jax.tree.leaves(program.parameters(program.init(jax.random.key(3))))
    stored = load_file(source / "policies" / "00000002.safetensors")
    assert sorted(leaf.tobytes() for leaf in map(np.asarray, started)) == sorted(
        tensor.tobytes() for tensor in stored.values()
    )
    with pytest.raises(
        ConfigError,
        match=r"can't start from .*last\.safetensors, whose networks differ: .*network_width = 16 there and 8 here",
    ):
        make_train(matching(), make_config(alike | {"init_from": str(source), "network_width": 8}))
    scaled = make_train(
        matching(), make_config(alike | {"init_from": str(source), "normalise_values": True})
    )
    assert "deviation" in scaled.parameters(scaled.init(jax.random.key(3)))["params"]["critic"], (
        "a critic without a scale gets one"
    )
    with pytest.raises(PolicyError, match="random is not the folder of a training run"):
        make_train(matching(), make_config(alike | {"init_from": "random"}))

    run_dir = tmp_path / "run"
    with pytest.raises(ZeroDivisionError):
        train(matching(), config, run_dir, "none", callback=lambda update: 1 // (2 - update.number))
    assert (run_dir / "checkpoints" / "2.safetensors").is_file(), (
        "a callback that fails costs nothing of the run"
    )
    shutil.rmtree(source)
    assert resume(matching(), run_dir, "none").updates == 3


# longer, and ended by a callback


@pytest.mark.thorough
def test_a_finished_run_made_longer_is_one_that_was_as_long(tmp_path: Path) -> None:
    """Without annealing, bit for bit; the description of a policy says which run it was stored in."""
    constant = SHORT.model_copy(update={"anneal_learning_rate": False, "keep_policies": 2})
    with compiled_once(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "compile_train", lambda *_: compiled_matching(constant))
        train(matching(), constant, tmp_path / "whole", "none")
        train(
            matching(),
            constant.model_copy(update={"total_timesteps": 64 * 6}),
            tmp_path / "run",
            "none",
        )
        with pytest.raises(
            RunError,
            match=r"a run of 384 steps that has done 384; a run can only be made longer: .*not 128",
        ):
            resume(matching(), tmp_path / "run", "none", total_timesteps=128)
        result = resume(matching(), tmp_path / "run", "none", total_timesteps=64 * 12)
    assert result.updates == 12
    manifest = read_manifest(tmp_path / "run")
    assert (manifest["status"], manifest["config"]["total_timesteps"]) == ("finished", 768)
    assert manifest["extended"] == [{"from": 384, "to": 768, "updates": 6}]
    best = tmp_path / "run" / "policies" / "best.json"
    best.write_bytes((tmp_path / "whole" / "policies" / "best.json").read_bytes())
    assert_same_end(tmp_path / "run", tmp_path / "whole")


def test_a_callback_may_end_a_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    config = SHORT.model_copy(update={"evaluate_every": 0, "checkpoint_updates": 0})
    result = train(
        matching(), config, tmp_path / "run", "none", callback=lambda update: update.number == 5
    )
    assert result.updates == 5
    assert read_manifest(tmp_path / "run")["status"] == "stopped by its callback after update 5"
    assert json.loads((tmp_path / "run" / "policies" / "last.json").read_text())["update"] == 5
    assert resume(matching(), tmp_path / "run", "none").updates == 12
    assert read_manifest(tmp_path / "run")["status"] == "finished"
    assert [row["update"] for row in outcome(tmp_path / "run")["metrics"]] == list(range(1, 13))


def test_a_run_does_not_go_on_with_a_file_that_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run, "make_train", lambda *_: counting())
    file = tmp_path / "mine.py"
    file.write_text("def paid(step):\n    return step.reward\n")
    allow_code(f"{file}:paid")
    config = SHORT.model_copy(update={"evaluate_every": 0, "reward": f"{file}:paid"})
    train(matching(), config, tmp_path / "run", "none", callback=lambda update: update.number == 2)
    text = file.read_text()
    file.write_text(text.replace("reward", "reward + 1"))
    with pytest.raises(
        RunError, match=r"mine\.py has changed since .*run was started: restore the file"
    ):
        resume(matching(), tmp_path / "run", "none")
    file.write_text(text)
    assert resume(matching(), tmp_path / "run", "none").updates == 12
