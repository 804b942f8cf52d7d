"""Policies that are asked in words play whole episodes on the interpreter, asked as in use."""

from collections.abc import Iterator
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from sjdsl.compiler import ir
from sjdsl.compiler.lower import token_planes
from sjdsl.interpreter.observe import observe
from sjdsl.interpreter.step import action_mask, reset, step
from sjdsl.interpreter.threefry import Threefry
from sjdsl.models import HostPolicy, Message, Model, ModelError, Reply, Seats
from sjdsl.models.asking import Question, ask_policy
from sjdsl.models.notebook import edited
from sjdsl.models.policy import NoteEdit
from sjdsl.models.roles import wordings
from tests.told.corpus import game

FAKE = Model(name="fake", kind="fake")


def environment(g: ir.Game) -> SimpleNamespace:
    return SimpleNamespace(
        game=g,
        name=g.name,
        token_planes=token_planes(g),
        action_names=g.agents.actions,
        num_agents=g.agents.number,
        params=SimpleNamespace(),
    )


def play(g: ir.Game, policy: HostPolicy, steps: int = 50) -> Iterator[Question]:
    """Yields the questions to agent 0 of an episode, in which the others stay."""
    asked: list[Question] = []

    def ask(question: Question) -> Reply:
        asked.append(question)
        return ask_policy(question)

    world = reset(g, {}, Threefry(3, 0))
    over = np.zeros(1, bool)
    with Seats(environment(g), [{0: policy}], ask) as seats:
        for number in range(1, steps + 1):
            seen = np.stack(observe(g, world))[None]
            allowed = np.array(action_mask(g, world))[None]
            actions = seats.choose(seen, allowed, over)[0]
            assert (actions[1:] == -1).all()
            world, outcome = step(g, world, actions.tolist(), {}, Threefry(3, number))
            over = np.array([outcome.truncated or outcome.terminated])
            seats.learn(np.array([outcome.reward]), np.array([outcome.trial_ended]), over)
            yield from asked
            asked.clear()
            if over.all():
                return


def test_an_episode_with_a_fake_model() -> None:
    questions = list(play(game("two_trees"), FAKE))
    moves = [question for question in questions if question.kind == "move"]
    assert moves[-1].trial == 4
    assert len(moves) > 10
    for question in moves:
        assert question.message.text.startswith(f"TRIAL: {question.trial}, of 0 to 4\n")
        assert question.message.system == moves[0].message.system
    assert "YOUR MEAN REWARD SO FAR" in moves[-1].message.text


def test_after_each_trial_but_the_last_notes_are_revised() -> None:
    questions = list(play(game("two_trees"), FAKE))
    revised = [question for question in questions if question.kind == "notes"]
    assert [question.trial for question in revised] == [0, 1, 2, 3]
    assert "Rewrite your notes" in revised[0].message.text
    assert "WHAT YOU SEE NOW" not in revised[0].message.text
    after = questions[questions.index(revised[0]) + 1]
    assert "YOUR NOTES:\n1. by a hash\n\n" in after.message.text
    without = play(game("two_trees"), replace(FAKE, notebook=False))
    assert {question.kind for question in without} == {"move"}


def test_who_has_one_action_is_not_asked() -> None:
    class Asked(HostPolicy):
        def decide(self, agent: int, message: Message) -> Reply:
            raise AssertionError((agent, message))

    g = game("two_trees")
    seats = Seats(environment(g), [{0: Asked()}])
    world = reset(g, {}, Threefry(3, 0))
    seen = np.stack(observe(g, world))[None]
    allowed = np.zeros((1, g.agents.number, len(g.agents.actions)), bool)
    allowed[..., g.agents.actions.index("stay")] = True
    actions = seats.choose(seen, allowed, np.zeros(1, bool))
    seats.close()
    assert g.agents.actions[actions[0, 0]] == "stay"


def test_a_game_says_what_its_roles_are() -> None:
    g = game("two_trees")
    assert wordings("", g) == ("",)
    assert len(wordings("cooperator", g)) == 2
    about = (*g.about, ("player_cooperator", "Share."), ("player_guard", "Guard the trees."))
    own = g.model_copy(update={"about": about})
    assert wordings("cooperator", own) == ("Share.",)
    assert wordings("guard", own) == ("Guard the trees.",)
    with pytest.raises(ModelError, match='about player_guard "…"'):
        wordings("guard", g)
    first = next(play(own, FAKE.as_role("guard"), 1))
    assert "\nGuard the trees.\n" in first.message.system


def test_a_game_without_stay_cannot_be_played() -> None:
    env = environment(game("two_trees"))
    env.action_names = ("forward",)
    with pytest.raises(ModelError, match="have the action `stay`"):
        Seats(env, [{}])


@pytest.mark.parametrize(
    ("edit", "notes", "problem"),
    [
        (NoteEdit("add", text="c"), ("a", "b", "c"), ""),
        (NoteEdit("replace", 1, "c"), ("c", "b"), ""),
        (NoteEdit("delete", 2), ("a",), ""),
        (NoteEdit("delete", 3), ("a", "b"), "there is no note 3 to delete"),
    ],
)
def test_notes_are_edited(edit: NoteEdit, notes: tuple[str, ...], problem: str) -> None:
    assert edited(("a", "b"), edit) == (notes, problem)


def test_the_oldest_note_is_dropped() -> None:
    notes = tuple(map(str, range(40)))
    assert edited(notes, NoteEdit("add", text="new"))[0] == (*notes[1:], "new")
