"""Writes the text of a page so that no reader finds half of it."""

from pathlib import Path

from sjdsl.files import write_whole


def write_text(path: Path, text: str) -> None:
    """Writes a text whole or not at all; its folder is made."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, text)
