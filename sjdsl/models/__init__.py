"""Language models as players: policies that are asked in words."""

from sjdsl.models.policy import Message, NoteEdit, Reply
from sjdsl.models.providers import FakeProvider, LanguagePolicy, Provider
from sjdsl.models.replies import read_reply

__all__ = [
    "FakeProvider",
    "LanguagePolicy",
    "Message",
    "NoteEdit",
    "Provider",
    "Reply",
    "read_reply",
]
