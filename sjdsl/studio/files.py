"""Answers what the page asks about files, for the server and for the studio without one."""

import json
from collections.abc import Mapping
from typing import Any

from sjdsl.studio import tour
from sjdsl.studio.examples import copy_beside, examples, new_game, place_of
from sjdsl.studio.folder import Changed, FileRefused, Folder

Answer = dict[str, Any]


def answered(
    folder: Folder, method: str, address: str, query: Mapping[str, str], body: str | bytes = ""
) -> tuple[int, Answer]:
    """Returns the HTTP status and the answer of a request; `refused` with the reason if it cannot be done."""
    try:
        given = json.loads(body or "{}")
    except (ValueError, RecursionError):
        given = None
    if not isinstance(given, dict):
        return 400, {"refused": "the request is no object of JSON"}
    try:
        return 200, _done(folder, method, address, query, given)
    except Changed as reason:
        return 409, {"refused": str(reason), "changed": True}
    except FileRefused as reason:
        return 404 if method == "GET" else 400, {"refused": str(reason)}
    except KeyError as missing:
        return 400, {"refused": f"the request has no {missing}"}
    except UnicodeEncodeError:
        return 400, {"refused": "the text has a character that no file can hold"}


def _done(
    folder: Folder, method: str, address: str, query: Mapping[str, str], given: Answer
) -> Answer:
    """Returns the answer. Raises FileRefused, KeyError for a field that is missing, and UnicodeEncodeError."""
    match method, address:
        case (
            "GET",
            "/games",
        ):  # those that can be opened: the folder's own, the bundled ones, and those of the tour
            return {"games": folder.games(), "examples": examples(), "tour": tour.games()}
        case "GET", "/tour":
            return {"steps": tour.steps()}
        case (
            "GET",
            "/file",
        ):  # of the folder, of an example or of the tour; its URI is for the language server
            place, path = place_of(query["path"], folder.root)
            text, digest = Folder(place).read(path)
            return {"text": text, "digest": digest, "uri": (place / path).as_uri()}
        case "PUT", "/file":
            return {
                "digest": folder.write(str(given["path"]), str(given["text"]), given.get("digest"))
            }
        case (
            "POST",
            "/copy",
        ):  # the text of an example, as it has been changed, as a new file, with the files that it needs
            if folder.inside(str(given["path"])).exists():
                raise FileRefused(f"there is a file `{given['path']}` already: choose another name")
            copied = copy_beside(str(given["example"]), folder)
            return {
                "digest": folder.write(str(given["path"]), str(given["text"]), None),
                "copied": copied,
            }
        case (
            "POST",
            "/new",
        ):  # a game of the name that the file has: the starting one of `sjdsl new`, or a renamed copy of another
            made = new_game(str(given["path"]), str(given["like"]), folder)
            return {"digest": folder.read(str(given["path"]))[1], "copied": made}
        case _:
            raise FileRefused(f"there is no `{address}`")
