"""Trained policies in the folder of the studio: which there are, and whether one may be loaded. Needs no JAX."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sjdsl.files import read_json
from sjdsl.studio.folder import files_below
from sjdsl.trainers.policy_names import LARGEST_DESCRIPTION, UNTRAINED

SUFFIX, POLICIES = ".safetensors", "policies"
MOST = 200  # policies that are listed
DEEPEST = 8  # runs whose partners act by other runs


class PolicyRefused(Exception):
    """A trained policy cannot drive agents here; the text says why."""


@dataclass(frozen=True)
class Stored:
    """A stored policy. name: `RUN`, `RUN@best`, `RUN@120`, or a `.safetensors` file, inside the folder; game: it was trained on."""

    name: str
    game: str


def stored_policies(root: Path) -> list[Stored]:
    """Returns the policies in a folder and all below it, at most 200; of a run the last, the best, and those stored by number.

    Those whose description cannot be read are left out.
    """
    found: list[Stored] = []
    for file in files_below(root, SUFFIX):
        try:
            found.append(Stored(_policy_name(file, root), str(_description(file, root)["game"]["name"])))
        except (PolicyRefused, KeyError, TypeError):
            continue
        if len(found) >= MOST:
            break
    return sorted(found, key=lambda stored: stored.name)[:MOST]


def policy_file(root: Path, name: str, game: str, deep: int = DEEPEST) -> Path:
    """Returns the file of a policy by its name, as `Stored` has it, if it was trained on the game of that name.

    Raises PolicyRefused: it is outside the folder, or not there, or of another game; or to load it would run Python code that its run
    names, or read a policy outside the folder. deep: how many partners of partners are followed.
    """
    file = _file_of(root, name)
    described = _description(file, root)
    try:
        trained_on, config = str(described["game"]["name"]), dict(described["config"])
        partners = [str(policy) for _, policy in config.get("partners") or ()]
    except (KeyError, TypeError, ValueError):
        raise PolicyRefused(f"`{name}` does not say which game it was trained on: the file {file.stem}.json beside it is damaged") from None
    if trained_on != game:
        raise PolicyRefused(f"`{name}` was trained on the game `{trained_on}`, and this is `{game}`: choose a run of this game")
    own = next((thing for thing in (str(config.get("algorithm", "")), str(config.get("network", "")), *partners) if ":" in thing), None)
    if own is not None:
        raise PolicyRefused(
            f"`{name}` needs Python code of your own ({own}), which the studio does not run; `sjdsl play --others --allow-code` does"
        )
    for partner in partners:
        if partner not in UNTRAINED and (
            not partner.isidentifier() or any((at / partner).exists() for at in (root, Path()))
        ):  # else the file declares it
            if not deep:
                raise PolicyRefused(f"`{name}` has partners that have partners in turn, too many times")
            policy_file(root, _inside(root, partner), game, deep - 1)
    return file


def _inside(root: Path, name: str) -> str:
    """Returns the name of a partner, which runs have as a whole path, relative to the folder."""
    path, at, which = name.rpartition("@") if "@" in name else (name, "", "")
    place = Path(path).resolve() if Path(path).is_absolute() else (root / path).resolve()
    if not place.is_relative_to(root):
        raise PolicyRefused(f"a partner of this run, `{name}`, is outside the folder that the studio was started in")
    return f"{place.relative_to(root).as_posix()}{at}{which}"


def _file_of(root: Path, name: str) -> Path:
    before, at, which = name.rpartition("@")
    place = root / (before if at else name)
    if place.suffix != SUFFIX:
        numbered = at and which.isascii() and which.isdecimal()
        place = place / POLICIES / ((f"{int(which):08d}" if numbered else which if at else "last") + SUFFIX)
    try:
        file = place.resolve()
    except (OSError, RuntimeError, ValueError):
        raise PolicyRefused(f"`{name}` is no path") from None
    if not file.is_relative_to(root) or file.suffix != SUFFIX:
        raise PolicyRefused(f"`{name}` is outside the folder that the studio was started in: start it where both the game and the run are")
    try:
        there = file.is_file()
    except (OSError, ValueError):
        there = False
    if not there:
        near = [stored.name for stored in stored_policies(root)]
        listed = f"{', '.join(near[:5]) or 'none'}{', …' if len(near) > 5 else ''}"
        known = f"where there {'are' if len(near) > 1 else 'is'} {listed}"
        raise PolicyRefused(f"there is no policy `{name}`, neither in the game's file nor trained in this folder, {known}")
    return file


def _policy_name(file: Path, root: Path) -> str:
    inside = file.relative_to(root)
    if inside.parent.name != POLICIES or inside.parent.parent == Path():
        return inside.as_posix()
    run, which = inside.parent.parent.as_posix(), str(int(file.stem)) if file.stem.isdecimal() else file.stem
    return run if which == "last" else f"{run}@{which}"


def _description(file: Path, root: Path) -> Mapping[str, Any]:
    path = file.with_suffix(".json")
    try:
        if not path.resolve().is_relative_to(root) or not file.resolve().is_relative_to(root):
            raise PolicyRefused(f"`{file.name}` leads outside the folder that the studio was started in")
        found = read_json(path, LARGEST_DESCRIPTION)
    except (OSError, ValueError):
        raise PolicyRefused(f"`{path.name}` beside the policy cannot be read, or is too large to be its description") from None
    if not isinstance(found, dict):
        raise PolicyRefused(f"`{path.name}` is no description of a policy")
    return found
