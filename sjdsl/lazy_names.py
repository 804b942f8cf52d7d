"""Lazy imports: a package's public names are imported on first use, as JAX loads slowly."""

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any


def lazy_names(package: str, names: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """Returns the `__getattr__` of a package (PEP 562), and sets its `__all__` and `__dir__`.

    Args:
      package: its `__name__`.
      names: module inside the package -> its public names: `{"factory": ("make",)}`.
    """
    modules = {name: module for module, public in names.items() for name in public}

    def load(name: str) -> Any:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{modules[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    variables = vars(sys.modules[package])
    variables["__all__"] = sorted(modules)
    variables["__dir__"] = lambda: sorted({*variables, *modules})
    return load
