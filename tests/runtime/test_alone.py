"""The runtime is the bottom layer: it imports nothing else of sjdsl, and playing a compiled game loads no compiler."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import sjdsl
from sjdsl.cli import run

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


def test_no_compiler_is_loaded_with_it() -> None:
    loaded = modules_loaded(
        "from sjdsl.runtime import egocentric_windows, env, policy, returns, tokens", ROOT
    )
    assert "sjdsl.runtime.env" in loaded
    assert not [
        module for module in loaded if module.startswith(("sjdsl.compiler", "lark", "pydantic"))
    ]


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


@pytest.mark.thorough
def test_what_it_knows_of_its_game_is_what_the_rules_say(tmp_path: Path) -> None:
    """A file of its own and an environment of `make` give the same."""
    env = sjdsl.make("predator_prey")
    path = tmp_path / "alone.py"
    assert run(["compile", "--standalone", "predator_prey", "-o", str(path)]) == 0
    facts = "print(repr((env.name, env.title, env.hash, env.num_actions, env.roles, env.observation_shape, env.forbids_actions)))"
    facts += "; print(jax.jit(lambda key: env.state_vector(env.reset(key)[1]))(jax.random.key(0)).tolist())"
    hidden = "import sys; sys.modules.update(dict.fromkeys(('sjdsl', 'flax', 'lark', 'pydantic', 'jinja2')))"
    program = f"{hidden}\nimport jax, alone\nenv = alone.Environment()\n{facts}"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    first, second = done.stdout.splitlines()
    import jax

    own = (
        env.name,
        env.title,
        env.hash,
        env.num_actions,
        env.roles,
        env.observation_shape,
        env.forbids_actions,
    )
    assert ast.literal_eval(first) == own
    assert (
        ast.literal_eval(second)
        == jax.jit(lambda key: env.state_vector(env.reset(key)[1]))(jax.random.key(0)).tolist()
    )
    game = env.game
    assert own[5][2:] == (
        game.window.ahead + 1 + game.window.behind,
        game.window.left + 1 + game.window.right,
    )
    assert env.roles is not None
