"""Writes down, beside the generated parser, of which grammar it is: `make tree-sitter` calls it, and a test compares.

python editors/tree-sitter-sj/record.py
"""

import hashlib
from pathlib import Path

FOLDER = Path(__file__).parent
RECORD = FOLDER / "src" / "SHA256SUMS"
FILES = ("grammar.js", "src/grammar.json", "src/node-types.json", "src/parser.c")


def digests() -> str:
    """Returns a line for each file, as `sha256sum` writes it."""
    return "".join(
        f"{hashlib.sha256((FOLDER / name).read_bytes()).hexdigest()}  {name}\n" for name in FILES
    )


if __name__ == "__main__":
    RECORD.write_text(digests(), encoding="utf-8")
