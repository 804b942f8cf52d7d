"""sjdsl: a compiler for sequential social dilemmas. A readable `.sj` file becomes a fast, jittable JAX environment."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names
from sjdsl.version import __version__

__all__ = ["CompileError", "Environment", "TokenPlane", "__version__", "make"]

if TYPE_CHECKING:
    from sjdsl.compiler.diagnostics.diagnostic import CompileError
    from sjdsl.library.factory import make
    from sjdsl.runtime.env import Environment
    from sjdsl.runtime.planes import TokenPlane

__getattr__ = lazy_names(
    __name__,
    {
        "CompileError": "compiler.diagnostics.diagnostic",
        "Environment": "runtime.env",
        "TokenPlane": "runtime.planes",
        "make": "library.factory",
    },
)
