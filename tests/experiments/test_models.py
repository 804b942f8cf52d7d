"""Line-ups with models: the loop on the host plays what the compiled one plays, calls are recorded,
resumed and limited, and results say what they rest on."""

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import jax
import numpy as np
import pytest
from small_games import MATRIX, matrix_game, public_goods
from stored_policies import store

import sjdsl
from sjdsl.experiments import cross_play, schelling_diagram, stacks
from sjdsl.experiments.lineups import play_key, rotated_orders
from sjdsl.experiments.summaries import crossplay_text, diagram_text
from sjdsl.experiments.usage import forecasts
from sjdsl.models import HostPolicy, LimitReached, Limits, Message, Model, ModelError, Reply, talks
from sjdsl.models.account import most_tokens
from sjdsl.models.asking import ask_policy
from sjdsl.models.files import Price
from sjdsl.models.hosted import hosted_policy
from sjdsl.models.policy import Answer
from sjdsl.replay import play_asked_episodes, play_episodes
from sjdsl.trainers import PolicyError, evaluate, find_policy, make_config, make_train
from sjdsl.trainers.policies import evaluation
from sjdsl.trainers.policies.evaluation import make_host_evaluator
from tests.models.folders import timeless
from tests.trainers.probes import recalled

FAKE = Model(name="fake", kind="fake", price=Price(1, 10))


class Says(HostPolicy):
    """Answers by a function of the agent and its message."""

    def __init__(self, reply: Callable[[int, Message], Reply], name: str = "says") -> None:
        self.reply = reply
        self.name = name

    def decide(self, agent: int, message: Message) -> Reply:
        return self.reply(agent, message)


class Nobody:
    """Leaves all agents to the policy; keeps what it was shown."""

    def __init__(self) -> None:
        self.seen: list[np.ndarray] = []

    def choose(self, observation: Any, allowed: Any, over: Any) -> np.ndarray:
        del allowed, over
        self.seen.append(observation)
        return np.full(observation.shape[:2], -1, np.int32)

    def learn(self, reward: Any, trial_ended: Any, over: Any) -> None:
        pass


