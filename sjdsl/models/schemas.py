"""The JSON schemas of replies: one for all messages of a game, so that servers can cache it."""

from collections.abc import Mapping, Sequence
from typing import Any

TEXT = {"type": "string"}


def _object(properties: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the schema of an object with all these properties, as strict schemas are."""
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }


NOTES = _object({"notes": {"type": "array", "items": TEXT}})


def reply_schema(actions: Sequence[str], notebook: bool) -> dict[str, Any]:
    """Returns the schema of a reply with any action of a game; the legal ones stand in the text."""
    properties: dict[str, Any] = {"why": TEXT, "goal": TEXT}
    if notebook:
        op = {"type": "string", "enum": ["none", "add", "replace", "delete"]}
        properties["note"] = _object({"op": op, "id": {"type": "integer"}, "text": TEXT})
    properties["action"] = {"type": "string", "enum": list(actions)}
    return _object(properties)
