"""What the reference reads differently in docstrings: one line about several names, and functions that are kept compiled."""

import re
from collections.abc import Iterator
from typing import Any

import griffe

SECTION = re.compile(r"^(\s*)(Args|Attributes):$")
SEVERAL = re.compile(r"^(\s*)(\w+(?:, \w+)+):\s+(.*)$")
COMPILED = re.compile(r"^(?:\w+\()*jax\.jit\((?:\w+\()*self\.(_\w+)\)+$")


def one_name_a_line(text: str) -> str:
    """Returns a docstring in which a line of a section about `a, b` is a line about each."""
    return "\n".join(_lines(text.split("\n")))


def _lines(lines: list[str]) -> Iterator[str]:
    inside: int | None = None
    for number, line in enumerate(lines):
        section = SECTION.match(line)
        if section:
            inside = len(section.group(1))
        elif line.strip() and inside is not None and len(line) - len(line.lstrip()) <= inside:
            inside = None
        found = SEVERAL.match(line)
        if inside is None or not found:
            yield line
            continue
        indent, names, said = found.groups()
        *first, last = names.split(", ")
        rest = _continued(lines[number + 1 :], len(indent))
        yield from (f"{indent}{name}: {' '.join([said, *rest])}" for name in first)
        yield f"{indent}{last}: {said}"


def _continued(lines: list[str], indent: int) -> Iterator[str]:
    """Yields the lines that go on with what the line before says."""
    for line in lines:
        if not line.strip() or len(line) - len(line.lstrip()) <= indent:
            return
        yield line.strip()


class Docstrings(griffe.Extension):
    """Changes docstrings before they are read."""

    def on_object(self, *, obj: griffe.Object, **_more: Any) -> None:
        """Splits lines about several names."""
        if obj.docstring is not None:
            obj.docstring.value = one_name_a_line(obj.docstring.value)

    def on_module_members(self, *, mod: griffe.Module, **_more: Any) -> None:
        """The public names of a package that imports lazily (`lazy_names`) are those that type checkers see it import."""
        if mod.exports is None and "lazy_names" in mod.members:
            mod.exports = [
                name
                for name, member in mod.members.items()
                if member.is_alias and not member.runtime
            ]

    def on_class_members(self, *, cls: griffe.Class, **_more: Any) -> None:
        """Gives an attribute that is a compiled method the docstring of that method."""
        for member in cls.members.values():
            if member.is_alias or not member.is_attribute or member.docstring is not None:
                continue
            found = COMPILED.match(str(member.value))  # type: ignore[union-attr]
            method = cls.members.get(found.group(1)) if found else None
            if method is not None and method.docstring is not None:
                member.docstring = griffe.Docstring(
                    one_name_a_line(method.docstring.value),
                    lineno=method.docstring.lineno,
                    parent=member,
                )  # type: ignore[arg-type]
