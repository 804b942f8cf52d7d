"""Lazy imports: public names of a package are imported on first use, so that nothing waits for JAX without need."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def lazy_names(package: str, homes: Mapping[str, str]) -> Callable[[str], Any]:
    """Returns the `__getattr__` of a package (PEP 562), which raises AttributeError for all other names; `dir` of it lists them from now on.

    Args:
      package: its `__name__`.
      homes: the module inside the package that each public name is from: `{"make": "factory"}`.
    """

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{homes[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    here = vars(sys.modules[package])
    here["__dir__"] = lambda: sorted({*here, *homes})
    return load
