"""What answers in a language model's place, and the policy that asks it."""

import hashlib
import json
from dataclasses import dataclass
from typing import Protocol

from sjdsl.models.policy import Message, Reply
from sjdsl.models.replies import read_reply


class Provider(Protocol):
    """Answers messages with texts."""

    def complete(self, message: Message) -> str:
        """Returns the answer to a message, as it comes."""
        ...


@dataclass(frozen=True)
class FakeProvider:
    """Chooses an action by a hash of what it is told, for tests and for runs that cost nothing."""

    def complete(self, message: Message) -> str:
        """Returns a valid reply, the same for the same message; each action is as likely."""
        told = f"{message.system}\0{message.text}".encode()
        number = int.from_bytes(hashlib.sha256(told).digest()[:8])
        action = message.allowed[number % len(message.allowed)]
        none = {"op": "none", "id": 0, "text": ""}
        return json.dumps({"why": "by a hash", "goal": "", "note": none, "action": action})


@dataclass(frozen=True)
class LanguagePolicy:
    """Asks a provider, outside of compiled code. If there is one action only, it doesn't ask."""

    provider: Provider

    def decide(self, agent: int, message: Message) -> Reply:
        """Returns what an agent does after a message."""
        del agent  # what it may know of itself stands in the message
        if len(message.allowed) == 1:
            return Reply(message.allowed[0])
        return read_reply(self.provider.complete(message), message)
