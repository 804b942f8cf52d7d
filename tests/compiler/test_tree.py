"""Trees are walked and rewritten alike, whether they are syntax, typed rules or array programs; nodes of syntax are equal by content."""

from dataclasses import FrozenInstanceError, replace

import pytest

from sjdsl.compiler import ast, ir
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.diagnostics.tree import children, rewrite, walk
from sjdsl.compiler.program import expressions as array
from sjdsl.compiler.syntax.parse import parse

HERE = Span("a.sj", 0, 5, 1, 1)
NAME = ast.Name(HERE, "apple")
TEXT = """sj 1
game steps "Steps" {
  episode 5
  phase walk { when 2 > 1 { end } }
}
"""


def test_the_syntax() -> None:
    file = parse(Source("steps.sj", TEXT))
    numbers = [node for node in walk(file) if isinstance(node, ast.Int)]
    assert [number.value for number in numbers] == [5, 2, 1]
    doubled = rewrite(
        file, lambda node: ast.Int(node.span, 2 * node.value) if isinstance(node, ast.Int) else node
    )
    assert [node.value for node in walk(doubled) if isinstance(node, ast.Int)] == [10, 4, 2]
    assert file == parse(Source("steps.sj", TEXT)) and rewrite(file, lambda node: node) is file


def test_the_rules() -> None:
    agent = ir.Member(name="agent", sort=ir.Sort("agent"))
    send = ir.Remove(who=agent)
    each = ir.Each(domain=ir.Domain(var=agent), body=(send, ir.End()))
    assert children(each) == [each.domain, send, ir.End()]
    assert rewrite(each, lambda node: (node, node) if isinstance(node, ir.End) else node).body == (
        send,
        ir.End(),
        ir.End(),
    )
    other = rewrite(
        each,
        lambda node: (
            node.model_copy(update={"name": "other"}) if isinstance(node, ir.Member) else node
        ),
    )
    assert (other.domain.var.name, other.body[0].who.name, each.domain.var.name) == (
        "other",
        "other",
        "agent",
    )  # type: ignore[union-attr]


def test_a_program() -> None:
    made = array.Assign(("x",), array.call("f", array.Name("a"), key=array.Name("b")))
    assert [node.identifier for node in walk(made) if isinstance(node, array.Name)] == [
        "f",
        "a",
        "b",
    ]
    upper = rewrite(
        made,
        lambda node: array.Name(node.identifier.upper()) if isinstance(node, array.Name) else node,
    )
    assert upper == array.Assign(("x",), array.call("F", array.Name("A"), key=array.Name("B")))


def test_nodes_are_equal_by_class_and_content() -> None:
    assert ast.Name(HERE, "apple") == NAME != replace(NAME, text="pear")
    assert len({NAME, ast.Name(HERE, "apple"), replace(NAME, text="pear")}) == 2
    assert ast.String(HERE, "apple") != NAME


def test_a_node_cannot_be_changed() -> None:
    with pytest.raises(FrozenInstanceError):
        NAME.text = "pear"  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        del NAME.text
    assert NAME.text == "apple"


def test_a_node_shows_its_fields() -> None:
    assert repr(NAME) == f"Name(span={HERE!r}, text='apple')"
