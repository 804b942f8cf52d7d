"""What all readers of a typed game ask of it, answered for games that can be counted by hand."""

from pathlib import Path

from sjdsl.compiler import build, ir
from sjdsl.compiler.ir import queries
from sjdsl.compiler.syntax.read import read_source

CASES = Path(__file__).parents[1] / "cases"


def game_of(case: str) -> ir.Game:
    return build(read_source(CASES / f"{case}.sj")).game


BEAMS, ROWS, SENDING = map(game_of, ("beams", "rows", "sending"))


def test_declarations_by_name() -> None:
    assert [(f.held_by, f.name) for f in queries.all_fields(BEAMS)] == [(ir.Sort("cell", ("ore",)), "left"), (ir.Sort("agent"), "heard")]
    assert queries.kind_named(BEAMS, "ore").glyph == "o"
    assert queries.shape_named(BEAMS, "beam").directed
    assert queries.event_named(BEAMS, "missed").per_agent
    reads = [node for node in ir.walk(BEAMS) if isinstance(node, ir.FieldRead)]
    assert {read.held_by.what for read in reads} == {"cell", "agent"}
    assert all(queries.declared_field(BEAMS, read).name == read.name for read in reads)


def test_entries_are_counted_and_written_as_their_rows_are_declared() -> None:
    assert queries.counts_of(queries.event_named(ROWS, "seen")) == (("raw", "seen[raw]"), ("cut", "seen[cut]"))
    assert queries.counts_of(queries.event_named(BEAMS, "missed")) == ((None, "missed"),)
    targets = [node.target for node in ir.walk(ROWS) if isinstance(node, ir.Set | ir.Add)]
    assert all(isinstance(target, ir.At) for target in targets)
    assert {queries.written_field(target).name for target in targets} == {"bag"}


def test_what_the_map_means() -> None:
    assert queries.kinds_by_glyph(SENDING) == {".": "grass", "h": "home", "H": "home"}
    assert queries.glyphs_of(SENDING, ("home",)) == "hH"
    assert [queries.starts_of(SENDING, meaning) for meaning in SENDING.glyphs] == [{}, {"state": "free"}, {"state": "shut"}]
    assert [kind.name for kind in BEAMS.kinds if queries.blocks_always(kind)] == ["wall"]
    assert [kind.name for kind in BEAMS.kinds if queries.blocks_always(kind, "beam")] == ["wall"]


def test_what_the_rules_contain() -> None:
    assert [phase.name for phase in queries.phases_of(SENDING)] == ["start", "go"]
    assert [phase.name for phase in queries.marking_phases(BEAMS)] == ["work"]
    assert queries.contains(SENDING, ir.Remove, ir.Mark)
    assert not queries.contains(ROWS, ir.Remove, ir.Mark)
    headings = queries.heading_observable(BEAMS)
    assert headings is not None
    assert headings.what == "heading"
    assert queries.heading_observable(BEAMS.model_copy(update={"observables": ()})) is None
    assert [queries.can_be_away(game) for game in (BEAMS, ROWS, SENDING)] == [False, False, True]
