"""What is in the wheel, and that an sdist leads to the same wheel."""

import sys
import tarfile
from hashlib import sha256
from pathlib import Path
from zipfile import ZipFile

import pytest

from tests.packaging.installed import REPOSITORY, build_wheel, run_in

# Everything in these folders but Python's own files has to be there: a rule in pyproject.toml that misses one is found.
DATA = {"sjdsl": "sjdsl", "games": "sjdsl/games", "trainers": "sjdsl/trainers"}
NEEDED = (
    "sjdsl/py.typed",
    "sjdsl/grammar/sj.lark",
    "sjdsl/games/clean_up.sj",
    "sjdsl/games/maps/clean_up.txt",
    "sjdsl/games/meltingpot/territory_open.sj",
    "sjdsl/games/meltingpot/shared/edges.sj",
    "sjdsl/games/meltingpot/shared/endings.sj",
    "sjdsl/games/published.toml",
    "sjdsl/studio/page/studio.html",
    "sjdsl/studio/page/studio.js",
    "sjdsl/library/starter/game.sj.txt",
    "sjdsl/compiler/diagnostics/explain/SJ001.md",
)
TYPED = """
import sjdsl
from sjdsl.runtime.env import Environment

env: Environment = sjdsl.make("coins", num_agents=2)
number: int = env.num_agents
reveal_type(sjdsl.make)
wrong: str = env.num_agents
"""


def test_all_that_a_user_needs_is_there(wheel: Path) -> None:
    names = set(ZipFile(wheel).namelist())
    assert not set(NEEDED) - names
    ours = {
        f"{inside}/{file}"
        for folder, inside in DATA.items()
        for file in _files(REPOSITORY / folder)
    }
    assert not ours - names, "pyproject.toml has no rule for these"
    assert {name for name in names if ".dist-info/" not in name} <= ours, (
        "these are not in the tree"
    )


def test_the_metadata_lead_to_the_project(wheel: Path) -> None:
    archive = ZipFile(wheel)
    (name,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
    metadata = archive.read(name).decode()
    assert "Project-URL: Homepage, https://github.com/sjdsl/sjdsl" in metadata
    assert "Classifier: Typing :: Typed" in metadata
    assert "License-Expression: Apache-2.0" in metadata
    assert "# sjdsl" in metadata, "the description is the README"


@pytest.mark.thorough
def test_an_sdist_leads_to_the_same_wheel(source: Path, tmp_path: Path) -> None:
    direct = _hashes(build_wheel(source))
    make = "from setuptools.build_meta import build_sdist; build_sdist('dist')"
    run_in(sys.executable, "-c", make, cwd=source)
    (sdist,) = (source / "dist").glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter="data")
    (unpacked,) = tmp_path.iterdir()
    assert _hashes(build_wheel(unpacked)) == direct


@pytest.mark.thorough
def test_a_consumer_is_checked_against_our_types(installed: Path, tmp_path: Path) -> None:
    (tmp_path / "consumer.py").write_text(TYPED)
    python = installed / "empty/bin/python"
    check = "from mypy import api; print(api.run(['--strict', '--follow-imports', 'silent', 'consumer.py'])[0])"
    said = run_in(python, "-c", check, cwd=tmp_path)
    assert "missing library stubs or py.typed" not in said
    lines = [line for line in said.splitlines() if line.startswith("consumer.py")]
    assert len(lines) == 2, said
    assert "Revealed type" in lines[0]
    assert "sjdsl.runtime.env.Environment" in lines[0]
    assert (
        'Incompatible types in assignment (expression has type "int", variable has type "str")'
        in lines[1]
    )


def _files(folder: Path) -> set[str]:
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file()
        and path.suffix not in (".pyc", ".tables")
        and "__pycache__" not in path.parts
    }


def _hashes(wheel: Path) -> dict[str, str]:
    """Returns the contents of a wheel by name; times, which differ, are no part of them."""
    archive = ZipFile(wheel)
    return {name: sha256(archive.read(name)).hexdigest() for name in archive.namelist()}
