"""Lazy imports: public names of a package are imported on first use, so that nothing waits for JAX without need."""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def lazy_names(package: str, names: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """Returns the `__getattr__` of a package (PEP 562), which raises AttributeError for all other names; sets its `__all__` and `__dir__`.

    Args:
      package: its `__name__`.
      names: the public names of each module inside the package: `{"factory": ("make",)}`.
    """
    homes = {name: module for module, own in names.items() for name in own}

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{homes[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    here = vars(sys.modules[package])
    here["__all__"] = sorted(homes)
    here["__dir__"] = lambda: sorted({*here, *homes})
    return load
