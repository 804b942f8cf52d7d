"""SJ3xx: maps (unknown glyphs, ragged rows, missing files) and shapes."""

from sjdsl.compiler.diagnostics.diagnostic import AboutName, Diagnostic


class UnknownGlyph(Diagnostic, code="SJ301", title="Unknown map glyph"):
    says = "glyph `{glyph}` at row {row}, column {column} is in no kind"
    hints = (
        "declare it with `kind` or `glyph`, or did you mean `{other_case}`?",
        'declare it, as in `kind NAME "{glyph}"`',
    )
    glyph: str
    row: int
    column: int
    other_case: str


class RaggedMap(Diagnostic, code="SJ302", title="Rows of different length"):
    says = "row {row} has {length} characters, the others {wanted}"
    row: int
    length: int
    wanted: int


class TooFewCells(Diagnostic, code="SJ303", title="Too few cells"):
    says = "`{kind}` has {cells:cell} for {agents} {who}"
    hints = ("enlarge the map, or lower the number of {who}",)
    kind: str
    cells: int
    agents: int
    who: str = "agents"


class GlyphTwice(Diagnostic, code="SJ304", title="A glyph of two kinds"):
    says = "glyph `{glyph}` belongs to `{first}` and to `{second}`"
    hints = ("give one of them another glyph",)
    glyph: str
    first: str
    second: str


class BadPicture(Diagnostic, code="SJ305", title="A picture that shows no shape"):
    says = "{problem}"
    hints = (
        "a picture has exactly one `^` (the agent, facing up); its cells are `x`, all else `.`",
    )
    problem: str


class KindAbsent(
    AboutName, code="SJ306", title="A kind that is not on the map", severity="warning"
):
    says = "kind `{name}` never appears on the map"


class EmptyMap(Diagnostic, code="SJ307", title="A map without cells"):
    says = "the map has no cells"


class BadGlyph(Diagnostic, code="SJ308", title="Not a glyph"):
    says = "`{glyph}` cannot be a glyph: {problem}"
    hints = ("a glyph is one printable ASCII character",)
    glyph: str
    problem: str


class GlyphOfAgents(
    Diagnostic, code="SJ311", title="A glyph that agents are drawn with", severity="warning"
):
    says = (
        "agents are drawn as `^`, `>`, `v` and `<` where a board is written, in traces and scenes, "
        "so nobody can tell `{glyph}` from an agent"
    )
    hints = ("choose another glyph",)
    glyph: str


class MapFile(AboutName, code="SJ309", title="A map that cannot be read"):
    says = "the map `{name}` cannot be read: {problem}"
    hints = ("a map is plain text, one line a row",)
    problem: str


class DirectedShape(AboutName, code="SJ310", title="A shape that needs a heading"):
    says = "`{name}` needs an agent's heading, and `{anchor}` is a cell"
    hints = ("use `disc`, `diamond` or `square` around cells",)
    anchor: str
