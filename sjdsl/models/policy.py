"""What a policy is asked in words, and what it answers."""

from dataclasses import dataclass
from typing import Literal

from sjdsl.told.message import HISTORY

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
class Answer:
    """What a server sent.

    model: its own name of the model; finish: why the answer ends.
    input, cached, output: tokens, of the input also those that the server had cached.
    """

    text: str
    reasoning: str = ""
    model: str = ""
    finish: str = ""
    input: int = 0
    cached: int = 0
    output: int = 0


@dataclass(frozen=True)
class Reply:
    """What an agent does.

    action: the name of an action that it may take.
    why, goal: in its own words. note: how it changes its notes; None: it doesn't.
    problem: why its answer couldn't be used, or a part of it; empty if it could.
    notes: all its notes anew, if it was asked to revise them; None: they stay.
    is_valid: False if `action` is only what an unusable answer counts as.
    answer: as a server sent it, if one was asked.
    """

    action: str
    why: str = ""
    goal: str = ""
    note: NoteEdit | None = None
    problem: str = ""
    notes: tuple[str, ...] | None = None
    is_valid: bool = True
    answer: Answer | None = None


class HostPolicy:
    """Decides outside of compiled code: a language model, a person, a web form. Subclass it.

    notebook: whether it may keep notes; ledger: whether it is told what its actions paid so far;
    history: of how many of its last steps it is reminded.
    role: the name of the part that it plays (`sjdsl.models.roles`), or empty.
    """

    notebook: bool = True
    ledger: bool = True
    history: int = HISTORY
    role: str = ""

    def decide(self, agent: int, message: Message) -> Reply:
        """Returns what an agent does. Several threads call it at once."""
        raise NotImplementedError

    def revise(self, agent: int, message: Message) -> Reply:
        """Returns, after a trial, a reply of which only `notes` counts; by default they stay."""
        del agent, message
        return Reply(STAY)
