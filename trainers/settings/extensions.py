"""Extensions by users: their own algorithms, losses, networks, rewards, policies and callbacks.

Configurations hold their names. A name is a registered one, `FILE.py:NAME`, or
`package.module:NAME`. Objects that are passed in Python are registered under the place where they
are defined, so that another process finds them again if it can import that place.

A name in a file, as in the JSON of a policy, leads to code only if the caller has named that code
too: by `allow_code`, by `register`, or by using it in this process.
"""

import importlib
import importlib.util
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any, Literal, get_args

from .config_errors import ConfigError

Kind = Literal["algorithm", "callback", "loss", "network", "policy", "reward"]
Algorithm = Literal["ippo", "mappo", "vdn"]
RewardMode = Literal["individual", "common", "svo", "exchange", "inequity"]
NetworkKind = Literal["mlp", "cnn"]
# The built-in names of each kind of hook, which a configuration may replace by custom code.
BUILT_IN: Mapping[Kind, tuple[str, ...]] = {
    "algorithm": get_args(Algorithm),
    "loss": ("ppo",),
    "network": get_args(NetworkKind),
    "reward": get_args(RewardMode),
}

_REGISTERED: dict[tuple[Kind, str], Any] = {}
_ALLOWED: set[str] = set()  # names of code that the caller has allowed


class NotAllowed(ConfigError):
    """A file leads to code that the caller hasn't allowed."""


def register(kind: Kind, name: str, thing: object) -> None:
    """Gives an object a name, for `network`, `reward` and wherever a policy or a callback is named.

    Args:
      kind: `network`: a flax module, or a function that makes one, of tokens `[M, P, V, V]` uint8
        to features `[M, K]`; `reward`: `Step -> [N]` float32; `loss`: `(parameters, apply, batch,
        config) -> (loss, metrics)`, as `ppo_loss`; `algorithm`: `(env, config) -> Train`; `policy`:
        `(key, observation [N, P, V, V]) -> actions [N]`; `callback`: `Update -> None`.
      name: if it is taken, the new object replaces the old one.
    Raises:
      TypeError: the object can't be called.
      ValueError: the name is that of a built-in algorithm, loss, network or reward.
    """
    if name in BUILT_IN.get(kind, ()):
        raise ValueError(f"`{name}` is a built-in {kind}; register yours under another name")
    if not callable(thing) and not hasattr(thing, "act"):
        raise TypeError(f"{with_article(kind)} is a function, not {thing!r}")
    _REGISTERED[kind, name] = thing


def with_article(kind: Kind) -> str:
    """Returns a kind with its article."""
    return f"an {kind}" if kind == "algorithm" else f"a {kind}"


def short_name(name: str) -> str:
    """Returns a name without its file or module: `NAME` of `FILE.py:NAME`."""
    return name.rpartition(":")[2]


def name_of(kind: Kind, thing: Any) -> str:
    """Registers an object that is passed; returns its name, the place where it is defined."""
    module = getattr(thing, "__module__", "")
    place = f"{module}:{getattr(thing, '__qualname__', type(thing).__name__)}"
    name = place
    number = 1
    # Two lambdas of one line are different.
    while _REGISTERED.get((kind, name), thing) is not thing:
        number += 1
        name = f"{place}#{number}"
    _REGISTERED[kind, name] = thing
    return name


def absolute_name(kind: Kind, name: str) -> str:
    """Returns a name that works from every folder: files by their whole path."""
    return name if (kind, name) in _REGISTERED else _with_whole_path(name)


def _with_whole_path(name: str) -> str:
    """Returns `FILE.py:NAME` with the whole path of the file; any other name unchanged."""
    file = file_of(name)
    return name if file is None else f"{file.resolve()}:{name.rpartition(':')[2]}"


def allow_code(*names: str) -> None:
    """Allows stored policies and runs to load your own code, which then runs.

    Args:
      names: each `FILE.py:NAME` or `package.module:NAME`, as in the error message about a policy
        that needs it.
    Raises:
      ValueError: a name has another form.
    """
    for name in names:
        file, _, name_there = name.rpartition(":")
        if not file or not name_there:
            raise ValueError(
                f"`{name}` doesn't name code: it must be FILE.py:NAME or package.module:NAME"
            )
        _ALLOWED.add(_with_whole_path(name))


def allowed_code() -> tuple[str, ...]:
    """Returns what has been allowed, for another process to allow it too."""
    return tuple(sorted(_ALLOWED))


def require_allowed(kind: Kind, name: str, place: str) -> None:
    """Raises NotAllowed unless the caller has allowed the code that `place` names."""
    if ":" not in name or (kind, name) in _REGISTERED or _with_whole_path(name) in _ALLOWED:
        return
    raise NotAllowed(
        f"{place} names {with_article(kind)} of your own, `{name}`, and using it would run that code. "
        f"If you trust it, allow it: --allow-code {shlex.quote(name)}, "
        f"in Python sjdsl.trainers.allow_code({name!r})"
    )


def is_own(kind: Kind, name: str) -> bool:
    """Whether a text is the name of a user's own object, found or not."""
    return (kind, name) in _REGISTERED or ":" in name


def find(kind: Kind, name: str) -> Any:
    """Returns the object of a name that the caller passes, or that `require_allowed` has accepted.

    Raises:
      ConfigError: there is none.
    """
    if (kind, name) in _REGISTERED:
        return _REGISTERED[kind, name]
    file, colon, name_there = name.rpartition(":")
    if not colon:
        raise ConfigError(
            f"no {kind} is registered as `{name}`; register it, "
            f"sjdsl.trainers.register({kind!r}, {name!r}, …), or name its file"
        )
    thing: Any = _load(Path(file)) if file.endswith(".py") else _import(kind, file, name)
    for part in name_there.split("."):
        thing = getattr(thing, part, None)
    if thing is None:
        raise ConfigError(
            f"the {kind} `{name}` is not found: {file} has no `{name_there}`. If it was made in a "
            "function or an interactive session, register it again: "
            f"sjdsl.trainers.register({kind!r}, {name!r}, …)"
        )
    _ALLOWED.add(_with_whole_path(name))
    return thing


def file_of(name: str) -> Path | None:
    """Returns the file of a name `FILE.py:NAME`."""
    file, colon, _ = name.rpartition(":")
    return Path(file) if colon and file.endswith(".py") else None


def _load(path: Path) -> ModuleType:
    """Returns the module of a file, which runs only once."""
    if not path.is_file():
        raise ConfigError(f"{path} does not exist")
    name = f"sjdsl_own.{path.resolve()}"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    return sys.modules[name]


def _import(kind: Kind, module: str, name: str) -> ModuleType:
    """Returns a module. kind, name: of the object that is looked for, for the message."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise ConfigError(f"the {kind} `{name}` is not found: {error}") from None
