"""The script of the page is built from the sources beside it, and its licences are there."""

import hashlib
import re
from pathlib import Path

REPOSITORY = Path(__file__).parents[2]
SOURCES, PAGE = REPOSITORY / "editors" / "studio", REPOSITORY / "sjdsl" / "studio" / "page"


def test_the_bundle_is_of_these_sources() -> None:
    digest = hashlib.sha256()
    for path in [*sorted((SOURCES / "src").iterdir()), SOURCES / "package-lock.json"]:
        digest.update(path.read_bytes())
    first = (PAGE / "studio.js").read_text(encoding="utf-8").splitlines()[0]
    assert first == f"// Built by editors/studio; sources {digest.hexdigest()}", (
        "`make studio-page` builds it again"
    )


def test_codemirror_is_pinned_and_every_licence_is_told() -> None:
    package = (SOURCES / "package.json").read_text(encoding="utf-8")
    assert re.search(r'"codemirror": "6\.0\.\d+"', package)
    licences = (PAGE / "studio.licences.txt").read_text(encoding="utf-8")
    assert all(
        f"\n{name} " in licences
        for name in ("codemirror", "@codemirror/lsp-client", "dompurify", "marked")
    )


def test_the_page_loads_nothing_from_elsewhere() -> None:
    page = (PAGE / "studio.html").read_text(encoding="utf-8")
    assert not re.findall(r"(?:src|href)=\"(?!/assets/|data:|#)", page)
    assert "@import" not in (PAGE / "studio.css").read_text(encoding="utf-8")
