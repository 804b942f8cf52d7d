"""Writes the text of a page so that no reader finds half of it."""

import os
from pathlib import Path


def write_text(path: Path, text: str) -> None:
    """Writes a text whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(f"{path.name}.{os.getpid()}")
    unfinished.write_text(text, encoding="utf-8", newline="\n")
    os.replace(unfinished, path)
