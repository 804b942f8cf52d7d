"""What a thing is, and what the entries of a row are told apart by."""

from sjdsl.compiler import ir
from sjdsl.compiler.ir.sorts import AGENTS, level_of_agents, level_of_numbers


def test_sorts_that_have_something_in_common() -> None:
    trees, plants, deer = (
        ir.Sort("cell", ("tree",)),
        ir.Sort("cell", ("bush", "tree")),
        ir.Sort("mover", ("deer",)),
    )
    assert trees.overlaps(plants) and plants.overlaps(trees) and AGENTS.overlaps(AGENTS)
    assert (
        not trees.overlaps(ir.Sort("cell", ("bush",)))
        and not deer.overlaps(AGENTS)
        and not deer.overlaps(ir.Sort("mover", ("cow",)))
    )
    assert [sort.name for sort in (AGENTS, trees, deer)] == ["agent", "tree", "deer"]


def test_entries_of_rows() -> None:
    """Rows by numbers and by agents may have entries of the same keys, and are not the same."""
    numbers, agents = level_of_numbers(-1, 1), level_of_agents(2)
    assert (numbers.keys, agents.keys, agents.names) == (
        ("-1", "0", "1"),
        ("0", "1"),
        ("agent 0", "agent 1"),
    )
    assert (str(numbers), str(agents), str(ir.Level("word", ("raw", "cut")))) == (
        "-1 .. 1",
        "agent",
        "{ raw, cut }",
    )
    assert (numbers.place_of(0), numbers.place_of("-1"), agents.place_of(1), numbers.first) == (
        1,
        0,
        1,
        -1,
    )
    assert level_of_numbers(0, 1) != agents and [entry.key for entry in agents.entries] == [
        "0",
        "1",
    ]