@pytest.mark.parametrize("make", [recalled, partial(public_goods, 4)])
def test_both_loops_play_the_same(
    make: Callable[[], Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A line-up of networks, with memory and without, and of random agents: step by step the same
    states, rewards, actions and keys, and the same results, bit by bit."""
    env = make()
    names = [str(store(tmp_path / "a", env, 1, memory="gru")), str(store(tmp_path / "b", env, 2))]
    lineup = [*names, *["random"] * (env.num_agents - 2)]
    steps: list[Any] = []
    advance = evaluation._advance

    def noted(*arguments: Any) -> Any:
        after, step = advance(*arguments)
        jax.debug.callback(
            lambda *of_step: steps.append(of_step), after.state, after.over, step, ordered=True
        )
        return after, step

    monkeypatch.setattr(evaluation, "_advance", noted)

    def played() -> tuple[Any, list[Any]]:
        """Returns the results of a cross-play, and its steps."""
        steps.clear()
        results = cross_play(env, slots=lineup, episodes=5, seed=3, rotate=True)
        jax.effects_barrier()
        return vars(results.parts[0].played), list(steps)

    compiled = played()
    nobody = Nobody()
    tapes = []

    def on_host(*arguments: Any) -> Any:
        play = make_host_evaluator(*arguments)

        def play_and_keep(key: Any, parameters: Any) -> Any:
            results, tape = play(key, parameters, nobody)
            tapes.append(tape)
            return results

        return play_and_keep

    monkeypatch.setattr(stacks, "make_evaluator", on_host)
    hosted = played()
    assert len(nobody.seen) == len(compiled[1]) == compiled[0]["lengths"].max()
    jax.tree.map(np.testing.assert_array_equal, compiled, hosted)
    actions = [step[2] for _, _, step in compiled[1]]
    np.testing.assert_array_equal(tapes[0].actions, actions)
    assert len(np.unique(actions)) > 1


def test_a_host_policy_acts_where_it_sits() -> None:
    """It stays, the others betray: the returns are those of the matrix, whoever has which slot."""
    env = matrix_game()
    stays = Says(lambda _, message: Reply("stay", why=message.text))
    betrays = Says(lambda *_: Reply("betray"))
    played = cross_play(env, slots=[stays, betrays], episodes=3)
    assert played.parts[0].played.returns.tolist() == [[0, 20]] * 3
    mixed = cross_play(env, policies=[stays, "random", betrays], episodes=4)
    for part in mixed.parts:
        if part.lineup == (0, 2):
            assert part.returns.tolist() == [[0, 20]] * 4
            assert {tuple(order) for order in part.order.tolist()} <= {(0, 1), (1, 0)}


def test_who_is_not_asked_acts_as_it_would_beside_anybody() -> None:
    """A seat of a model changes nothing but that seat: `random` draws the same actions."""
    env = matrix_game()
    asked = cross_play(env, slots=[Says(lambda *_: Reply("betray")), "random"], episodes=20)
    beside = cross_play(env, slots=[lambda _, seen: np.ones(len(seen), int), "random"], episodes=20)
    assert (asked.parts[0].returns == beside.parts[0].returns).all()
    assert len(set(asked.parts[0].returns[:, 0])) > 2


def test_a_model_knows_its_own_past_alone() -> None:
    messages: list[tuple[int, str]] = []

    def reply(agent: int, message: Message) -> Reply:
        messages.append((agent, message.text))
        return Reply("betray" if agent else "stay", note=None)

    cross_play(matrix_game(), slots=[Says(reply), Says(reply, "other")], episodes=1)
    last = dict(messages)
    assert "YOUR LAST REWARD: 0\n" in last[0]
    assert "YOUR LAST REWARD: 5\n" in last[1]
    assert "3 ago: betray, reward 5" in last[1]
    assert "betray: 5 (3x)" in last[1]
    assert "betray, reward" not in last[0]
    assert len(messages) == 8


def test_notes_and_problems_are_told_in_the_next_message() -> None:
    texts: list[str] = []
    edits = iter(
        [
            Reply("stay", note=sjdsl.models.NoteEdit("add", text="it pays")),
            Reply("nonsense", note=sjdsl.models.NoteEdit("delete", 7)),
            Reply("stay", note=sjdsl.models.NoteEdit("replace", 1, "x" * 300)),
            Reply("stay"),
        ]
    )

    def reply(agent: int, message: Message) -> Reply:
        del agent
        texts.append(message.text)
        return next(edits)

    cross_play(matrix_game(), slots=[Says(reply), "stay"], episodes=1)
    assert "YOUR NOTES:\n1. it pays\n" in texts[1]
    assert "1 ago: stay, reward 3; nonsense was not allowed" in texts[2]
    assert f"YOUR NOTES:\n1. {'x' * 200}\n" in texts[3]


def test_notebook_and_ledger_can_be_off() -> None:
    texts: list[Message] = []

    def reply(agent: int, message: Message) -> Reply:
        del agent
        texts.append(message)
        return Reply("stay", note=sjdsl.models.NoteEdit("add", text="it pays"))

    plain = Says(reply)
    plain.notebook = plain.ledger = False
    plain.history = 1
    cross_play(matrix_game(), slots=[plain, "stay"], episodes=1)
    assert "keep no notes" in texts[-1].system
    assert '"note"' not in texts[-1].system
    for absent in ("YOUR NOTES", "YOUR MEAN REWARD", "2 ago"):
        assert absent not in texts[-1].text


def test_roles_come_in_two_wordings() -> None:
    systems: set[str] = set()

    def reply(agent: int, message: Message) -> Reply:
        del agent
        systems.add(message.system)
        return Reply("stay")

    asked = Says(reply)
    asked.role = "defector"
    cross_play(matrix_game(), slots=[asked, "stay"], episodes=4)
    assert len(systems) == 2
    with pytest.raises(
        ModelError, match=r"there is no role `defecter`, .*; did you mean `defector`"
    ):
        cross_play(matrix_game(), slots=[FAKE.as_role("defecter"), "stay"], episodes=1)


def diagram(folder: Path | None = None, limits: Limits | None = None) -> Any:
    cooperators, defectors = FAKE.as_role("cooperator"), FAKE.as_role("defector")
    env = matrix_game()
    return schelling_diagram(env, cooperators, defectors, episodes=3, folder=folder, limits=limits)


def test_it_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Stopped at twenty points, with torn last lines, it ends as if it had not been; and nobody is
    asked twice."""
    asked: list[object] = []

    def counted(question: Any) -> Reply:
        asked.append((question.episode, question.agent, question.step, question.message))
        return ask_policy(question)

    monkeypatch.setattr(talks, "ask_policy", counted)
    whole = diagram(tmp_path / "whole")
    calls = len(asked)
    assert calls == 3 * 3 * 2 * 4  # line-ups, episodes, agents, steps
    asked.clear()
    for most in range(3, calls, 4):
        with pytest.raises(LimitReached, match=f"at most {most} may be"):
            diagram(tmp_path / "cut", Limits(parallel=1 + most % 3, calls=most))
        assert len(asked) == most
        files = sorted((tmp_path / "cut").rglob("*.jsonl"))
        with files[most % len(files)].open("a") as file:
            file.write('{"step": 3, "tri')
    resumed = diagram(tmp_path / "cut")
    assert len(asked) == calls
    assert timeless(tmp_path / "cut") == timeless(tmp_path / "whole")
    assert (resumed.returns.everybody == whole.returns.everybody).all()


def test_a_changed_request_is_refused(tmp_path: Path) -> None:
    with pytest.raises(LimitReached):
        diagram(tmp_path, Limits(calls=9))
    path = next(path for path in sorted(tmp_path.rglob("*.jsonl")) if path.stat().st_size)
    first, *rest = path.read_text().splitlines()
    talk = json.loads(first)
    talk["request"] = "0" * 32
    talk["lines"] = talk["lines"][:4] + "0000" + talk["lines"][8:]
    path.write_text("\n".join([json.dumps(talk), *rest]) + "\n")
    with pytest.raises(ModelError, match=r"step 0 of .* line 2 differs, now `"):
        diagram(tmp_path)


def test_a_budget_is_kept_before_it_is_passed(tmp_path: Path) -> None:
    whole = diagram(tmp_path / "whole")
    dollars = sum(used.dollars for used in whole.usage.values())
    budget = dollars / 2 + 4000 * 10 / 10**6  # the most that one call can cost is held back
    with pytest.raises(LimitReached, match="might pass the budget"):
        diagram(tmp_path / "cut", Limits(budget=budget, parallel=1))
    rows = json.loads((tmp_path / "cut" / "talks" / "usage.json").read_text())
    spent = sum(row["dollars"] for row in rows)
    assert dollars / 4 < spent < budget
    priceless = Model(name="m", url="http://localhost/v1", model="m")
    with pytest.raises(ModelError, match="--budget needs the `price` of m"):
        cross_play(matrix_game(), slots=[priceless, "stay"], limits=Limits(budget=1))


def test_the_most_tokens_of_a_message_count_other_alphabets_by_the_byte() -> None:
    assert most_tokens(Message("four", "more", (), ())) == 4
    assert most_tokens(Message("", "\N{HERB}a b", (), ())) == 4 + 1


def test_a_forecast_is_what_happens() -> None:
    played = diagram()
    of_models = forecasts(played.experiment)
    for name, used in played.usage.items():
        forecast = of_models[name]
        assert used.calls == forecast.calls
        assert 0.5 < forecast.calls * forecast.input / used.input < 2
    text = diagram_text(played)
    assert "not over models or prompts" in text
    assert "fake+cooperator: 36 calls, 0 of them" in text


def test_there_is_no_verdict_on_replies_that_cannot_be_used() -> None:
    """One of 18 and more: 5.6 %. With one of 24 there is a verdict."""

    def sometimes(every: int) -> Says:
        count = iter(range(10**6))
        return Says(
            lambda *_: Reply("stay", is_valid=next(count) % every != 0, problem="no JSON"), "often"
        )

    env = matrix_game()
    for every, is_judged in ((18, False), (24, True)):
        judged = schelling_diagram(
            env, sometimes(every), lambda _, seen: np.ones(len(seen), int), episodes=6
        )
        assert (judged.verdict.outcome != "undecided") == is_judged
        text = diagram_text(judged)
        assert ("of the replies of often could not be used" in text) != is_judged


def test_many_unusable_replies_stop_it() -> None:
    unusable = Says(lambda *_: Reply("stay", is_valid=False, problem="no JSON"))
    with pytest.raises(ModelError, match="20 replies in a row could not be used"):
        cross_play(matrix_game(), slots=[unusable, "stay"], episodes=6)


def test_another_model_behind_a_name_is_refused() -> None:
    names = iter(["luna-1"] * 5 + ["luna-2"] * 100)
    swapped = Says(lambda *_: Reply("stay", answer=Answer("", model=next(names))))
    with pytest.raises(ModelError, match="its model is `luna-2`, and earlier replies are of"):
        cross_play(matrix_game(), slots=[swapped, "stay"], episodes=6)


def test_an_arena_rotates() -> None:
    assert rotated_orders(3, 3).tolist() == [[0, 1, 2], [2, 0, 1], [1, 2, 0]]
    env = public_goods(3, ranked=1.0)
    asked: list[int] = []

    def reply(agent: int, message: Message) -> Reply:
        del message
        asked.append(agent)
        return Reply("keep")

    played = cross_play(env, slots=[Says(reply), "stay", "stay"], rotate=True, episodes=3)
    # Slot i of episode e plays policy (i + e) mod 3: policy 0 has slot -e mod 3.
    assert sorted(asked) == [0, 0, 1, 1, 2, 2]
    assert played.parts[0].order[:, 0].tolist() == [0, 2, 1]
    assert "rotated" in played.experiment.describe()
    with pytest.raises(sjdsl.experiments.ExperimentError, match="rotate goes with slots"):
        cross_play(env, policies=["stay"], rotate=True)
    assert "return of an agent" in crossplay_text(played)


def test_recorded_episodes_are_those_of_their_seeds() -> None:
    """If nobody is asked, they are what the compiled loop records."""
    env = matrix_game()
    drawn = find_policy("random", env)
    asked = play_asked_episodes(env, lambda _: hosted_policy(env, {}, drawn), seed=5, episodes=3)
    for one, other in zip(asked, play_episodes(env, drawn, 5, 3), strict=True):
        jax.tree.map(np.testing.assert_array_equal, vars(one), vars(other))


def test_a_model_cannot_be_a_partner_in_training(tmp_path: Path) -> None:
    file = tmp_path / "models.toml"
    file.write_text('[fake]\nkind = "fake"\n')
    env = sjdsl.make(MATRIX)
    config = make_config(partners={1: f"{file}:fake"})
    with pytest.raises(PolicyError, match="neither as a partner in training"):
        make_train(env, config)
    with pytest.raises(PolicyError, match="outside of compiled code"):
        evaluate(env, find_policy(f"{file}:fake", env), play_key(0, 0))
