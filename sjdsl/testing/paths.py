"""Reads values of a scene by name: `agent.bag[raw]`, `rock.ore`, `reward`, `event eaten`, as the manual writes results."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sjdsl.compiler import ir
from sjdsl.interpreter.board import Board
from sjdsl.interpreter.state import World
from sjdsl.interpreter.stored import held_values
from sjdsl.near_names import meant
from sjdsl.testing.values import held, written

_PATH = re.compile(r"(?:(\w+)\.)?(\w+)((?:\[-?\w+\])*)")


@dataclass(frozen=True)
class FieldPath:
    """A field, or one entry of it: `keys` are places in the levels of a `by` field."""

    text: str
    declared: ir.VarField
    keys: tuple[int, ...]

    @property
    def entry_type(self) -> ir.Type:
        return self.declared.type.model_copy(update={"by": self.declared.type.by[len(self.keys) :]})


def find_field(game: ir.Game, text: str) -> FieldPath:
    """Returns the field of a path `agent.NAME`, `KIND.NAME`, `SORT.NAME` (of movers) or `NAME` (of the world), perhaps with `[word]`.

    Raises ValueError naming the nearest field.
    """
    match = _PATH.fullmatch(text.strip())
    owner, name, brackets = match.groups() if match else (None, text, "")
    kinds = {kind.name: kind.fields for kind in game.kinds} | {
        sort.name: sort.fields for sort in game.movers
    }
    owners = {"agent": game.agents.fields, **kinds}
    if owner is not None and owner not in owners:
        raise ValueError(f"`{text}`: the game has no `{owner}`{meant(owner, owners)}")
    declared = next((f for f in (owners[owner] if owner else game.fields) if f.name == name), None)
    if declared is None:
        raise ValueError(f"`{text}`: {_no_field(owner, name, owners, game.fields)}")
    keys, by = re.findall(r"-?\w+", brackets), declared.type.by
    if len(keys) > len(by):
        raise ValueError(
            f"`{text}`: `{name}` has {len(by)} indices"
            if by
            else f"`{text}`: `{name}` is one value, without an index"
        )
    places = []
    for key, level in zip(keys, by, strict=False):
        if key not in level.keys:
            raise ValueError(f"`{text}`: there is no entry `{key}`{meant(key, level.keys)}")
        places.append(level.keys.index(key))
    return FieldPath(text, declared, tuple(places))


def _no_field(
    owner: str | None,
    name: str,
    owners: dict[str, tuple[ir.VarField, ...]],
    world: tuple[ir.VarField, ...],
) -> str:
    if owner:
        names = [f.name for f in owners[owner]]
        return f"`{owner}` has no field `{name}`{meant(name, names)}"
    whole = [
        *(f.name for f in world),
        *(f"{o}.{f.name}" for o, fields in owners.items() for f in fields),
    ]
    return f"the game has no field `{name}`{meant(name, whole)}"


def _entry(value: Any, keys: tuple[int, ...]) -> Any:
    for key in keys:
        value = value[key]
    return value


def _replaced(value: Any, keys: tuple[int, ...], entry: Any) -> Any:
    """Returns a row, or a row of rows, with one entry replaced."""
    if not keys:
        return entry
    first, *rest = keys
    return (*value[:first], _replaced(value[first], tuple(rest), entry), *value[first + 1 :])


def owners_of(path: FieldPath, board: Board) -> list[Any] | None:
    """Returns what the values of a field belong to: numbers of agents or movers, (row, column) of cells; None for the world."""
    match path.declared.held_by.what:
        case "agent":
            return list(range(board.agents))
        case "mover":
            return list(
                range(
                    next(
                        sort.number
                        for sort in board.game.movers
                        if sort.name == path.declared.held_by.name
                    )
                )
            )
        case "cell":
            return [tuple(cell) for cell in board.cells[path.declared.held_by.name]]
        case _:
            return None


def read_field(path: FieldPath, world: World) -> Any:
    """Returns the values of a field as written: a list over agents or cells, or the world's one value."""
    values = held_values(path.declared, world)
    if path.declared.held_by.what == "world":
        return written(_entry(values, path.keys), path.entry_type)
    return [written(_entry(value, path.keys), path.entry_type) for value in values]


def write_field(path: FieldPath, given: Any, board: Board, world: World) -> None:
    """Sets a field. `given`: a list over agents or cells, a mapping of some of them, or one value for all; the world's value.

    Raises ValueError: an agent or cell that is not there, a value that does not fit.
    """
    values, owners = held_values(path.declared, world), owners_of(path, board)
    if owners is None:
        world.fields[path.declared.name] = _with_given(path, path.text, given, values, board)
        return
    for owner, value in by_owner(path.text, given, owners).items():
        number = owners.index(owner)
        values[number] = _with_given(path, f"{path.text} of {owner}", value, values[number], board)


def _with_given(path: FieldPath, name: str, given: Any, before: Any, board: Board) -> Any:
    return _replaced(
        before,
        path.keys,
        held(name, given, path.entry_type, board.agents, _entry(before, path.keys)),
    )


def by_owner(name: str, given: Any, owners: list[Any]) -> dict[Any, Any]:
    """Returns what is given for each agent or cell: of a list in order, of a mapping as it says, else the same for all."""
    if isinstance(given, list | tuple):
        if len(given) != len(owners):
            raise ValueError(
                f"`{name}`: {len(given)} values are given, there are {len(owners)}; give some as a mapping"
            )
        return dict(zip(owners, given, strict=True))
    if isinstance(given, Mapping) and not (given and all(isinstance(key, str) for key in given)):
        for owner in given:
            if owner not in owners:
                raise ValueError(f"`{name}`: {owner} is none of {_some(owners)}")
        return dict(given)
    return dict.fromkeys(owners, given)


def _some(owners: list[Any]) -> str:
    return ", ".join(map(str, owners[:6])) + (", …" if len(owners) > 6 else "")
