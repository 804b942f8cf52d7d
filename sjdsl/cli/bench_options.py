"""Parses the options of `sjdsl bench`."""

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from sjdsl.runtime.env import Encoding

OBSERVATIONS: tuple["Encoding", "Encoding"] = ("tokens", "onehot")


class Counts(click.ParamType["tuple[int, ...]"]):
    """`1,128,1024` as whole numbers."""

    name = "numbers"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, ...]:
        parts = [part.strip() for part in value.split(",")]
        if not all(part.isdecimal() and int(part) > 0 for part in parts):
            self.fail(f"`{value}` is not a list of whole numbers such as 1,128,1024", param, ctx)
        return tuple(dict.fromkeys(int(part) for part in parts))


class Agents(click.ParamType["tuple[int | None, ...]"]):
    """`own,20` as None, for as many agents as the game says, and whole numbers."""

    name = "numbers"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int | None, ...]:
        parts = [part.strip() for part in value.split(",")]
        if not all(part == "own" or (part.isdecimal() and int(part) > 0) for part in parts):
            self.fail(f"`{value}` is not a list of numbers of agents such as own,20", param, ctx)
        return tuple(dict.fromkeys(None if part == "own" else int(part) for part in parts))


class Words(click.ParamType["tuple[str, ...]"]):
    """`tokens,onehot` as words, out of those that are known."""

    name = "words"

    def __init__(self, known: tuple[str, ...]) -> None:
        self.known = known

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        parts = tuple(part.strip() for part in value.split(","))
        if not set(parts) <= set(self.known):
            each = ", ".join(f"`{word}`" for word in self.known)
            self.fail(f"`{value}` is not {each} or `{','.join(self.known[:2])}`", param, ctx)
        return tuple(dict.fromkeys(parts))
