"""Imports go one way: in the compiler from later stages to earlier ones, nowhere in a circle, and inside functions only to save time."""

import ast
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

ROOT = Path(__file__).parents[1]
STAGES = [
    "diagnostics",
    "ast",
    "syntax",
    "compose",
    "ir",
    "elaborate",
    "checks",
    "program",
    "lower",
    "emit",
]
# What the compiler takes from outside: they import nothing of ours. The runtime lies below it; of it these need no JAX.
TABLES = {
    "sjdsl.files",
    "sjdsl.near_names",
    "sjdsl.runtime.actions",
    "sjdsl.runtime.fields",
    "sjdsl.runtime.geometry",
    "sjdsl.runtime.planes",
    "sjdsl.version",
}
# An import inside a function is for one thing: that its module loads without these, which take long to load or need not be installed.
HEAVY = {
    *("dm_env", "gymnasium", "jaxmarl", "pettingzoo"),
    *(
        "flax",
        "hypothesis",
        "jax",
        "jinja2",
        "lark",
        "matplotlib",
        "numpy",
        "PIL",
        "psutil",
        "pydantic",
        "pygls",
    ),
    *("resvg_py", "rich"),
}


def _modules() -> dict[str, Path]:
    """Returns every file of the package by the name it is imported by."""
    files = [
        *(ROOT / "sjdsl").rglob("*.py"),
        *(path for folder in ("games", "trainers") for path in (ROOT / folder).rglob("*.py")),
    ]
    named = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in files
    }
    return {
        name if name.startswith("sjdsl") else f"sjdsl.{name}": path for name, path in named.items()
    }


MODULES = _modules()


@cache
def homes(package: str) -> dict[str, str]:
    """Returns the modules that the names of a package are loaded from when they are first used (`lazy_names`)."""
    tree = ast.parse(MODULES[package].read_text("utf-8") if package in MODULES else "")
    calls = [
        n
        for n in ast.walk(tree)
        if isinstance(n, ast.Call) and isinstance(n.func, ast.Name) and n.func.id == "lazy_names"
    ]
    return {
        name: f"{package}.{home}"
        for call in calls
        for home, names in ast.literal_eval(call.args[1]).items()
        for name in names
    }


@cache
def imports(module: str) -> list[tuple[str, str]]:
    """Returns what a module imports, each with its way: `top`, `typing` (under TYPE_CHECKING) or `local` (inside a function)."""
    path = MODULES[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]

    def names(node: ast.AST) -> Iterator[str]:
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            around = (
                ".".join(package.split(".")[: len(package.split(".")) + 1 - node.level])
                if node.level
                else ""
            )
            base = ".".join(part for part in (around, node.module) if part)
            for name in (alias.name for alias in node.names):
                yield (
                    f"{base}.{name}" if f"{base}.{name}" in MODULES else homes(base).get(name, base)
                )

    def visit(node: ast.AST, way: str) -> Iterator[tuple[str, str]]:
        for child in (
            child for child in ast.iter_child_nodes(node) if not isinstance(child, ast.expr)
        ):
            inner = "local" if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef) else way
            if (
                isinstance(child, ast.If)
                and isinstance(child.test, ast.Name)
                and child.test.id == "TYPE_CHECKING"
            ):
                inner = "typing"
            yield from ((name, way) for name in names(child))
            yield from visit(child, inner)

    return list(visit(ast.parse(path.read_text("utf-8")), "top"))


@cache
def loaded(module: str) -> frozenset[str]:
    """Returns all that is loaded with a module of ours: modules of ours, their packages, and libraries by their first name."""
    found, waiting = set[str](), [module]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name if name in MODULES else name.split(".")[0])
            if name in MODULES:
                waiting += [other for other, way in imports(name) if way == "top"] + [
                    name.rpartition(".")[0]
                ] * ("." in name)
    return frozenset(found)


def _stage(module: str) -> int | None:
    parts = module.split(".")
    return (
        None
        if parts[:2] != ["sjdsl", "compiler"]
        else STAGES.index(parts[2])
        if len(parts) > 2
        else len(STAGES)
    )


def test_stages_import_earlier_ones() -> None:
    upwards = []
    for module in MODULES:
        own = _stage(module)
        for other in {
            name for name, _ in imports(module) if own is not None and name.split(".")[0] == "sjdsl"
        } - TABLES:
            there = _stage(other)
            if there is None or there > own:
                upwards.append(f"{module} -> {other}")
    assert sorted(upwards) == []
    assert [
        table
        for table in TABLES & MODULES.keys()
        if any(name.startswith("sjdsl") and name not in TABLES for name, _ in imports(table))
    ] == []


def test_the_interpreter_reads_the_typed_game_and_nothing_else() -> None:
    """It is what compiled games are compared with: nothing of lowering, of the runtime or of their tables decides what it does."""
    read = {
        name
        for module in MODULES
        if module.startswith("sjdsl.interpreter")
        for name, _ in imports(module)
        if name.startswith("sjdsl")
    }
    assert len(read) > 10
    assert [
        name
        for name in sorted(read)
        if not name.startswith(("sjdsl.interpreter", "sjdsl.compiler.ir"))
    ] == []
    own_meaning = {
        f"sjdsl.compiler.ir.{name}"
        for name in (
            "operations",
            "evaluate_constant",
            "ranges",
            "range_arithmetic",
            "implications",
        )
    }
    assert own_meaning <= MODULES.keys()
    assert read & own_meaning == set(), (
        "the interpreter has its own meaning of each operation: it is what the table is compared with"
    )


def test_no_imports_go_in_circles() -> None:
    graph = {
        module: {name for name, _ in imports(module) if name in MODULES and name != module}
        for module in MODULES
    }
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        raise AssertionError(" <- ".join(error.args[1])) from None


def test_imports_inside_functions_save_loading_time() -> None:
    needless = []
    for module in MODULES:
        already = loaded(module) & HEAVY
        for name in {name for name, way in imports(module) if way == "local" and name in MODULES}:
            if not loaded(name) & HEAVY - already:
                needless.append(f"{module} -> {name}")
    assert sorted(needless) == []


def test_names_that_packages_load_lazily_are_there() -> None:
    lazy = {
        f"{package}.{name}": home for package in MODULES for name, home in homes(package).items()
    }
    missing = [
        name
        for name, home in lazy.items()
        if not hasattr(import_module(home), name.rpartition(".")[2])
    ]
    assert len(lazy) > 20
    assert missing == []


def test_what_is_imported_is_there() -> None:
    absent = [
        f"{module} -> {name}"
        for module in MODULES
        for name, _ in imports(module)
        if name.split(".")[0] == "sjdsl"
    ]
    assert [line for line in absent if line.partition(" -> ")[2] not in MODULES] == []
