"""Emits a standalone module that needs only JAX and NumPy: it contains the kernels it calls."""

import ast
from functools import cache
from importlib.resources import files
from typing import NamedTuple

from sjdsl.compiler.emit.module import body, docstring, kernels, template
from sjdsl.compiler.program import Program

RUNTIME = "sjdsl.runtime"
ENVIRONMENT = "env"  # of which the environment at the end of the file is one


def standalone(program: Program) -> str:
    """Returns the text of a Python file with the game, its environment and the kernels it calls."""
    names_by_module = {
        module.removeprefix(f"{RUNTIME}."): names for module, names in kernels(program).items()
    }
    modules = _with_called((*names_by_module, ENVIRONMENT))
    return template("standalone.py.j2").render(
        docstring=docstring(program),
        kernels=[(name, _kernel(name).lines) for name in modules],
        names=[(module, name) for module, names in names_by_module.items() for name in names],
        module=body(program).strip("\n"),
    )


class Kernel(NamedTuple):
    """A module of the runtime as the body of a function."""

    lines: list[str]
    called: list[str]  # the other modules that it looks up, in their scopes


@cache
def _kernel(name: str) -> Kernel:
    """Returns the module of the runtime with this name."""
    text = files(RUNTIME).joinpath(f"{name}.py").read_text(encoding="utf-8")
    lines = text.splitlines()
    called: list[str] = []
    for node in reversed(ast.parse(text).body):
        if not isinstance(node, ast.ImportFrom) or not (node.module or "").startswith(RUNTIME):
            continue
        scope = (node.module or "").removeprefix(RUNTIME).removeprefix(".")
        names = [alias.name for alias in node.names]
        prefix = f"_{scope}." if scope else "_"
        lines[node.lineno - 1 : node.end_lineno] = [f"{name} = {prefix}{name}" for name in names]
        called = [*([scope] if scope else names), *called]
    return Kernel([f"    {line}".rstrip() for line in lines], called)


def _with_called(names: tuple[str, ...]) -> list[str]:
    """Returns the modules and those they call, callees first."""
    order: list[str] = []

    def visit(name: str) -> None:
        if name not in order:
            for called in _kernel(name).called:
                visit(called)
            order.append(name)

    for name in sorted(set(names)):
        visit(name)
    return order
