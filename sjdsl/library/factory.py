"""`make`: creates an environment from the name of a game or a `.sj` file."""

import linecache
import os
from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache, partial
from pathlib import Path
from types import ModuleType
from typing import Any

import jax

from sjdsl.compiler import Build, compile_rules
from sjdsl.compiler.ir.hash import printed_digest
from sjdsl.library.cache import cached_text
from sjdsl.library.checked_game import build_game
from sjdsl.library.parameters import admitted_params, build_params
from sjdsl.runtime.env import Encoding, Environment


def make(
    game: str | Path,
    variant: str | None = None,
    num_agents: int | None = None,
    params: Mapping[str, Any] | None = None,
    map: str | Path | tuple[str, ...] | None = None,
    observation: Encoding = "tokens",
) -> Environment:
    """Returns the environment of a game.

    Args:
      game: the name of a bundled game, or a path to any `.sj` file.
      variant: a variant of the file; several, applied left to right, as `"a+b"`.
      num_agents: instead of the file's number; compile-time.
      params: numbers of the game by name. A `param` changes the environment's default `Params`; a `size` is compile-time.
      map: another map for the game's legend: a text file, or its rows.
      observation: `tokens` or `onehot`, uint8 both.
    Raises:
      CompileError: everything that is wrong with the file, each with its place. FileNotFoundError, ValueError, TypeError: the
        arguments. RuntimeError: the process was forked from one that had made an environment.
    """
    return environment_of(*build_game(game, variant, num_agents, params, map), observation)


def environment_of(
    made: Build, params: Mapping[str, Any], observation: Encoding = "tokens"
) -> Environment:
    """Returns the environment of a checked game with some parameters replaced. Raises CompileError, ValueError as `make` does."""
    if _jax_is_used_in not in (None, os.getpid()):
        raise RuntimeError(
            "this process was forked from one that uses JAX, where JAX would wait for ever: start processes by `spawn` or `forkserver`, "
            'such as gymnasium.make_vec(…, vectorization_mode="async", vector_kwargs={"context": "spawn"})'
        )
    text, file = cached_text(
        f"{made.game.name}_{printed_digest(made.game.rules)}", lambda: compile_rules(made)
    )
    module = load_module(text, file, made.game.name)
    admit = partial(admitted_params, made.game, module)
    return Environment(
        module, build_params(made.game, module, params), observation, made.game, admit
    )


class GeneratedModule(ModuleType):
    """A module of a game, which with its states and parameters can be copied and pickled: by its text."""

    def __init__(self, text: str, file: str, name: str) -> None:
        super().__init__(f"sjdsl.generated.{name}")
        self.__file__ = file
        self._made_of = text, file, name

    def __reduce__(self) -> tuple[Any, ...]:
        return load_module, self._made_of


def _value_of(module: ModuleType, kind: str, values: tuple[Any, ...]) -> Any:
    """Returns a state, parameters or an outcome of a game, as `pickle` reads them."""
    return getattr(module, kind)(*values)


_jax_is_used_in: int | None = None  # the process that loaded a module first


@lru_cache(maxsize=256)
def load_module(text: str, file: str, name: str) -> ModuleType:
    """Returns a generated module; its lines show in tracebacks. The same text is the same module: its states are of one type."""
    global _jax_is_used_in
    _jax_is_used_in = _jax_is_used_in or os.getpid()
    module = GeneratedModule(text, file, name)
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    with (
        jax.ensure_compile_time_eval()
    ):  # its tables are constants, also when a game is made while another function is traced
        exec(compile(text, file, "exec"), module.__dict__)

    def reduced(value: Any) -> tuple[Any, ...]:
        return _value_of, (
            module,
            type(value).__name__,
            tuple(getattr(value, field.name) for field in fields(value)),
        )

    for kind in ("Params", "State", "Outcome"):
        getattr(module, kind).__reduce__ = reduced
    return module
