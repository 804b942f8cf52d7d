"""Users' own settings, the table `own`: hooks take them by the names of their arguments."""

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from functools import partial
from inspect import Parameter, signature
from typing import Annotated, Any, Protocol

from pydantic import BeforeValidator, PlainSerializer

from sjdsl.near_names import meant

from .extensions import Kind, find

OWN = "own."  # prefix of such a setting on the command line, on an axis of a sweep, and in messages
FROM_TRAINERS = (
    "planes",
    "width",
    "dtype",
    "parent",
    "name",
)  # arguments of a network that trainers fill in
Value = bool | int | float | str


class Hooked(Protocol):
    """A configuration: it has hooks, and settings for them."""

    @property
    def hooks(
        self,
    ) -> Mapping[Kind, str]: ...  # names of the user's own algorithm, loss, network and reward
    @property
    def own(self) -> tuple[tuple[str, Value], ...]: ...


def _read_own(table: Any) -> Any:
    """Returns settings as pairs, sorted by name."""
    try:
        read = {name: _read_value(value) for name, value in dict(table).items()}
    except (TypeError, ValueError):
        read = {"": table}
    for name, value in read.items():
        if (
            not (isinstance(name, str) and name.isidentifier() and isinstance(value, Value))
            or value != value
            or value in (math.inf, -math.inf)
        ):
            raise ValueError("a table of numbers, texts, true or false, by name")
    return tuple(sorted(read.items()))


def _read_value(value: Any) -> Any:
    """Returns the value of a text from the command line; anything else unchanged."""
    if not isinstance(value, str):
        return value
    for read in (int, float):
        with suppress(ValueError):
            return read(value)
    return {"true": True, "false": False}.get(value, value)


Own = Annotated[tuple[tuple[str, Value], ...], BeforeValidator(_read_own), PlainSerializer(dict)]


def spread(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns settings with those of the table `own` listed as `own.NAME`; an `own.NAME` that is given directly wins."""
    own = values.get("own")
    if not isinstance(own, Mapping):
        return dict(values)
    return {f"{OWN}{name}": value for name, value in own.items()} | {
        name: value for name, value in values.items() if name != "own"
    }


def gathered(values: Mapping[str, Any]) -> dict[str, Any]:
    """Returns settings with those named `own.NAME` moved into the table `own`."""
    own = {name.removeprefix(OWN): value for name, value in values.items() if name.startswith(OWN)}
    return ({"own": own} if own else {}) | {
        name: value for name, value in values.items() if not name.startswith(OWN)
    }


def filled(kind: Kind, name: str, own: Iterable[tuple[str, Any]]) -> Any:
    """Returns the hook of a name, with the settings that it takes filled in."""
    hook = find(kind, name)
    taken = settings_of(kind, hook)
    return partial(hook, **{setting: value for setting, value in own if setting in taken})


def settings_of(kind: Kind, hook: Any) -> dict[str, Any]:
    """Returns the settings that a hook takes, with their defaults: its keyword-only arguments; of a network, all that trainers don't fill in."""
    try:
        arguments = signature(hook).parameters.values()
    except ValueError:  # some functions of extension modules have no signature
        return {}
    sorts = (
        (Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
        if kind == "network"
        else (Parameter.KEYWORD_ONLY,)
    )
    return {
        one.name: one.default
        for one in arguments
        if one.kind in sorts and one.name not in FROM_TRAINERS
    }


def taken_settings(config: Hooked) -> Iterator[tuple[str, Any, str]]:
    """Yields the settings that the hooks of a configuration take, with their defaults, and the hook in words; hooks are imported."""
    for kind, name in config.hooks.items():
        for setting, default in settings_of(kind, find(kind, name)).items():
            yield setting, default, f"the {kind} `{name}`"


def unread_own(config: Hooked) -> dict[str, str]:
    """Returns a message for each setting of `own` that no hook takes; hooks are imported."""
    taken = [setting for setting, _, _ in taken_settings(config)]
    hooks = " and ".join(f"the {kind} `{name}`" for kind, name in config.hooks.items())
    known = f"{hooks} has no keyword-only argument of that name"
    known = (
        known if hooks else "there is no algorithm, loss, network or reward of your own to take it"
    )
    unread = [setting for setting, _ in config.own if setting not in taken]
    return {
        setting: f"`{OWN}{setting}` does nothing: {known}{meant(setting, taken, 'the settings are')}"
        for setting in unread
    }


def missing_own(config: Hooked) -> Iterator[str]:
    """Yields a message for each setting that a hook requires and that isn't given."""
    given = dict(config.own)
    for setting, default, hook in taken_settings(config):
        if default is Parameter.empty and setting not in given:
            yield f"{hook} requires `{OWN}{setting}`, which has no default: --set {OWN}{setting}=…, in Python own={{{setting!r}: …}}"
