"""`make`: creates an environment from the name of a game or a `.sj` file."""

import linecache
import os
from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache, partial
from os import PathLike
from pathlib import Path
from types import ModuleType
from typing import Any

import jax

from sjdsl.cache import cached_text
from sjdsl.compiler import Build, build_composition, compile_rules
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.elaborate.world_map import parse_file, row_spans
from sjdsl.compiler.ir.hash import printed_digest
from sjdsl.compiler.syntax.read import read_source
from sjdsl.games_folder import find_game
from sjdsl.parameters import admitted_params, build_params, plain_number, split_sizes
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
      game: the name of a bundled game or of one of an installed package (as `package:game` where several have the name), or a path to
        any `.sj` file.
      variant: a variant of the file; several, applied left to right, as `"a+b"`.
      num_agents: instead of the file's number; compile-time.
      params: numbers of the game by name. A `param` changes the environment's default `Params`; a `size` is compile-time.
      map: another map for the game's legend: a text file, or its rows.
      observation: `tokens` or `onehot`, uint8 both.
    Raises:
      CompileError: everything that is wrong with the file, each with its place. FileNotFoundError, ValueError, TypeError: the arguments, a
        name that several games have among them. RuntimeError: the process was forked from one that had made an environment.
    """
    return environment_of(*build_game(game, variant, num_agents, params, map), observation)


def build_game(
    game: str | Path,
    variant: str | None = None,
    num_agents: int | None = None,
    params: Mapping[str, Any] | None = None,
    map: str | Path | tuple[str, ...] | None = None,
    placed_by_hand: bool = False,
) -> tuple[Build, dict[str, Any]]:
    """Returns a checked game and its run-time numbers; arguments and errors as of `make`.

    `placed_by_hand`: a test puts agents and movers on the map, which needs no cells to send them to.
    """
    if _jax_is_used_in not in (None, os.getpid()):
        raise RuntimeError(
            "this process was forked from one that uses JAX, where JAX would wait for ever: start processes by `spawn` or `forkserver`, "
            'such as gymnasium.make_vec(…, vectorization_mode="async", vector_kwargs={"context": "spawn"})'
        )
    _check_types(game, variant, params)
    source = read_source(find_game(game))
    variants = () if not variant else tuple(variant.split("+"))
    composition = compose(source, variants)
    num_agents = None if num_agents is None else plain_number(num_agents)
    sizes, run_time = split_sizes(*composition.number_names(), dict(params or {}))
    made = build_composition(composition, Overrides(sizes, num_agents, *map_rows(map, source), placed_by_hand))
    if num_agents is not None and made.game.agents.number != num_agents:
        raise ValueError(f"num_agents={num_agents}, but a size in params says {made.game.agents.number}")
    return made, run_time


def _check_types(game: Any, variant: Any, params: Any) -> None:
    """Raises TypeError for an argument of `make` that cannot be meant."""
    if not isinstance(game, str | PathLike):
        raise TypeError(f"a game is a name or the path of a .sj file, not {game!r}")
    if not isinstance(variant, str | None):
        raise TypeError(f"a variant is a name, and several are `first+second`; it is not {variant!r}")
    if params is not None and not isinstance(params, Mapping):
        raise TypeError(f"params is a mapping from names of numbers of the game to values, not {params!r}")


def environment_of(made: Build, params: Mapping[str, Any], observation: Encoding = "tokens") -> Environment:
    """Returns the environment of a checked game with some parameters replaced. Raises CompileError, ValueError as `make` does."""
    text, file = cached_text(f"{made.game.name}_{printed_digest(made.game.rules)}", lambda: compile_rules(made))
    module = load_module(text, file, made.game.name)
    admit = partial(admitted_params, made.game, module)
    return Environment(module, build_params(made.game, module, params), observation, made.game, admit)


def map_rows(map: str | Path | tuple[str, ...] | None, source: Source) -> tuple[tuple[str, ...] | None, tuple[Span, ...]]:
    """Returns the rows of a map given by its file or by itself, and where they stand; the legend is asked later."""

    if map is None:
        return None, ()
    if isinstance(map, tuple | list):
        odd = [row for row in map if not isinstance(row, str)]
        if odd:
            raise TypeError(f"a row of a map is a text, not {odd[0]!r}")
        return tuple(map), row_spans(map, "map")
    if not isinstance(map, str | PathLike):
        raise TypeError(f"a map is a text file or a tuple of its rows, not {map!r}")
    path = Path(map)
    if not path.is_file():
        raise FileNotFoundError(f"there is no map file `{map}`")
    problems = Problems()
    rows, spans = parse_file(path, str(map), Span(source.name, 0, 0, 1, 1), problems)
    if problems.found:
        raise CompileError(problems.found)
    return rows, spans


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
    with jax.ensure_compile_time_eval():  # its tables are constants, also when a game is made while another function is traced
        exec(compile(text, file, "exec"), module.__dict__)

    def reduced(value: Any) -> tuple[Any, ...]:
        return _value_of, (module, type(value).__name__, tuple(getattr(value, field.name) for field in fields(value)))

    for kind in ("Params", "State", "Outcome"):
        getattr(module, kind).__reduce__ = reduced
    return module
