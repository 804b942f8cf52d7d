"""How a player replies to a message, as its text says it."""

LONGEST_WHY = 500  # characters; what is longer is cut
LONGEST_GOAL = 120
REPLY = f"""\
Before each step you get a message: your last reward, steps and notes, if there are any; what you
see, under WHAT YOU SEE NOW; and the actions that are allowed, under YOUR ACTIONS NOW. Reply to it
with one JSON object and nothing else:
{{"why": "at most {LONGEST_WHY} characters", "goal": "what you are after, at most {LONGEST_GOAL} characters",
 %s"action": "one of the actions"}}
- "action" is one of the names under YOUR ACTIONS NOW. A reply that can't be read, or an action that
  isn't allowed, counts as stay. Texts that are too long are cut.
- """
NOTE = '"note": {"op": "none", "id": 0, "text": ""}, '
WITH_NOTES = """\
You remember nothing but your notes, which stay for the whole episode, and what the message says.
  "note" changes one note: "op" is "add" (with "text"), "replace" (with "id" and "text"), "delete"
  (with "id") or "none"."""
WITHOUT_NOTES = "You remember nothing but what the message says, and keep no notes."


def reply_lines(notebook: bool) -> list[str]:
    """Returns how to reply. notebook: whether the player may keep notes."""
    text = REPLY % (NOTE if notebook else "")
    text += WITH_NOTES if notebook else WITHOUT_NOTES
    return text.splitlines()
