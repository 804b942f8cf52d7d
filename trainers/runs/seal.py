"""Seals a finished folder with the digest of each file, so that damage is found before anything is read from it."""

import hashlib
from pathlib import Path

from sjdsl.files import read_json

from ..json_files import write_json

SEAL = "files.json"


def seal(folder: Path) -> None:
    """Writes the SHA-256 of every file of a folder into the folder. Raises OSError if the disk is full."""
    write_json(folder / SEAL, {"sha256": _digests(folder)})


def damage_of(folder: Path) -> str | None:
    """Returns the first file that has changed since the folder was sealed; None if none has, or the folder was never sealed."""
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
                found[path.relative_to(folder).as_posix()] = hashlib.file_digest(
                    file, "sha256"
                ).hexdigest()
    return found
