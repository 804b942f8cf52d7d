"""Seals a finished folder with the digest of each of its files, so that damage is found before anybody reads what it holds."""

import hashlib
from pathlib import Path

from sjdsl.files import read_json

from .run_files import write_json

SEAL = "files.json"


def seal(folder: Path) -> None:
    """Writes the SHA-256 of every file of a folder beside them. Raises OSError when there is no room."""
    write_json(folder / SEAL, {"sha256": _digests(folder)})


def damage_of(folder: Path) -> str | None:
    """Returns the first file that is not as it was when the folder was sealed; None if all are, or the folder was never sealed."""
    path = folder / SEAL
    if not path.exists():
        return None
    try:
        written = dict(read_json(path)["sha256"])
    except (OSError, ValueError, KeyError, TypeError):
        return SEAL
    found = _digests(folder)
    return next((name for name in sorted(written) if found.get(name) != written[name]), None)


def _digests(folder: Path) -> dict[str, str]:
    """Returns the digests of the files by their paths in the folder."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != SEAL:
            with path.open("rb") as file:
                found[path.relative_to(folder).as_posix()] = hashlib.file_digest(file, "sha256").hexdigest()
    return found
