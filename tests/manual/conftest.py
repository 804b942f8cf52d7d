"""The manual's games as files."""

from pathlib import Path

import pytest

from .blocks import blocks, frames


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Returns a folder with the manual's games in files, for those that extend one."""
    path = tmp_path_factory.mktemp("manual")
    for name, text in frames().items():
        (path / f"{name}.sj").write_text(text, encoding="utf-8")
    for block in blocks():
        if "file" in block.info:
            (path / block.info["file"]).write_text(block.text, encoding="utf-8")
    return path
