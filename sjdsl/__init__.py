"""sjdsl, a compiler for sequential social dilemmas: from a `.sj` file to a JAX environment."""

from typing import TYPE_CHECKING

from sjdsl.lazy_names import lazy_names
from sjdsl.version import __version__ as __version__

if TYPE_CHECKING:
    from sjdsl.compiler.diagnostics.diagnostic import CompileError as CompileError
    from sjdsl.library.factory import make as make
    from sjdsl.runtime.env import Environment as Environment
    from sjdsl.runtime.planes import TokenPlane as TokenPlane

__getattr__ = lazy_names(
    __name__,
    {
        "compiler.diagnostics.diagnostic": ("CompileError",),
        "library.factory": ("make",),
        "runtime.env": ("Environment",),
        "runtime.planes": ("TokenPlane",),
    },
)
