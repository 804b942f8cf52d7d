"""Users' own settings, the table `own`: hooks take them by the names of their arguments."""

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from inspect import Parameter, signature
from typing import Annotated, Any

from pydantic import BeforeValidator, PlainSerializer

from sjdsl.near_names import meant

from .extensions import Kind, find

OWN = "own."  # prefix of such a setting on the command line, on an axis of a sweep, and in messages
FROM_TRAINERS = ("planes", "width", "dtype", "parent", "name")  # arguments that networks get anyway
Value = bool | int | float | str
Hooks = Mapping[Kind, str]  # the names of the user's own algorithm, loss, network and reward


def _read_own(table: Any) -> Any:
    """Returns settings as pairs, sorted by name. Raises ValueError for anything else."""
    refusal = "a table of numbers, texts, true or false, by name"
    try:
        pairs = sorted((name, _read_value(value)) for name, value in dict(table).items())
    except (TypeError, ValueError):
        raise ValueError(refusal) from None
    for name, value in pairs:
        is_number = isinstance(value, float) and math.isfinite(value)
        if not str(name).isidentifier() or not (is_number or isinstance(value, int | str)):
            raise ValueError(refusal)
    return tuple(pairs)


def _read_value(value: Any) -> Any:
    """Returns the value of a text from the command line; anything else unchanged."""
    if not isinstance(value, str):
        return value
    for read in (int, float):
        with suppress(ValueError):
            return read(value)
    return {"true": True, "false": False}.get(value, value)


Own = Annotated[tuple[tuple[str, Value], ...], BeforeValidator(_read_own), PlainSerializer(dict)]


def flatten_own(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns settings with those of the table `own` listed as `own.NAME`.

    An `own.NAME` that is given directly wins.
    """
    others = dict(values)
    if not isinstance(values.get("own"), Mapping):
        return others
    own = others.pop("own")
    return {OWN + name: value for name, value in own.items()} | others


def gather_own(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns settings with those named `own.NAME` moved into the table `own`."""
    own = {}
    others = {}
    for name, value in values.items():
        if name.startswith(OWN):
            own[name.removeprefix(OWN)] = value
        else:
            others[name] = value
    return {"own": own} | others if own else others


def filled(kind: Kind, name: str, own: Iterable[tuple[str, Any]]) -> Any:
    """Returns the hook of a name, with the settings that it takes filled in."""
    hook = find(kind, name)
    taken = settings_of(kind, hook)
    return partial(hook, **{setting: value for setting, value in own if setting in taken})


def settings_of(kind: Kind, hook: Any) -> dict[str, Any]:
    """Returns the settings that a hook takes, with their defaults.

    They are its keyword-only arguments; of a network, all that trainers don't fill in.
    """
    try:
        arguments = signature(hook).parameters.values()
    except ValueError:  # some functions of extension modules have no signature
        return {}
    takes = [Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_OR_KEYWORD]
    if kind != "network":
        takes.remove(Parameter.POSITIONAL_OR_KEYWORD)
    return {
        argument.name: argument.default
        for argument in arguments
        if argument.kind in takes and argument.name not in FROM_TRAINERS
    }


def taken_settings(hooks: Hooks) -> Iterator[tuple[str, Any, str]]:
    """Yields the settings that hooks take, with their defaults, and the hook in words.

    Hooks are imported.
    """
    for kind, name in hooks.items():
        for setting, default in settings_of(kind, find(kind, name)).items():
            yield setting, default, f"the {kind} `{name}`"


def unread_own(hooks: Hooks, own: Iterable[tuple[str, Any]]) -> dict[str, str]:
    """Returns a message for each of the user's settings that no hook takes; hooks are imported."""
    taken = [setting for setting, _, _ in taken_settings(hooks)]
    if hooks:
        listed = " and ".join(f"the {kind} `{name}`" for kind, name in hooks.items())
        reason = f"{listed} has no keyword-only argument of that name"
    else:
        reason = "there is no algorithm, loss, network or reward of your own to take it"
    return {
        name: f"`{OWN}{name}` does nothing: {reason}{meant(name, taken, 'the settings are')}"
        for name, _ in own
        if name not in taken
    }


def missing_own(hooks: Hooks, own: Iterable[tuple[str, Any]]) -> Iterator[str]:
    """Yields a message for each setting that a hook requires and that isn't given."""
    values = dict(own)
    for name, default, hook in taken_settings(hooks):
        if default is Parameter.empty and name not in values:
            yield (
                f"{hook} requires `{OWN}{name}`, which has no default: "
                f"--set {OWN}{name}=…, in Python own={{{name!r}: …}}"
            )
