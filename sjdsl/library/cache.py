"""The cache on disk: generated modules, by rule hash and compiler version, and JAX's programs."""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from sjdsl.files import write_whole
from sjdsl.version import __version__


def cache_folder() -> Path | None:
    """Returns the folder of the cache: `$SJDSL_CACHE`, else in the user's cache folder.

    It is None for a user without a home.
    """
    folder = os.environ.get("SJDSL_CACHE")
    if folder:
        return Path(folder)
    base = os.environ.get("XDG_CACHE_HOME")
    if base:
        return Path(base) / "sjdsl"
    try:
        return Path.home() / ".cache" / "sjdsl"
    except RuntimeError:  # HOME isn't set, and the system doesn't know the user
        return None


def cached_text(key: str, build: Callable[[], str]) -> tuple[str, str]:
    """Returns the text of a module and the path of its file in the cache.

    Several processes may write one entry at once. A damaged entry is built again. If there is no
    folder, or it can't be written, nothing is cached.

    Args:
      build: returns the text if it isn't in the cache.
    """
    name = f"{key}_{__version__}_{_compiler_digest()}.py"
    folder = cache_folder()
    if folder is None:
        return build(), name
    path = folder / name
    try:
        digest, _, text = path.read_text(encoding="utf-8").partition("\n")
        if digest == f"# {hashlib.sha256(text.encode()).hexdigest()}":
            return text, str(path)
    except (OSError, UnicodeDecodeError):
        pass
    text = build()
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, f"# {hashlib.sha256(text.encode()).hexdigest()}\n{text}")
    return text, str(path)


def keep_programs() -> None:
    """Lets JAX cache what it compiles in this process; to be called before JAX is imported.

    JAX's own variables have priority: JAX_COMPILATION_CACHE_DIR names another folder,
    JAX_ENABLE_COMPILATION_CACHE=false turns the cache off. If the folder can't be made, nothing is
    cached. JAX compiles again what is damaged.
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
    """Returns 8 digits that change with the compiler's sources, so that old entries aren't used."""
    folder = Path(__file__).parents[1] / "compiler"
    digest = hashlib.sha256()
    for path in sorted([*folder.rglob("*.py"), *folder.rglob("*.j2")]):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:8]
