"""Names that may stand in generated code: checked, and clear of Python's own words."""

import keyword
import re

_IDENTIFIER = re.compile(r"[a-z_][a-z0-9_]*")
_TAKEN = {"replace"}  # a method of flax.struct dataclasses


def identifier(name: str) -> str:
    """Returns the name if it is an ASCII identifier; anything else is a bug of the compiler."""
    assert _IDENTIFIER.fullmatch(name), name
    return name


def param_attribute(name: str) -> str:
    """Returns the attribute of Params or Outcome for a name of the game: with `_` after a Python word."""
    return identifier(name) + ("_" if keyword.iskeyword(name) or name in _TAKEN else "")
