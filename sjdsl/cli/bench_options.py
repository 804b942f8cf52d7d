"""Parses the options of `sjdsl bench`."""

from collections.abc import Container, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from sjdsl.runtime.env import Encoding

OBSERVATIONS: tuple["Encoding", "Encoding"] = ("tokens", "onehot")
Word = TypeVar("Word", bound=str)
NETWORKS = ("mlp", "cnn")
ALGORITHMS = ("ippo", "mappo", "vdn")
SHARINGS = ("shared", "per_agent", "by_role")


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


class Steps(click.ParamType[int]):
    """`1e9` or `1000000000` as a whole number above 0."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> int:
        try:
            number = float(value)
        except ValueError:
            number = 0.0
        if number < 1 or not number.is_integer():
            self.fail(f"`{value}` is not a whole number of environment steps such as 1e9", param, ctx)
        return int(number)


def flat(words: Iterable[tuple[Word, ...]]) -> tuple[Word, ...]:
    """Returns the words of an option that may be given several times, each once."""
    return tuple(dict.fromkeys(word for several in words for word in several))


def refuse_others(context: click.Context, mode: str, allowed: Container[str]) -> None:
    """Raises UsageError for a parameter that was written and that a mode of the command takes no notice of.

    Args:
      mode: the option that chooses it, such as `--from`.
      allowed: names of the parameters that it does take notice of.
    """
    for parameter in context.command.params:
        name = parameter.name or ""
        if name not in allowed and context.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE:
            said = parameter.opts[0] if isinstance(parameter, click.Option) else parameter.make_metavar(context)
            raise click.UsageError(f"{mode} goes without {said}", context)


class Quoting(click.Command):
    """A command that keeps what was written after its name, to be quoted beside what it makes."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        ctx.meta["written"] = tuple(args)
        return super().parse_args(ctx, args)
