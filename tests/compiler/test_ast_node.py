"""Nodes of the tree: equal by content, and not to be changed."""

from dataclasses import FrozenInstanceError, replace

import pytest

from sjdsl.compiler import ast
from sjdsl.compiler.diagnostics.source import Span

HERE = Span("a.sj", 0, 5, 1, 1)
NAME = ast.Name(HERE, "apple")


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
