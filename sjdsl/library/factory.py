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
from sjdsl.library.tasks import Tasks, with_tasks
from sjdsl.runtime.env import Encoding, Environment


def make(
    game: str | Path,
    variant: str | None = None,
    num_agents: int | None = None,
    params: Mapping[str, Any] | None = None,
    map: str | Path | tuple[str, ...] | None = None,
    observation: Encoding = "tokens",
    tasks: Tasks | None = None,
    split: str | None = None,
    problem: int | None = None,
) -> Environment:
    """Returns the environment of a game.

    Args:
      game: the name of a bundled game, or a path to any `.sj` file.
      variant: a variant of the file; several, applied left to right, as `"a+b"`.
      num_agents: instead of the file's number; compile-time.
      params: numbers of the game by name. A `param` changes the environment's default `Params`; a
        `size` is compile-time.
      map: another map for the game's legend: a text file, or its rows.
      observation: `tokens` or `onehot`, both uint8.
      tasks: which tasks of the game are played: `"training"`, `"held_out"`, `"all"`, or the values
        of some fields, such as `{"main_hue": "red", "pay[red]": 3}`, all others being drawn. By
        default the training tasks, if the game has a split, else all.
      split: which tasks are held out, where the game has several splits.
      problem: plays one task, which the key of this number gives among those.

    Raises:
      CompileError: with every mistake in the file and its place.
      FileNotFoundError, ValueError, TypeError: an argument is wrong.
      RuntimeError: the process was forked from one that had made an environment.
    """
    build, run_time = build_game(
        game, variant, num_agents, params, map, tasks=tasks, split=split, problem=problem
    )
    return environment_of(build, run_time, observation)


def environment_of(
    build: Build, params: Mapping[str, Any], observation: Encoding = "tokens"
) -> Environment:
    """Returns the environment of a checked game with some params replaced.

    Raises CompileError, ValueError or RuntimeError as `make` does.
    """
    if _jax_is_used_in not in (None, os.getpid()):
        raise RuntimeError(
            "this process was forked from one that uses JAX, where JAX would wait for ever: start "
            "processes by `spawn` or `forkserver`, such as gymnasium.make_vec(…, "
            'vectorization_mode="async", vector_kwargs={"context": "spawn"})'
        )
    game = build.game
    key = f"{game.name}_{printed_digest(game.rules)}"
    text, file = cached_text(key, lambda: compile_rules(build))
    module = load_module(text, file, game.name)
    admit = partial(admitted_params, game, module)
    return Environment(module, build_params(game, module, params), observation, game, admit)


def with_other_tasks(env: Environment, tasks: Tasks, split: str | None = None) -> Environment:
    """Returns the same game with the same numbers, which plays other tasks.

    The arguments and the errors are those of `make`.
    """
    build = Build(with_tasks(env.game, tasks, split), (), {})
    other = environment_of(build, {}, env.observation)  # type: ignore[arg-type]
    numbers = {field.name: getattr(env.params, field.name) for field in fields(env.params)}
    return other.with_params(other.params.replace(**numbers))


class GeneratedModule(ModuleType):
    """The module of a game. It can be copied and pickled, as can its states and params."""

    def __init__(self, text: str, file: str, name: str) -> None:
        super().__init__(f"sjdsl.generated.{name}")
        self.__file__ = file
        self._load_arguments = text, file, name

    def __reduce__(self) -> tuple[Any, ...]:
        return load_module, self._load_arguments


def _unpickled(module: ModuleType, type_name: str, values: tuple[Any, ...]) -> Any:
    """Returns a state, params or an outcome of a game."""
    return getattr(module, type_name)(*values)


_jax_is_used_in: int | None = None  # the process that first loaded a module


@lru_cache(maxsize=256)
def load_module(text: str, file: str, name: str) -> ModuleType:
    """Returns a generated module, whose lines appear in tracebacks.

    One text is one module, so that its states have one type.
    """
    global _jax_is_used_in
    _jax_is_used_in = _jax_is_used_in or os.getpid()
    module = GeneratedModule(text, file, name)
    linecache.cache[file] = (len(text), None, text.splitlines(keepends=True), file)
    # Its tables have to be constants even if another function is being traced.
    with jax.ensure_compile_time_eval():
        exec(compile(text, file, "exec"), module.__dict__)

    def reduce(value: Any) -> tuple[Any, ...]:
        values = tuple(getattr(value, field.name) for field in fields(value))
        return _unpickled, (module, type(value).__name__, values)

    for type_name in ("Params", "State", "Outcome"):
        getattr(module, type_name).__reduce__ = reduce
    return module
