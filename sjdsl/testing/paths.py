"""Reads and sets the fields of a scene by name: `agent.bag[raw]`, `rock.ore`."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import World
from sjdsl.interpreter.stored import held_values
from sjdsl.interpreter.writes import with_entry
from sjdsl.near_names import meant
from sjdsl.testing.values import from_author, to_author

_PATH = re.compile(r"(?:(\w+)\.)?(\w+)((?:\[-?\w+\])*)")


@dataclass(frozen=True)
class FieldPath:
    """A field, or one entry of it: `keys` are the indices of the entry in a `by` field."""

    text: str
    declared: ir.VarField
    keys: tuple[int, ...]

    @property
    def entry_type(self) -> ir.Type:
        """The type of the field's values, or of that entry of them."""
        return self.declared.type.model_copy(
            update={"indexed_by": self.declared.type.indexed_by[len(self.keys) :]}
        )


def find_field(game: ir.Game, text: str) -> FieldPath:
    """Returns the field of a path.

    Args:
      text: `agent.NAME`, `KIND.NAME`, `SORT.NAME` (of movers) or `NAME` (of the world), perhaps
        with `[KEY]`.

    Raises:
      ValueError: there is no such field; the message has the nearest name.
    """
    match = _PATH.fullmatch(text.strip())
    owner, name, brackets = match.groups() if match else (None, text, "")
    owners = {"agent": game.agents.fields}
    owners |= {kind.name: kind.fields for kind in game.kinds}
    owners |= {movers.name: movers.fields for movers in game.movers}
    if owner is not None and owner not in owners:
        raise ValueError(f"`{text}`: the game has no `{owner}`{meant(owner, owners)}")
    fields = owners[owner] if owner else game.fields
    declared = next((field for field in fields if field.name == name), None)
    if declared is None:
        raise ValueError(f"`{text}`: {_no_field(owner, name, owners, game.fields)}")
    keys = re.findall(r"-?\w+", brackets)
    index_sets = declared.type.indexed_by
    if len(keys) > len(index_sets):
        indices = (
            f"has {len(index_sets)} indices" if index_sets else "is one value, without an index"
        )
        raise ValueError(f"`{text}`: `{name}` {indices}")
    indices_of_keys = []
    for key, index_set in zip(keys, index_sets[: len(keys)], strict=True):
        if key not in index_set.keys:
            raise ValueError(f"`{text}`: there is no entry `{key}`{meant(key, index_set.keys)}")
        indices_of_keys.append(index_set.keys.index(key))
    return FieldPath(text, declared, tuple(indices_of_keys))


def _no_field(
    owner: str | None,
    name: str,
    owners: dict[str, tuple[ir.VarField, ...]],
    world: tuple[ir.VarField, ...],
) -> str:
    """Returns a message about a field that doesn't exist."""
    if owner:
        names = [field.name for field in owners[owner]]
        return f"`{owner}` has no field `{name}`{meant(name, names)}"
    paths = [field.name for field in world]
    for other, fields in owners.items():
        paths += [f"{other}.{field.name}" for field in fields]
    return f"the game has no field `{name}`{meant(name, paths)}"


def _entry(value: Any, keys: tuple[int, ...]) -> Any:
    """Returns an entry of nested tuples."""
    for key in keys:
        value = value[key]
    return value


def owners_of(path: FieldPath, board: Board) -> list[Any] | None:
    """Returns the owners of the values of a field; None for the world.

    They are numbers of agents or movers, or (row, column) of cells.
    """
    owner = path.declared.held_by
    match owner.what:
        case "agent":
            return list(range(board.agents))
        case "mover":
            numbers = {movers.name: movers.number for movers in board.game.movers}
            return list(range(numbers[owner.name]))
        case "cell":
            return [tuple(cell) for cell in board.cells[owner.name]]
        case _:
            return None


def read_field(path: FieldPath, world: World) -> Any:
    """Returns the values of a field as authors write them.

    They are a list over agents, movers or cells, or the world's one value.
    """
    values = held_values(path.declared, world)
    if path.declared.held_by.what == "world":
        return to_author(_entry(values, path.keys), path.entry_type)
    return [to_author(_entry(value, path.keys), path.entry_type) for value in values]


def write_field(path: FieldPath, values: Any, board: Board, world: World) -> None:
    """Sets a field.

    Args:
      values: the world's value; else a list over agents, movers or cells, a mapping of some of
        them, or one value for all.
    Raises:
      ValueError: an agent, mover or cell that doesn't exist, or a value that doesn't fit.
    """
    current = held_values(path.declared, world)
    owners = owners_of(path, board)
    if owners is None:
        world.fields[path.declared.name] = _updated(path, path.text, values, current, board)
        return
    for owner, value in by_owner(path.text, values, owners).items():
        number = owners.index(owner)
        name = f"{path.text} of {owner}"
        current[number] = _updated(path, name, value, current[number], board)


def _updated(path: FieldPath, name: str, value: Any, current: Any, board: Board) -> Any:
    """Returns the current value of a field with the entry of `path` set to a written value."""
    entry = from_author(name, value, path.entry_type, board.agents, _entry(current, path.keys))
    return with_entry(current, path.keys, entry)


def by_owner(name: str, values: Any, owners: list[Any]) -> dict[Any, Any]:
    """Returns owner -> value, for those of a mapping or for all.

    Args:
      values: a list in the order of the owners, a mapping by owner, or one value for all.
    """
    if isinstance(values, list | tuple):
        if len(values) != len(owners):
            raise ValueError(
                f"`{name}`: {len(values)} values are given, there are {len(owners)}; "
                "give some as a mapping"
            )
        return dict(zip(owners, values, strict=True))
    if not isinstance(values, Mapping):
        return dict.fromkeys(owners, values)
    if values and all(isinstance(key, str) for key in values):  # words: the entries of one row
        return dict.fromkeys(owners, values)
    for owner in values:
        if owner not in owners:
            listed = ", ".join(map(str, owners[:6]))
            others = ", …" if len(owners) > 6 else ""
            raise ValueError(f"`{name}`: {owner} is none of {listed}{others}")
    return dict(values)
