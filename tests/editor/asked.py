"""A small game to ask about, and a text with a cursor in it."""

from collections.abc import Sequence
from pathlib import Path

from lsprotocol import types

from sjdsl.editor.session import Session

ORCHARD = """sj 1
game orchard "An orchard" {
  size  players : count       = 2 in 1 .. 4
  param apple   : reward      = 1                # ours
  param regrow  : probability = 0.05
  episode 20
  kind grass "."
  kind tree  "T" { field fruit : { none, ripe } = ripe  field owner : agent  glyph "t" with fruit = none }
  kind bush  "B" { field fruit : { none, ripe } = none }
  kind gate  "G"
  group plants = tree, bush
  map { "G..G" ".TB." }
  agents players {
    acts turn_left, turn_right, forward, stay, share, zap
    moves relative
    field bag : 0 .. 9 capped = 0
    timer sore  forbid zap when agent.sore > 0
  }
  shape beam = line(2)
  define ready(who) = who.bag > 0
  phase start { each agent { send agent to gate facing north } }
  schedule tick -> grow -> walk -> eat -> fire
  phase grow { each plants where plants.fruit is none and nobody on plants { chance regrow { set plants.fruit = ripe } } }
  phase walk { move each agent }
  phase eat {
    each agent as eater on tree where tree.fruit is ripe {
      set tree.fruit = none  set tree.owner = eater  add 1 to eater.bag  give apple to eater  tally eaten for eater
    }
  }
  phase fire {
    each agent as zapper where zapper chose zap and ready(zapper) {
      each agent as hit in beam of zapper { set hit.sore = 3  tally hits for zapper }
    }
    each agent where agent chose share { tally given for agent }
  }
  observe { window ahead 2, behind 1, left 1, right 1 }
  metrics { event eaten  event hits  event given  mean ripe_trees = count(tree where tree.fruit is ripe) }
  checks { always count(agent) == players  expect hits == 0 with never(zap) over 2 episodes }
  policy eater_first "eats" { seek tree where tree.fruit is ripe }
  variant rich "twice the reward" { set apple = 2 }
}
"""


def opened(
    text: str = ORCHARD,
    folder: Path | None = None,
    name: str = "orchard.sj",
    session: Session | None = None,
) -> tuple[Session, str]:
    """Returns a session with one open text, and its URI: a file of `folder`, or one that was never saved."""
    session = session or Session(folders=[] if folder is None else [folder])
    uri = f"untitled:{name}" if folder is None else (folder / name).as_uri()
    session.open(uri, text, 1)
    return session, uri


def place(session: Session, uri: str, before: str) -> types.Position:
    """Returns the position behind the first occurrence of some characters."""
    document = session.documents.get(uri)
    assert document is not None
    return document.lines.position(document.text.index(before) + len(before))


def texts(session: Session, locations: list[types.Location]) -> list[tuple[str, int, str]]:
    """Returns file names, lines from 1 and what stands at locations."""
    found = []
    for location in locations:
        document = session.documents.get(location.uri)
        assert document is not None
        start, end = (document.lines.offset(p) for p in (location.range.start, location.range.end))
        found.append(
            (
                location.uri.rpartition("/")[2],
                location.range.start.line + 1,
                document.text[start:end],
            )
        )
    return found


def edited(session: Session, uri: str, edits: Sequence[types.TextEdit]) -> str:
    """Returns a text after edits of the protocol."""
    document = session.documents.get(uri)
    assert document is not None
    text = document.text
    for edit in sorted(
        edits, key=lambda edit: document.lines.offset(edit.range.start), reverse=True
    ):
        text = (
            text[: document.lines.offset(edit.range.start)]
            + edit.new_text
            + text[document.lines.offset(edit.range.end) :]
        )
    return text
