"""Registers compiled games with JaxMARL: `jaxmarl.make("sjdsl/clean_up")`."""

from functools import wraps
from typing import Any

import jaxmarl
from jaxmarl import registration

from sjdsl.games_folder import bundled

PREFIX = "sjdsl/"


def register() -> None:
    """Lets `jaxmarl.make` make `sjdsl/NAME` with the arguments of `JaxMARLGame`; calling it again changes nothing.

    NAME is a bundled game, as `jaxmarl.registered_envs` lists them, or the path of a `.sj` file.
    """
    known = registration.registered_envs
    known.extend(name for name in (f"{PREFIX}{game}" for game in bundled()) if name not in known)
    theirs = registration.make
    if getattr(theirs, "makes_compiled_games", False):
        return

    @wraps(theirs)
    def make(env_id: str, **env_kwargs: Any) -> Any:
        if not env_id.startswith(PREFIX):
            return theirs(env_id, **env_kwargs)
        from sjdsl.interop.jaxmarl import JaxMARLGame

        return JaxMARLGame(env_id.removeprefix(PREFIX), **env_kwargs)

    make.makes_compiled_games = True  # type: ignore[attr-defined]
    registration.make = make
    jaxmarl.make = make
