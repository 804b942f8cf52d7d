"""sjdsl: a compiler for sequential social dilemmas. A readable `.sj` file becomes a fast, jittable JAX environment."""

from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"
__all__ = ["CompileError", "Environment", "TokenPlane", "__version__", "make"]

if TYPE_CHECKING:
    from sjdsl.compiler.diagnostics import CompileError
    from sjdsl.factory import make
    from sjdsl.runtime.env import Environment
    from sjdsl.runtime.planes import TokenPlane

_HOMES = {
    "CompileError": "sjdsl.compiler.diagnostics",
    "Environment": "sjdsl.runtime.env",
    "TokenPlane": "sjdsl.runtime.planes",
    "make": "sjdsl.factory",
}


def __getattr__(name: str) -> Any:
    """Loads public names when first used: `sjdsl check` needs no JAX."""
    if name not in _HOMES:
        raise AttributeError(f"module 'sjdsl' has no attribute {name!r}")
    from importlib import import_module

    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
