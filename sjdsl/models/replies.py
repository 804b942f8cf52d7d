"""Reads the reply of a language model, a JSON object as `sjdsl.told` asks for."""

import json
from typing import Any

from sjdsl.models.notebook import LONGEST, MOST_AFTER_A_TRIAL
from sjdsl.models.policy import STAY, Message, NoteEdit, Reply
from sjdsl.near_names import meant
from sjdsl.told.reply import LONGEST_GOAL, LONGEST_WHY

NO_OBJECT = "your reply was not a JSON object"
LONGEST_QUOTED = 40  # characters of an action that isn't there, in the problem
EDITS = ("add", "replace", "delete")


def read_reply(text: str, message: Message) -> Reply:
    """Returns what a text says as a reply; if it can't be used, `stay` and the reason.

    A wrong note doesn't invalidate the action.
    """
    fields = _fields(text)
    if fields is None:
        return Reply(STAY, problem=NO_OBJECT, is_valid=False)
    why = _text(fields.get("why"))[:LONGEST_WHY]
    goal = _text(fields.get("goal"))[:LONGEST_GOAL]
    note, problem = _note(fields.get("note"))
    action = fields.get("action")
    if not isinstance(action, str) or action not in message.allowed:
        return Reply(STAY, why, goal, note, _wrong_action(action, message), is_valid=False)
    return Reply(action, why, goal, note, problem)


def read_notes(text: str) -> Reply:
    """Returns a reply with the notes of a text; if they can't be read, with none and the reason."""
    fields = _fields(text)
    notes = None if fields is None else fields.get("notes")
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        return Reply(STAY, problem="your notes could not be read, and stay", is_valid=False)
    return Reply(STAY, notes=tuple(_text(note)[:LONGEST] for note in notes[:MOST_AFTER_A_TRIAL]))


def _fields(text: str) -> dict[str, Any] | None:
    """Returns the JSON object that a reply is; None if it is none."""
    try:
        fields = json.loads(_without_fence(text))
    except (ValueError, RecursionError):  # not JSON, a number of too many digits, or too deep
        return None
    return fields if isinstance(fields, dict) else None


def _without_fence(text: str) -> str:
    """Returns a reply without the fence of Markdown that models like to put around it."""
    stripped = text.strip()
    if stripped.startswith("```") and stripped.endswith("```") and "\n" in stripped:
        return stripped[stripped.index("\n") : -3]
    return stripped


def _wrong_action(action: Any, message: Message) -> str:
    if not isinstance(action, str):
        return 'your reply had no "action" with the name of an action'
    if action in message.actions:
        return f"{action} was not allowed"
    quoted = action[:LONGEST_QUOTED]
    return f"there is no action {quoted!r}{meant(quoted, message.actions, those='')}"


def whole_characters(text: str) -> str:
    """Returns a text with `?` for lone surrogates, halves of characters that UTF-8 can't hold."""
    return text.encode(errors="replace").decode()


def _text(value: Any) -> str:
    return whole_characters(value) if isinstance(value, str) else ""


def _note(value: Any) -> tuple[NoteEdit | None, str]:
    """Returns the change of notes that a reply asks for, and what is wrong with it."""
    if value is None:
        return None, ""
    if not isinstance(value, dict):
        return None, "your note was not an object"
    if value.get("op", "none") == "none":
        return None, ""
    op = value["op"]
    number = value.get("id", 0)
    text = _text(value.get("text"))
    if op not in EDITS:
        return None, f'your note\'s "op" was not one of {", ".join(EDITS)}'
    if op != "add" and (not isinstance(number, int) or isinstance(number, bool) or number < 1):
        return None, f'your note to {op} had no "id"'
    if op != "delete" and not text:
        return None, f'your note to {op} had no "text"'
    return NoteEdit(op, 0 if op == "add" else number, text if op != "delete" else ""), ""
