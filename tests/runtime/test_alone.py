"""The runtime is the bottom layer: it imports nothing else of sjdsl, and playing a compiled game loads no compiler."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
WITHOUT_JAX = {
    "actions",
    "fields",
    "geometry",
    "planes",
}  # what the compiler may use: `sjdsl check` does not wait for JAX
LOADED = "import sys; print(*(name for name in sys.modules if name.split('.')[0] in ('sjdsl', 'flax', 'lark', 'pydantic', 'jax')))"


def imports(path: Path) -> set[str]:
    """Returns the modules of sjdsl that a file imports, anywhere in it."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name for name in found if name.split(".")[0] == "sjdsl"}


def modules_loaded(program: str, folder: Path) -> list[str]:
    """Returns the modules of some packages that a fresh process has loaded after a program."""
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\n{LOADED}"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split("\n")[-2].split()


@pytest.mark.parametrize(
    "path", sorted((ROOT / "sjdsl/runtime").glob("*.py")), ids=lambda path: path.stem
)
def test_it_imports_nothing_of_other_packages(path: Path) -> None:
    assert [name for name in sorted(imports(path)) if not name.startswith("sjdsl.runtime")] == []


def test_the_compiler_uses_what_needs_no_jax() -> None:
    used = {
        name
        for path in (ROOT / "sjdsl/compiler").rglob("*.py")
        for name in imports(path)
        if name.startswith("sjdsl.runtime.")
    }
    assert {name.split(".")[2] for name in used} <= WITHOUT_JAX
    loaded = modules_loaded(f"from sjdsl.runtime import {', '.join(sorted(WITHOUT_JAX))}", ROOT)
    assert "jax" not in loaded


PLAY = """
import jax
from sjdsl.runtime.env import Environment
from {module} import {name}
env = {make}
observation, state = env.reset(jax.random.key(0))
observation, state, reward, done, info = env.step(jax.random.key(1), state, [0] * env.num_agents)
print(env, env.state_vector(state).shape, sorted(info["events"]), env.roles, env.observation_shape, env.forbids_actions)
"""


@pytest.mark.thorough
def test_a_generated_module_plays_without_the_compiler() -> None:
    program = PLAY.format(
        module="generated", name="coins as game", make="Environment(game, game.default_params())"
    )
    loaded = modules_loaded(program, ROOT)
    assert "sjdsl.runtime.env" in loaded
    assert not [
        module for module in loaded if module.startswith(("sjdsl.compiler", "lark", "pydantic"))
    ]
