"""Results as JSON that can be read: lists of numbers in a line each."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sjdsl.files import write_whole
from sjdsl.trainers.run_files import plain

INNERMOST = re.compile(r"\[\n\s*([^\[\]{}]*?)\n\s*\]")  # strings of JSON hold no line breaks
BETWEEN = re.compile(r",\n\s*")


def write_compact_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes a JSON file whole or not at all; what is not finite becomes null."""
    text = json.dumps(plain(content), indent=1, allow_nan=False)
    write_whole(path, (INNERMOST.sub(_in_a_line, text) + "\n").encode())


def _in_a_line(found: re.Match[str]) -> str:
    return f"[{BETWEEN.sub(', ', found[1])}]"
