"""Answers what the page asks about files, for the server and for the studio without one; FileRefused says what cannot be done."""

from typing import Any

from sjdsl.studio import tour
from sjdsl.studio.examples import copy_beside, examples, packages, place_of
from sjdsl.studio.folder import FileRefused, Folder

Answer = dict[str, Any]


def listed(folder: Folder) -> Answer:
    """Returns the games that can be opened: the folder's own, the bundled ones, those of installed packages, and those of the tour."""
    return {"games": folder.games(), "examples": examples(), "packages": packages(), "tour": tour.games()}


def read(folder: Folder, named: str) -> Answer:
    """Returns the text of a file of the folder, of an example or of the tour, with its digest, and its URI for the language server."""
    place, path = place_of(named, folder.root)
    text, digest = Folder(place).read(path)
    return {"text": text, "digest": digest, "uri": (place / path).as_uri()}


def write(folder: Folder, given: Answer) -> Answer:
    """Writes `text` as the file `path`. Raises Changed if the file no longer has the `digest` of which the page knows."""
    return {"digest": folder.write(str(given["path"]), str(given["text"]), given.get("digest"))}


def copy(folder: Folder, given: Answer) -> Answer:
    """Writes the text of an example, as it has been changed, as a new file, with the files that it needs."""
    if folder.inside(str(given["path"])).exists():
        raise FileRefused(f"there is a file `{given['path']}` already: choose another name")
    copied = copy_beside(str(given["example"]), folder)
    return {"digest": folder.write(str(given["path"]), str(given["text"]), None), "copied": copied}
