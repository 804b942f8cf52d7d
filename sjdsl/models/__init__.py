"""Language models as players: policies that are asked in words."""

from sjdsl.models.account import Limits
from sjdsl.models.errors import LimitReached, ModelError
from sjdsl.models.files import Model, find_model, is_model_name, load_models
from sjdsl.models.policy import Answer, HostPolicy, Message, NoteEdit, Reply
from sjdsl.models.providers import FakeProvider, LanguagePolicy, Provider
from sjdsl.models.replies import read_reply
from sjdsl.models.seats import Seats
from sjdsl.models.talks import Talks
from sjdsl.told import told

__all__ = [
    "Answer",
    "FakeProvider",
    "HostPolicy",
    "LanguagePolicy",
    "LimitReached",
    "Limits",
    "Message",
    "Model",
    "ModelError",
    "NoteEdit",
    "Provider",
    "Reply",
    "Seats",
    "Talks",
    "find_model",
    "is_model_name",
    "load_models",
    "read_reply",
    "told",
]
