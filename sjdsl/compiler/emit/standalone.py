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
    called = {module.removeprefix(f"{RUNTIME}."): names for module, names in kernels(program).items()}
    return template("standalone.py.j2").render(
        docstring=docstring(program),
        kernels=[(name, _kernel(name)) for name in _in_order((*called, ENVIRONMENT))],
        names=[(module, name) for module, names in called.items() for name in names],
        module=body(program).strip("\n"),
    )


@cache
def _source(name: str) -> tuple[str, tuple[str, ...]]:
    """Returns the text of a module of the runtime, and which others it calls."""
    text = files(RUNTIME).joinpath(f"{name}.py").read_text(encoding="utf-8")
    called = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module == RUNTIME:
            called += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{RUNTIME}."):
            called.append((node.module or "").removeprefix(f"{RUNTIME}."))
    return text, tuple(called)


def _in_order(names: tuple[str, ...]) -> list[str]:
    """Returns the modules and those they call, callees first."""
    order: list[str] = []

    def visit(name: str) -> None:
        if name not in order:
            for called in _source(name)[1]:
                visit(called)
            order.append(name)

    for name in sorted(set(names)):
        visit(name)
    return order


def _kernel(name: str) -> list[str]:
    """Returns a module of the runtime as the body of a function, where imports of others are looked up in their scopes."""
    lines = _source(name)[0].splitlines()
    for node in reversed(ast.parse("\n".join(lines)).body):
        if isinstance(node, ast.ImportFrom) and node.module == RUNTIME:
            lines[node.lineno - 1 : node.end_lineno] = [f"{alias.name} = _{alias.name}" for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{RUNTIME}."):
            scope = (node.module or "").removeprefix(f"{RUNTIME}.")
            lines[node.lineno - 1 : node.end_lineno] = [f"{alias.name} = _{scope}.{alias.name}" for alias in node.names]
    return [f"    {line}".rstrip() for line in lines]
