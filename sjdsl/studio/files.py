"""Answers requests about files, for the studio with and without a server."""

import json
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from sjdsl.library.titles import title_of
from sjdsl.studio import tour
from sjdsl.studio.examples import copy_beside, examples, new_game, place_of
from sjdsl.studio.folder import Changed, FileRefused, Folder

Answer = dict[str, Any]


def answer_request(
    folder: Folder, method: str, address: str, query: Mapping[str, str], body: str | bytes = ""
) -> tuple[int, Answer]:
    """Returns the HTTP status and the answer to a request; `refused` has the reason if it fails."""
    try:
        arguments = json.loads(body or "{}")
    except (ValueError, RecursionError):
        arguments = None
    if not isinstance(arguments, dict):
        return 400, {"refused": "the request is no object of JSON"}
    try:
        return 200, _answer(folder, method, address, query, arguments)
    except Changed as reason:
        return 409, {"refused": str(reason), "changed": True}
    except FileRefused as reason:
        return 404 if method == "GET" else 400, {"refused": str(reason)}
    except KeyError as missing:
        return 400, {"refused": f"the request has no {missing}"}
    except UnicodeEncodeError:
        return 400, {"refused": "the text has a character that no file can hold"}


def _answer(
    folder: Folder, method: str, address: str, query: Mapping[str, str], arguments: Answer
) -> Answer:
    """Returns the answer to a request.

    Raises FileRefused, KeyError for an argument that is missing, or UnicodeEncodeError.
    """
    match method, address:
        case "GET", "/games":
            games = {"games": folder.games(), "examples": examples(), "tour": tour.games()}
            return {**games, "titles": _titles(folder, [*chain(*games.values())])}
        case "GET", "/tour":
            return {"steps": tour.steps()}
        case "GET", "/file":
            home, path = place_of(query["path"], folder.root)
            file = Folder(home).read(path)
            uri = (home / path).as_uri()  # for the language server
            return {"text": file.text, "digest": file.digest, "uri": uri}
        case "PUT", "/file":
            path = str(arguments["path"])
            text = str(arguments["text"])
            return {"digest": folder.write(path, text, arguments.get("digest"))}
        case "POST", "/copy":  # an example, whose text has perhaps been changed, with its files
            path = str(arguments["path"])
            text = str(arguments["text"])
            if folder.path_of(path).exists():
                raise FileRefused(f"there is a file `{path}` already: choose another name")
            copied = copy_beside(str(arguments["example"]), folder)
            return {"digest": folder.write(path, text, None), "copied": copied}
        case "POST", "/new":
            path = str(arguments["path"])
            written = new_game(path, str(arguments["like"]), folder)
            return {"digest": folder.read(path).digest, "copied": written}
        case _:
            raise FileRefused(f"there is no `{address}`")


def _titles(folder: Folder, paths: Sequence[str]) -> dict[str, str]:
    """Returns the title of each game that can be read, "" for one without."""
    titles = {}
    for path in paths:
        home, name = place_of(path, folder.root)
        try:
            titles[path] = title_of(Folder(home).read(name).text)
        except FileRefused:
            continue
    return titles
