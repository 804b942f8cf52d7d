"""The versions of the site beside each other: which one is shown first, on a branch of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
VERSION = '[{"version": "0.1", "title": "0.1", "aliases": ["latest"]}]'


def git(folder: Path, *words: str, given: str = "") -> str:
    """Returns what git says in a folder."""
    who = {
        f"GIT_{role}_{what}": text
        for role in ("AUTHOR", "COMMITTER")
        for what, text in (("NAME", "n"), ("EMAIL", "n@example.org"))
    }
    done = subprocess.run(
        ["git", "-C", folder, *words],
        input=given,
        env=os.environ | who,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.strip()


def test_the_first_page_leads_to_the_latest_version(tmp_path: Path) -> None:
    """`mike set-default`, as `make site-version` runs it, in a repository that has one version and a remote."""
    remote, here = tmp_path / "remote.git", tmp_path / "here"
    git(tmp_path, "init", "-q", "--bare", str(remote))
    git(tmp_path, "init", "-q", str(here))
    git(here, "remote", "add", "origin", str(remote))
    git(here, "config", "user.name", "n")
    git(here, "config", "user.email", "n@example.org")
    file = git(here, "hash-object", "-w", "--stdin", given=VERSION)
    tree = git(here, "mktree", given=f"100644 blob {file}\tversions.json\n")
    git(here, "branch", "gh-pages", git(here, "commit-tree", tree, "-m", "a version"))
    git(here, "push", "-q", "origin", "gh-pages")
    program = "from mike.driver import main; main()"
    subprocess.run(
        [sys.executable, "-c", program, "set-default", "-F", str(ROOT / "mkdocs.yml"), "latest"],
        cwd=here,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        timeout=300,
        check=True,
    )
    assert '"latest/"' in git(here, "show", "gh-pages:index.html")
    assert git(here, "show", "gh-pages:versions.json") == VERSION
    assert git(here, "rev-parse", "gh-pages~1") == git(here, "rev-parse", "origin/gh-pages"), (
        "nothing is pushed"
    )
