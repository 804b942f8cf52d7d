"""Tables of a sheet, and the sources and comments that it quotes."""

from sjdsl.compiler import ir
from sjdsl.compiler.diagnostics.source import Source
from sjdsl.doc import read_written, rule_sheet
from sjdsl.doc.wording import number, table, table_value


def test_numbers_and_tables() -> None:
    assert [number(x) for x in (1, 1.0, 0.25, 0.00008, 1e-12, -3.5)] == [
        "1",
        "1",
        "0.25",
        "0.00008",
        "1e-12",
        "-3.5",
    ]
    assert (
        table_value(((1, 0), (2, 3.5)), (ir.IndexSet("word", ("raw", "cut")),) * 2)
        == "`raw`: (`raw`: 1, `cut`: 0), `cut`: (`raw`: 2, `cut`: 3.5)"
    )
    assert table(("a", "b", "c"), [("|", "", "c"), ("", "", "")]) == [
        "| a | c |",
        "| --- | --- |",
        "| \\| | c |",
        "|  |  |",
    ]


BEFORE = 'sj 1\ngame pit "A pit" {\n'
AFTER = """
  episode 5
  kind grass "#"   # the glyph is no comment
  map { "##" }
  agents players { acts stay  field bag by { red, blue } : 0 .. 9 = 0 }
  phase start { each agent { send agent to grass } }
  schedule rest
  phase rest { each agent { give pay[red] + pay[blue] * rate to agent } }
  variant rich { set pay[red] = 7   # ours: more
  }
}
"""
NUMBERS = """  size players : count = 1 + 1 in 1 .. 2   # paper: two
  param rate : probability = 0.5
  param pay : reward = {   # first part
    red: 2 / players,      # second part
    blue: 3 }
"""


def sheet_lines(variants: tuple[str, ...] = ()) -> list[str]:
    source = Source("pit.sj", BEFORE + NUMBERS + AFTER)
    return rule_sheet(read_written(source, variants)).splitlines()


def test_numbers_name_their_sources() -> None:
    rows = [
        line for line in sheet_lines() if line.startswith(("| `players`", "| `rate`", "| `pay`"))
    ]
    assert rows == [
        "| `players` | 2; computed as `1 + 1` | count | 1 to 2 | before compiling | paper: two |",
        "| `rate` | 0.5 | probability | 0 to 1 | at any time |  |",
        "| `pay` | `red`: 1, `blue`: 3; `red` computed as `2 / players` | reward | any | at any time | first part; second part |",
    ]


def test_a_variant_names_the_source_of_what_it_changes() -> None:
    (row,) = (line for line in sheet_lines(("rich",)) if line.startswith("| `pay`"))
    assert (
        row
        == "| `pay` | `red`: 7, `blue`: 3 | reward | any | at any time | first part; second part; ours: more |"
    )


PIT = BEFORE + NUMBERS + AFTER


def lines_of(title: str, text: str) -> list[str]:
    """Returns the lines of one section of a sheet."""
    return (
        rule_sheet(read_written(Source("pit.sj", text)))
        .partition(f"## {title}\n\n")[2]
        .partition("\n\n#")[0]
        .splitlines()
    )


def test_rules_are_quoted_with_their_comments() -> None:
    rest = """
  # paper: the agents
  # do nothing but earn
  phase rest { each agent { give pay[red] + pay[blue]*rate to agent } }  # ours: at once

  # of what follows
  checks { always step >= 0  require rate > 0 }  # both
"""
    text = PIT.replace(
        "  phase rest { each agent { give pay[red] + pay[blue] * rate to agent } }", rest
    )
    assert lines_of("Phases", text) == [
        "```sj",
        "# paper: the agents",
        "# do nothing but earn",
        "phase rest { each agent { give pay[red] + pay[blue] * rate to agent } }  # ours: at once",
        "```",
    ]
    assert lines_of("Checks", text) == [
        "```sj",
        "always step >= 0",
        "require rate > 0  # both",
        "```",
    ]
    assert lines_of("Process overview: one step", text)[1:3] == ["schedule rest", "episode 5"]


def test_an_observation_that_cannot_be_compiled_is_said() -> None:
    text = PIT.replace("acts stay", "acts stay  field held : 0 .. 999 = 0").replace(
        "  schedule", "  observe { show agent.held }\n  schedule"
    )
    assert (
        lines_of("Observation", text)[-1]
        == "The compiler cannot make observations: showing `agent.held`, which can reach 999 (at most 255)."
    )
