"""The parameters that a text is written for: those of an environment, or a game's defaults."""

from typing import Any, Protocol

from sjdsl.compiler import ir
from sjdsl.compiler.ir.names import param_attribute
from sjdsl.told.phrases import shortest


class HasGame(Protocol):
    """What the text needs of an environment."""

    @property
    def game(self) -> Any: ...
    @property
    def params(self) -> Any: ...


def parameters_of(env: HasGame) -> dict[str, Any]:
    """Returns the parameters of an environment as Python's numbers, words and nested tuples."""
    return {
        param.name: _plain(getattr(env.params, param_attribute(param.name)).tolist(), param)
        for param in env.game.params
    }


def _plain(value: Any, param: ir.Param) -> Any:
    if isinstance(value, list):
        return tuple(_plain(entry, param) for entry in value)
    if param.type.kind == "word":
        return param.type.words[value]
    return shortest(value) if param.type.kind == "real" else value
