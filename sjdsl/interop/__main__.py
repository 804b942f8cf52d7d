"""`python -m sjdsl.interop SCRIPT [ARGUMENTS]`: runs an unchanged training script of SocialJax or JaxMARL with our games."""

import importlib.util
import re
import runpy
import sys
from collections.abc import Sequence
from pathlib import Path

import jax

from sjdsl.interop import socialjax_modules

USAGE = """usage: python -m sjdsl.interop SCRIPT [ARGUMENTS]

Runs a training script of SocialJax or JaxMARL with compiled games: `socialjax.make` makes ours, and
`jaxmarl.make` knows `sjdsl_clean_up` and the others.
The arguments are the script's own."""
ROOTS = ("algorithms", "baselines", "socialjax", "jaxmarl")  # folders at the root of a checkout, from which scripts import


def run_script(script: Path, arguments: Sequence[str]) -> None:
    """Runs a script as `python SCRIPT ARGUMENTS` would, with the checkout that holds it on the path.

    Some scripts call `jax.tree_map`, which JAX 0.6 removed; they get `jax.tree.map`.
    """
    folder = script.resolve().parent
    checkouts = [parent for parent in (folder, *folder.parents) if any((parent / name).is_dir() for name in ROOTS)]
    for place in (*checkouts[:1], folder):
        sys.path.insert(0, str(place))
    vars(jax).setdefault("tree_map", jax.tree.map)
    reason = socialjax_modules.stand_in()
    if reason is not None:
        print(f"note: the package socialjax can't be imported ({reason}); using our versions of its wrappers", file=sys.stderr)
    if importlib.util.find_spec("jaxmarl") is not None:
        importlib.import_module("sjdsl.interop.jaxmarl")  # registers the games
    sys.argv = [str(script), *map(_without_slash, arguments)]
    runpy.run_path(str(script), run_name="__main__")


def _without_slash(argument: str) -> str:
    """Returns an argument with JaxMARL's environment name `sjdsl/NAME` changed to `sjdsl_NAME`.

    Scripts put that name into the names of files written after training, where a slash would mean a missing folder.
    """
    given = re.fullmatch(r"(\+{0,2}(?:[\w.]+\.)?ENV_NAME=['\"]?)sjdsl/(.+)", argument)
    if given is None:
        return argument
    if "/" in given[2]:
        print(
            f"note: scripts may name files after {argument}: start the script in the folder of the game, with sjdsl_FILE.sj",
            file=sys.stderr,
        )
    return f"{given[1]}sjdsl_{given[2]}"


def main() -> int:
    """Returns the exit status: 2 if no existing script is named."""
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        print(USAGE)
        return 0 if len(sys.argv) > 1 else 2
    script = Path(sys.argv[1])
    if not script.is_file():
        print(f"there is no script {script}", file=sys.stderr)
        return 2
    run_script(script, sys.argv[2:])
    return 0


if __name__ == "__main__":
    sys.exit(main())
