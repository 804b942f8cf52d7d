"""Emits a standalone module that needs only JAX and NumPy: it contains the kernels it calls."""

import ast
from functools import cache
from importlib.resources import files

from sjdsl.compiler.emit.module import body, docstring, kernels, template
from sjdsl.compiler.program import Program

RUNTIME = "sjdsl.runtime"
ENVIRONMENT = "env"  # of which the environment at the end of the file is one


def standalone(program: Program) -> str:
    """Returns the file."""
    called = {
        module.removeprefix(f"{RUNTIME}."): names for module, names in kernels(program).items()
    }
    return template("standalone.py.j2").render(
        docstring=docstring(program),
        kernels=[(name, _kernel(name)[0]) for name in _in_order((*called, ENVIRONMENT))],
        names=[(module, name) for module, names in called.items() for name in names],
        module=body(program).strip("\n"),
    )


@cache
def _kernel(name: str) -> tuple[list[str], list[str]]:
    """Returns a module of the runtime as the body of a function, and which others it calls.

    The function looks the others up in their scopes.
    """
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
    return [f"    {line}".rstrip() for line in lines], called


def _in_order(names: tuple[str, ...]) -> list[str]:
    """Returns the modules and those they call, callees first."""
    order: list[str] = []

    def visit(name: str) -> None:
        if name not in order:
            for called in _kernel(name)[1]:
                visit(called)
            order.append(name)

    for name in sorted(set(names)):
        visit(name)
    return order
