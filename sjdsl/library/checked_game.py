"""Builds a checked game from the arguments of `sjdsl.make`, without JAX, which loads slowly."""

from collections.abc import Mapping
from dataclasses import replace
from importlib.resources.abc import Traversable
from os import PathLike
from pathlib import Path
from typing import Any

from sjdsl.compiler import Build, build_composition
from sjdsl.compiler.compose import compose
from sjdsl.compiler.diagnostics.diagnostic import CompileError
from sjdsl.compiler.diagnostics.problems import Problems
from sjdsl.compiler.diagnostics.source import Source, Span
from sjdsl.compiler.elaborate import Overrides
from sjdsl.compiler.elaborate.world_map import parse_file, row_spans
from sjdsl.compiler.syntax.read import read_source
from sjdsl.library.games_folder import find_game
from sjdsl.library.parameters import plain_number, split_sizes
from sjdsl.library.tasks import Tasks, with_tasks


def build_game(
    game: str | Path,
    variant: str | None = None,
    num_agents: int | None = None,
    params: Mapping[str, Any] | None = None,
    map: str | Path | tuple[str, ...] | None = None,
    placed_by_hand: bool = False,
    tasks: Tasks | None = None,
    split: str | None = None,
    problem: int | None = None,
) -> tuple[Build, dict[str, Any]]:
    """Returns a checked game and its run-time numbers.

    Args:
      placed_by_hand: whether a test puts agents and movers on the map, so that the map needs no
        cells to send them to. The other arguments, and the errors, are those of `sjdsl.make`.
    """
    _check_types(game, variant, params)
    source = read_source(find_game(game))
    composition = compose(source, split_variants(variant))
    num_agents = None if num_agents is None else plain_number(num_agents)
    sizes, run_time = split_sizes(*composition.number_names(), dict(params or {}))
    overrides = Overrides(sizes, num_agents, *map_rows(map, source), placed_by_hand)
    build = build_composition(composition, overrides)
    if num_agents is not None and build.game.agents.number != num_agents:
        raise ValueError(
            f"{num_agents} agents are asked for, but a size among the numbers says "
            f"{build.game.agents.number}"
        )
    return replace(build, game=with_tasks(build.game, tasks, split, problem)), run_time


def split_variants(text: str | None) -> tuple[str, ...]:
    """Returns the variants of `a+b`, left to right."""
    return tuple(text.split("+")) if text else ()


def _check_types(game: Any, variant: Any, params: Any) -> None:
    """Raises TypeError for an argument of `make` of a wrong type."""
    if isinstance(game, Traversable) and not isinstance(game, PathLike):
        raise TypeError(
            f"`{game}` is inside an archive, not a file on disk: unpack it, or open the folder of "
            "the game and its maps by `importlib.resources.as_file`"
        )
    if not isinstance(game, str | PathLike):
        raise TypeError(f"a game is a name or the path of a .sj file, not {game!r}")
    if not isinstance(variant, str | None):
        raise TypeError(
            f"a variant is a name, and several are `first+second`; it is not {variant!r}"
        )
    if params is not None and not isinstance(params, Mapping):
        raise TypeError(
            f"params is a mapping from names of numbers of the game to values, not {params!r}"
        )


def map_rows(
    map: str | Path | tuple[str, ...] | None, source: Source
) -> tuple[tuple[str, ...] | None, tuple[Span, ...]]:
    """Returns the rows of a map, with their spans.

    Args:
      map: the rows, or the file that has them.
      source: the game, for errors.

    Raises:
      TypeError, FileNotFoundError: it is neither. CompileError: the file can't be a map.
    """
    if map is None:
        return None, ()
    if isinstance(map, tuple | list):
        for row in map:
            if not isinstance(row, str):
                raise TypeError(f"a row of a map is a text, not {row!r}")
        return tuple(map), row_spans(map, "map")
    if not isinstance(map, str | PathLike):
        raise TypeError(f"a map is a text file or a tuple of its rows, not {map!r}")
    path = Path(map)
    if not path.exists():
        raise FileNotFoundError(f"there is no map file `{map}`")
    problems = Problems()
    rows, spans = parse_file(path, str(map), Span(source.name, 0, 0, 1, 1), problems)
    if problems.diagnostics:
        raise CompileError(problems.diagnostics)
    return rows, spans
