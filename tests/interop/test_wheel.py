"""The adapters as the wheel has them: from an empty folder, each makes a game; without its library, each says what to install."""

from pathlib import Path

import pytest

from tests.packaging.installed import GAME, installed, run_in, source, wheel

__all__ = ["installed", "source", "wheel"]  # fixtures

MADE = {
    "jaxmarl": "JaxMARLGame('{}')",
    "socialjax": "make('coin_game')",
    "pettingzoo": "parallel_env('{}')",
    "gymnasium": "VectorGame('{}', 2)",
    "stable_baselines3": "VecGame('{}', 2)",
    "dm_env": "Substrate('{}', seed=0)",
}
EXTRAS = {
    "jaxmarl": "jaxmarl",
    "pettingzoo": "pettingzoo",
    "gymnasium": "gymnasium",
    "stable_baselines3": "sb3",
    "dm_env": "dm_env",
}


def test_adapters_work_in_an_empty_folder(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "my_game.sj").write_text(GAME)
    lines = ["import sjdsl", "assert 'site-packages' in sjdsl.__file__"]
    for adapter, call in MADE.items():
        lines += [
            f"import sjdsl.interop.{adapter} as {adapter}",
            f"{adapter}.{call.format('my_game.sj')}",
        ]
    run_in(installed / "empty/bin/python", "-c", "\n".join(lines), cwd=tmp_path)


@pytest.mark.parametrize(("adapter", "extra"), EXTRAS.items())
def test_what_is_missing_is_said_in_one_line(
    installed: Path, tmp_path: Path, adapter: str, extra: str
) -> None:
    use = f"import sys\nsys.modules['{adapter}'] = None\ntry:\n    import sjdsl.interop.{adapter}\nexcept ModuleNotFoundError as error:\n    print(error)"
    said = run_in(installed / "empty/bin/python", "-c", use, cwd=tmp_path).strip()
    assert said.endswith(f"is needed: pip install 'sjdsl[{extra}]'"), said
    assert "\n" not in said
