"""What answers in a language model's place, and the policy that asks it."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

from sjdsl.models.policy import Answer, HostPolicy, Message, Reply
from sjdsl.models.replies import read_notes, read_reply
from sjdsl.models.schemas import NOTES, reply_schema


class Provider(Protocol):
    """Answers messages with texts."""

    def complete(self, message: Message, schema: Mapping[str, Any]) -> Answer:
        """Returns the answer to a message, as it comes. schema: the JSON schema of a reply."""
        ...


@dataclass(frozen=True)
class FakeProvider:
    """Chooses an action by a hash of what it is told, for tests and for runs that cost nothing."""

    def complete(self, message: Message, schema: Mapping[str, Any]) -> Answer:
        """Returns a valid reply, the same for the same message; each action is as likely."""
        asked = f"{message.system}\0{message.text}"
        reply: dict[str, Any] = {"notes": ["by a hash"]}
        if schema is not NOTES:
            number = int.from_bytes(hashlib.sha256(asked.encode()).digest()[:8])
            action = message.allowed[number % len(message.allowed)]
            none = {"op": "none", "id": 0, "text": ""}
            reply = {"why": "by a hash", "goal": "", "note": none, "action": action}
        text = json.dumps(reply)
        return Answer(text, model="fake", input=len(asked) // 4, output=len(text) // 4)


@dataclass(frozen=True)
class LanguagePolicy(HostPolicy):
    """Asks a provider."""

    provider: Provider
    notebook: bool = True

    def decide(self, agent: int, message: Message) -> Reply:
        """Returns what an agent does after a message."""
        del agent  # what it may know of itself stands in the message
        schema = reply_schema(message.actions, self.notebook)
        answer = self.provider.complete(message, schema)
        return replace(read_reply(answer.text, message), answer=answer)

    def revise(self, agent: int, message: Message) -> Reply:
        """Returns an agent's notes after a trial."""
        del agent
        answer = self.provider.complete(message, NOTES)
        return replace(read_notes(answer.text), answer=answer)
