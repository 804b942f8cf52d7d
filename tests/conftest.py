"""What tests of several folders share: strict JAX, programs compiled once, and goldens that can be written anew."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import jax
import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden", action="store_true", help="write what goldens should be instead of comparing; read the diff before committing"
    )
    parser.addoption("--all", action="store_true", help="also the tests marked slow, and everything compiled as users have it")


def pytest_configure(config: pytest.Config) -> None:
    """Saves time: workers, commands and later runs share what XLA has compiled, and it is compiled for few steps, not for speed."""
    folder = config.rootpath / ".pytest_cache" / "jax"
    settings: dict[str, object] = {"jax_compilation_cache_dir": str(folder), "jax_persistent_cache_min_compile_time_secs": 0.3}
    if not config.getoption("--all"):
        settings["jax_disable_most_optimizations"] = True
    for name, value in settings.items():
        os.environ[name.upper()] = str(value)
        jax.config.update(name, value)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leaves the slow tests out unless all are asked for."""
    if config.getoption("--all"):
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    config.hook.pytest_deselected(items=slow)
    items[:] = [item for item in items if item not in slow]


@pytest.fixture(autouse=True)
def as_compiled(request: pytest.FixtureRequest) -> Iterator[None]:
    """Lets XLA optimise in tests that are marked so: those that run a program for longer than it takes to compile."""
    if request.config.getoption("--all") or not request.node.get_closest_marker("optimised"):
        yield
        return
    jax.config.update("jax_disable_most_optimizations", False)
    yield
    jax.config.update("jax_disable_most_optimizations", True)


@pytest.fixture
def strict_jax() -> Iterator[None]:
    """Makes JAX raise where a typed key is consumed twice, where dtypes differ and where ranks differ."""
    with jax.debug_key_reuse(True), jax.numpy_dtype_promotion("strict"), jax.numpy_rank_promotion("raise"):
        yield


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[Path, str], None]:
    """Returns a check that a text equals a stored file; with `--update-golden` it stores the text."""

    def check(path: Path, text: str) -> None:
        if request.config.getoption("--update-golden"):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            return
        assert path.is_file(), f"no golden {path.name}; write it with `pytest --update-golden`"
        assert text == path.read_text(encoding="utf-8")

    return check
