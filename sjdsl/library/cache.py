"""The cache on disk: generated modules, by rule hash and compiler version, and programs compiled by JAX."""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

from sjdsl.files import write_whole
from sjdsl.version import __version__


def cache_folder() -> Path | None:
    """Returns where generated modules are kept: `$SJDSL_CACHE`, else the user's cache folder; None for a user without a home."""
    given = os.environ.get("SJDSL_CACHE")
    if given:
        return Path(given)
    base = os.environ.get("XDG_CACHE_HOME")
    if base:
        return Path(base) / "sjdsl"
    try:
        return Path.home() / ".cache" / "sjdsl"
    except RuntimeError:  # HOME isn't set, and the system doesn't know the user
        return None


def cached_text(key: str, make: Callable[[], str]) -> tuple[str, str]:
    """Returns the module's text and the name of the file it is kept in.

    Two processes may write one entry at once: each writes a file of its own and renames it into place. A damaged entry is made
    again. No folder, or one that cannot be written to, means no cache, not an error.
    """
    name = f"{key}_{__version__}_{_compiler_digest()}.py"
    folder = cache_folder()
    if folder is None:
        return make(), name
    path = folder / name
    try:
        digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        if digest == f"# {hashlib.sha256(text.encode()).hexdigest()}":
            return text, str(path)
    except (OSError, UnicodeDecodeError):
        pass
    text = make()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, f"# {hashlib.sha256(text.encode()).hexdigest()}\n{text}")
    except OSError:
        pass
    return text, str(path)


def keep_programs() -> None:
    """Has JAX keep in the cache folder what it compiles in this process, for the next; to be called before JAX is imported.

    JAX's own variables go before: JAX_COMPILATION_CACHE_DIR names another folder, JAX_ENABLE_COMPILATION_CACHE=false keeps nothing. A
    folder that cannot be made, or a user without a home, means no cache. What is damaged in it JAX compiles again.
    """
    cache = cache_folder()
    if cache is None:
        return
    folder = cache / "programs"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return
    os.environ.setdefault("JAX_COMPILATION_CACHE_DIR", str(folder))


def _compiler_digest() -> str:
    """Returns 8 digits that change with the compiler's own sources, so that work on it never meets old entries."""
    folder = Path(__file__).parents[1]
    digest = hashlib.sha256()
    for path in sorted(
        [*(folder / "compiler").rglob("*.py"), *(folder / "compiler").rglob("*.j2")]
    ):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:8]
