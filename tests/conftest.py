"""What tests of several folders share: strict JAX, programs compiled once, memory given back, and goldens that can be written anew."""

import ctypes
import functools
import gc
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import hypothesis
import jax
import pytest
from jax._src.interpreters import mlir
from jax.experimental.compilation_cache import compilation_cache

# Half the seconds of compiling, and the programs run as fast: two of XLA's ways to make fast programs that tests do not need.
QUICK_TO_COMPILE = "--xla_cpu_use_fusion_emitters=false --xla_cpu_parallel_codegen_split_count=1"
# The files that take longest, of which the workers take the first ones first: a long one that comes last keeps one of them waiting.
LONGEST = (
    "properties/test_games.py",
    "differential/test_equal.py",
    "sweeps/test_sweep.py",
    "trainers/test_ppo_update.py",
    "trainers/test_own_algorithms.py",
    "compiler/test_growth.py",
    "trainers/test_hooks.py",
    "properties/test_planted.py",
    "games/test_contract.py",
    "experiments/test_crossplay.py",
    "manual/test_manual.py",
    "cli/test_transcripts.py",
    "compiler/test_limits.py",
    "experiments/test_schelling.py",
    "runtime/test_splits.py",
    "trainers/test_memory_reads.py",
    "runtime/test_placing.py",
    "fuzz/test_found.py",
    "differential/test_on_numpy.py",
    "render/test_episodes.py",
    "trainers/test_vdn.py",
    "trainers/test_resuming.py",
    "runtime/test_environment.py",
    "studio/test_access.py",
    "trainers/test_train_run.py",
)
MUCH_MEMORY = 1_400_000_000  # bytes of a worker, beyond which it gives back what it can between files: a second, and all is compiled anew


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        help="write what goldens should be instead of comparing; read the diff before committing",
    )
    parser.addoption(
        "--thorough",
        action="store_true",
        help="the tests marked thorough, and no others: long ones of what other tests see in parts",
    )
    parser.addoption(
        "--play-seed",
        type=int,
        default=0,
        help="of the play that looks for deliberate faults in games",
    )
    parser.addoption(
        "--gpu-forms",
        action="store_true",
        help="programs as a GPU would have them, on this machine: the same values, slowly",
    )
    parser.addoption(
        "--all",
        action="store_true",
        help="also the tests marked slow and thorough, and everything compiled as users have it",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Saves time: workers, commands and later runs share what XLA has compiled, and it is compiled for few steps, not for speed.

    This comes before JAX's first computation: XLA reads its flags once.
    """
    folder = config.rootpath / ".pytest_cache" / "jax"
    settings: dict[str, object] = {
        "jax_compilation_cache_dir": str(folder),
        "jax_persistent_cache_min_compile_time_secs": 0.0,
    }
    if config.getoption("--all"):
        os.environ["SJDSL_ALL_TESTS"] = "1"  # what is made while tests are collected looks for it
    else:
        settings["jax_disable_most_optimizations"] = True
        os.environ["XLA_FLAGS"] = f"{os.environ.get('XLA_FLAGS', '')} {QUICK_TO_COMPILE}".strip()
    # Each program is lowered in an MLIR context of its own, which takes half the time of a small program.
    mlir.make_ir_context = functools.cache(mlir.make_ir_context)
    for name, value in settings.items():
        os.environ[name.upper()] = str(value)
        jax.config.update(name, value)
    if not (config.getoption("--all") or config.getoption("--thorough")):
        hypothesis.settings.register_profile(
            "repeatable", derandomize=True
        )  # one commit, one verdict; the thorough runs draw new examples
        hypothesis.settings.load_profile("repeatable")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Puts the longest files first; leaves out the slow tests, and the thorough ones or all others, unless all are asked for or one is named."""
    rank = {config.rootpath / "tests" / name: number for number, name in enumerate(LONGEST)}
    items.sort(key=lambda item: rank.get(item.path, len(rank)))
    if config.getoption("--all"):
        return
    thorough, named = (
        config.getoption("--thorough"),
        any("::" in argument for argument in config.args),
    )

    def is_wanted(item: pytest.Item) -> bool:
        return not item.get_closest_marker("slow") and (
            named or thorough == bool(item.get_closest_marker("thorough"))
        )

    config.hook.pytest_deselected(items=[item for item in items if not is_wanted(item)])
    items[:] = [item for item in items if is_wanted(item)]


def pytest_collection_finish() -> None:
    """Spares the collector of garbage what is there from now on to the end: packages and tests, most of what it would look through.

    It also comes more seldom: tracing and compiling make many objects, of which few are garbage, and each round looks through all.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(10_000, 10, 50)


@pytest.hookimpl(trylast=True)  # after the fixtures, which hold memory and settings
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Gives back the memory of compiled programs after a file, where there is much: other files seldom use the same ones.

    `sjdsl bench` has its process keep no programs; the files after it find and keep them again.
    """
    if nextitem is not None and nextitem.path == item.path:
        return
    if not jax.config.values["jax_enable_compilation_cache"]:
        jax.config.update("jax_enable_compilation_cache", True)
        compilation_cache.reset_cache()
    if _resident_bytes() > MUCH_MEMORY:
        jax.clear_caches()
        mlir.make_ir_context.cache_clear()
        gc.collect()
        if sys.platform == "linux":
            ctypes.CDLL(None).malloc_trim(0)  # else the C library keeps it


def _resident_bytes() -> int:
    """Returns the memory this process holds; 0 where the system does not say."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except OSError:
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")


@pytest.fixture(autouse=True)
def form_for_gpus(request: pytest.FixtureRequest) -> Iterator[None]:
    """Forces the forms of kernels for GPUs if `--gpu-forms` is given."""
    from sjdsl.runtime.forms import forced  # not before JAX has its settings

    with forced("gpu" if request.config.getoption("--gpu-forms") else forced.value):
        yield


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
def no_code_allowed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forgets the code that other tests have allowed in this process."""
    monkeypatch.setattr("sjdsl.trainers.settings.extensions._ALLOWED", set())


@pytest.fixture
def strict_jax() -> Iterator[None]:
    """Makes JAX raise where a typed key is consumed twice, where dtypes differ and where ranks differ."""
    with (
        jax.debug_key_reuse(True),
        jax.numpy_dtype_promotion("strict"),
        jax.numpy_rank_promotion("raise"),
    ):
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
