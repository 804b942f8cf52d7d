"""The classes of diagnostics: their templates tell their own facts and no others, and a fact that is wrong is refused at once."""

from dataclasses import fields, replace
from inspect import get_annotations as annotations
from string import Formatter
from typing import ClassVar, get_args, get_origin

import pytest

from sjdsl.compiler.diagnostics import errors
from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Near, near
from sjdsl.compiler.diagnostics.explanations import kinds
from sjdsl.compiler.diagnostics.source import Span

HERE = Span("game.sj", 0, 0, 1, 1)
OF_ALL = {"span", "labels", "fix", "help"}
SAMPLES = {
    str: "abc",
    int: 7,
    float: 2.5,
    Near: Near("oak", "the trees are `oak`"),
    tuple[str, ...]: ("red", "blue"),
    tuple[Span, ...]: (HERE,),
}


def sample(kind: type[Diagnostic]) -> Diagnostic:
    """Returns a diagnostic of a kind, each of its facts a sample of its type."""
    types = {
        name: type_
        for parent in kind.__mro__
        if parent not in Diagnostic.__mro__
        for name, type_ in annotations(parent).items()
    }
    own = {
        n: SAMPLES[t if t in SAMPLES else get_args(t)[0]]
        for n, t in types.items()
        if get_origin(t) is not ClassVar
    }
    return kind(HERE, **own)


def told(template: str) -> list[str]:
    return [name for _, name, _, _ in Formatter().parse(template) if name]


@pytest.mark.parametrize("kind", kinds(), ids=lambda kind: kind.__name__)
def test_templates_tell_the_facts_of_their_class(kind: type[Diagnostic]) -> None:
    made = sample(kind)
    facts = {f.name for f in fields(made)} - OF_ALL
    names = {name for template in (kind.says, *kind.hints) for name in told(template)}
    for name in {name.split(".")[0] for name in names}:
        assert name in facts or isinstance(getattr(kind, name), property)
    computed = {
        name for name in names if isinstance(getattr(kind, name.split(".")[0], None), property)
    }
    assert computed or facts - {"declared", "places"} <= {name.split(".")[0] for name in names}, (
        "a fact that nobody is told"
    )
    assert made.message
    assert replace(made, help="do it").hint == "do it"


def test_a_fact_that_is_missing_or_misspelt_is_refused() -> None:
    with pytest.raises(TypeError, match=r"UnknownName .* name"):
        errors.UnknownName(HERE)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"UnknownName .* nmae"):
        errors.UnknownName(HERE, name="oka", nmae="oka")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match=r"positional"):
        errors.UnknownName(HERE, "oka")  # type: ignore[misc]


def test_diagnostics_are_frozen_and_equal_by_content() -> None:
    one = errors.UnknownName(HERE, name="oka", near=near("oka", ["oak"]))
    assert one == errors.UnknownName(HERE, name="oka", near=near("oka", ["oak"]))
    assert one != replace(one, name="aok")
    assert len({one, replace(one)}) == 1
    with pytest.raises(AttributeError):
        one.name = "oak"  # type: ignore[misc]


def test_the_first_hint_is_given_that_can_be() -> None:
    assert (
        errors.UnknownName(HERE, name="oka", near=near("oka", ["oak", "elm"], "the trees")).hint
        == "did you mean `oak`?"
    )
    assert (
        errors.UnknownName(HERE, name="cat", near=near("cat", ["oak", "elm"], "the trees")).hint
        == "the trees are `oak`, `elm`"
    )
    assert errors.UnknownName(HERE, name="cat", near=near("cat", ["oak", "elm"])).hint == ""


def test_numbers_are_shown_as_they_are_read() -> None:
    one = errors.TooFewToStart(HERE, place="tree", cells=1, agents=2)
    assert one.message == "1 cell of the map fit `tree`, and 2 agents begin there"
    outside = errors.OutOfLimits(HERE, name="`pay`", value=3.0, low=0, high=0.5)
    assert outside.message == "`pay` is 3, outside 0 .. 0.5"
