"""What a policy is asked in words, and what it answers."""

from dataclasses import dataclass
from typing import Literal

STAY = "stay"  # what a reply that can't be used counts as


@dataclass(frozen=True)
class Message:
    """What an agent is asked with at a step.

    system: what it is told of the game (`sjdsl.told.told`); text: the message of this step
    (`sjdsl.told.message`).
    actions: the names of all actions of the game; allowed: of those that it may take now.
    """

    system: str
    text: str
    actions: tuple[str, ...]
    allowed: tuple[str, ...]


@dataclass(frozen=True)
class NoteEdit:
    """A change of an agent's own notes. id: of the note that is replaced or deleted, from 1."""

    op: Literal["add", "replace", "delete"]
    id: int = 0
    text: str = ""


@dataclass(frozen=True)
class Reply:
    """What an agent does.

    action: the name of an action that it may take.
    why, goal: in its own words. note: how it changes its notes; None: it doesn't.
    problem: why its answer couldn't be used, or a part of it; empty if it could.
    """

    action: str
    why: str = ""
    goal: str = ""
    note: NoteEdit | None = None
    problem: str = ""
