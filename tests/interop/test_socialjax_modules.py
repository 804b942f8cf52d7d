"""Which classes of spaces there are, and what `import socialjax` finds: with the suite's package, without it, and where it is broken."""

import importlib
import sys
from collections.abc import Iterator
from pathlib import Path

import jax.numpy as jnp
import pytest
from gymnax.environments import spaces as gymnax_spaces

from sjdsl.interop import socialjax, spaces
from sjdsl.interop.socialjax_modules import stand_in

SPACES = """
class Box:
    def __init__(self, low, high, shape, dtype=None):
        self.low, self.high, self.shape, self.dtype = low, high, shape, dtype

class Discrete:
    def __init__(self, num_categories, dtype="int64"):
        self.n, self.shape, self.dtype = num_categories, (), dtype
"""


@pytest.fixture
def suite(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Returns the folder of a package laid out like the suite's, which is forgotten afterwards."""
    package = tmp_path / "socialjax"
    for folder in ("environments", "wrappers"):
        (package / folder).mkdir(parents=True)
        (package / folder / "__init__.py").touch()
    (package / "__init__.py").write_text(
        "def make(env_id, **kwargs):\n    raise AssertionError('the suite made it')\n\nregistered_envs = []\n"
    )
    (package / "environments/spaces.py").write_text(SPACES)
    (package / "wrappers/baselines.py").write_text("class CTRolloutManager: pass\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield package
    forget()


@pytest.fixture
def no_suite() -> Iterator[None]:
    """Forgets what stood in for the suite."""
    forget()
    yield
    forget()


def forget() -> None:
    spaces.space_classes.cache_clear()
    for name in [name for name in sys.modules if name.split(".")[0] == "socialjax"]:
        del sys.modules[name]
    importlib.invalidate_caches()


def test_spaces_are_those_that_the_suite_tests_for(suite: Path) -> None:
    del suite
    spaces.space_classes.cache_clear()
    theirs = importlib.import_module("socialjax.environments.spaces")
    env = socialjax.make("coin_game")
    assert isinstance(env.observation_space()[0], theirs.Box) and isinstance(env.action_space(), theirs.Discrete)
    assert (env.observation_space()[0].shape, env.action_space().n, env.action_space().dtype) == ((11, 11, 14), 7, jnp.int32)
    assert env.observation_spaces == env.action_spaces == {}  # it fills them itself where they are empty


def test_without_it_they_are_gymnaxs_or_ours(no_suite: None, monkeypatch: pytest.MonkeyPatch) -> None:
    del no_suite
    env = socialjax.make("coin_game")
    assert isinstance(env.observation_space()[0], gymnax_spaces.Box) and isinstance(env.action_space(), gymnax_spaces.Discrete)
    monkeypatch.setattr(spaces, "ELSEWHERE", ("socialjax.environments.spaces",))
    spaces.space_classes.cache_clear()
    assert isinstance(env.action_space(), spaces.Discrete)


def test_the_suites_wrappers_stay(suite: Path) -> None:
    del suite
    assert stand_in() is None
    assert stand_in() is None
    package, wrappers = importlib.import_module("socialjax"), importlib.import_module("socialjax.wrappers.baselines")
    assert package.make("coin_game").num_agents == 2 and "clean_up" in package.registered_envs
    assert wrappers.CTRolloutManager is not socialjax.CTRolloutManager


def test_there_are_stand_ins_without_it(no_suite: None) -> None:
    del no_suite
    assert stand_in() is None
    assert stand_in() is None
    from socialjax.environments.spaces import Box, MultiDiscrete  # type: ignore[import-not-found]
    from socialjax.wrappers.baselines import CTRolloutManager, MAPPOWorldStateWrapper, SVOLogWrapper  # type: ignore[import-not-found]

    assert importlib.import_module("socialjax").make is socialjax.make
    assert (CTRolloutManager, MAPPOWorldStateWrapper, SVOLogWrapper) == (
        socialjax.CTRolloutManager,
        socialjax.MAPPOWorldStateWrapper,
        socialjax.SVOLogWrapper,
    )
    assert isinstance(socialjax.make("coin_game").observation_space()[0], Box) and MultiDiscrete is not None


def test_one_that_cannot_be_imported_is_passed_over(suite: Path) -> None:
    (suite / "environments/__init__.py").write_text("import jax\n\njax.tree_map_of_long_ago\n")
    (suite / "__init__.py").write_text("from socialjax.environments import spaces\n")
    spaces.space_classes.cache_clear()
    with pytest.warns(UserWarning, match="installed but cannot be imported .*tree_map_of_long_ago"):
        assert isinstance(socialjax.make("coin_game").action_space(), gymnax_spaces.Discrete)
    assert "tree_map_of_long_ago" in str(stand_in())
    assert importlib.import_module("socialjax").make is socialjax.make
