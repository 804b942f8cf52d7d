"""Lazy imports: public names of a package are imported on first use, so that nothing waits for JAX without need."""

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any


def lazy_names(package: str) -> Callable[[str], Any]:
    """Returns the `__getattr__` of a package (PEP 562), whose `__init__.py` imports names `if TYPE_CHECKING`: each is imported on first use.

    It raises AttributeError for all other names; `dir` of the package lists them from now on.

    Args:
      package: its `__name__`.
    """
    here = vars(sys.modules[package])
    text = Path(here["__file__"]).read_text(encoding="utf-8")
    (block,) = (node for node in ast.parse(text).body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    homes = {alias.name: f"{'.' * node.level}{node.module}" for node in imports for alias in node.names}

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(homes[name], package), name)
        setattr(sys.modules[package], name, value)
        return value

    here["__dir__"] = lambda: sorted({*here, *homes})
    return load
