"""Language models as players: policies that run on the host and are asked in words."""

from sjdsl.models.files import ModelSettings, Price, load_models
from sjdsl.models.policy import HostPolicy, Message, NoteEdit, Reply
from sjdsl.models.providers import FakeProvider, LanguagePolicy, Provider
from sjdsl.models.replies import read_reply

__all__ = [
    "FakeProvider",
    "HostPolicy",
    "LanguagePolicy",
    "Message",
    "ModelSettings",
    "NoteEdit",
    "Price",
    "Provider",
    "Reply",
    "load_models",
    "read_reply",
]
