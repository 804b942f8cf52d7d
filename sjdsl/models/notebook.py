"""The notes that an agent keeps for itself."""

from collections.abc import Sequence

from sjdsl.models.policy import NoteEdit

MOST = 40  # notes; the oldest is dropped for one more
MOST_AFTER_A_TRIAL = 16  # after which they are revised: 12 lessons and 4 plans
LONGEST = 200  # characters; what is longer is cut
REVISE = f"""\
A trial has ended, and the next one begins. Rewrite your notes for it: at most 12 lessons and 4
plans, each of at most {LONGEST} characters. Only they are kept. Reply with one JSON object and
nothing else: {{"notes": ["a lesson or a plan", "another"]}}"""


def edited(notes: Sequence[str], edit: NoteEdit) -> tuple[tuple[str, ...], str]:
    """Returns the notes after an edit, and what is wrong with the edit; then they are unchanged."""
    text = edit.text[:LONGEST]
    if edit.op == "add":
        return (*notes, text)[-MOST:], ""
    if edit.id > len(notes):
        return tuple(notes), f"there is no note {edit.id} to {edit.op}"
    before = notes[: edit.id - 1]
    after = notes[edit.id :]
    if edit.op == "delete":
        return (*before, *after), ""
    return (*before, text, *after), ""
