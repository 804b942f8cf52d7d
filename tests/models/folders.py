"""Folders of experiments in which models play."""

import json
from pathlib import Path


def timeless(folder: Path) -> dict[str, str]:
    """Returns the texts of all results by their names, without what a clock wrote."""
    texts = {}
    for path in sorted([*folder.rglob("*.json*"), *folder.rglob("*.csv")]):
        text = path.read_text()
        if path.suffix == ".jsonl":
            lines = [json.loads(line) for line in text.splitlines()]
            text = json.dumps([{**line, "seconds": 0, "time": ""} for line in lines])
        texts[str(path.relative_to(folder))] = text
    return texts


def recorded_calls(folder: Path) -> int:
    """Returns how many calls are on disk."""
    return sum(path.read_text().count("\n") for path in folder.rglob("agent_*.jsonl"))
