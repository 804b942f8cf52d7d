"""Replies of language models: what is read, and what counts as `stay`."""

import json

import pytest

from sjdsl.models import FakeProvider, LanguagePolicy, Message, NoteEdit, Reply, read_reply

ASKED = Message("rules", "now", ("stay", "forward", "zap"), ("stay", "forward"))


def reply(**fields: object) -> Reply:
    return read_reply(json.dumps(fields), ASKED)


def test_a_reply_is_read() -> None:
    note = {"op": "replace", "id": 2, "text": "red pays"}
    read = reply(why="w" * 600, goal="g" * 200, note=note, action="forward")
    assert read == Reply("forward", "w" * 500, "g" * 120, NoteEdit("replace", 2, "red pays"))


def test_a_fence_around_it_is_no_harm() -> None:
    assert read_reply('```json\n{"action": "forward"}\n```', ASKED).action == "forward"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("I go forward", "your reply was not a JSON object"),
        ('["forward"]', "your reply was not a JSON object"),
        ("[" * 100_000, "your reply was not a JSON object"),
        ("1" * 5000, "your reply was not a JSON object"),
        (f'{{"action": "{"z" * 5000}"}}', f"there is no action '{'z' * 40}'"),
        ('{"action": 1}', 'your reply had no "action" with the name of an action'),
        ('{"action": "zap"}', "zap was not allowed"),
        ('{"action": "forwards"}', "there is no action 'forwards'; did you mean `forward`?"),
    ],
)
def test_what_cannot_be_used_is_stay(text: str, problem: str) -> None:
    read = read_reply(text, ASKED)
    assert (read.action, read.problem, read.is_valid) == ("stay", problem, False)


@pytest.mark.parametrize(
    ("note", "problem"),
    [
        ({"op": "append"}, 'your note\'s "op" was not one of add, replace, delete'),
        ({"op": "delete", "id": True}, 'your note to delete had no "id"'),
        ({"op": "add", "text": 3}, 'your note to add had no "text"'),
        ({"op": "none"}, ""),
        ("a note", "your note was not an object"),
        (None, ""),
    ],
)
def test_a_wrong_note_leaves_the_action(note: object, problem: str) -> None:
    read = reply(note=note, action="forward")
    assert read == Reply("forward", problem=problem)


def test_the_fake_one_depends_on_what_it_is_told_alone() -> None:
    policy = LanguagePolicy(FakeProvider())
    chosen = []
    for number in range(200):
        message = Message("rules", f"step {number}", ASKED.actions, ASKED.allowed)
        chosen.append(policy.decide(0, message).action)
        assert policy.decide(1, message).action == chosen[-1]
    assert set(chosen) == {"stay", "forward"}
    # Fair: 200 draws are within 60 and 140 but for a probability below 1e-8.
    assert 60 < chosen.count("forward") < 140
