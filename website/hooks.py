"""What MkDocs asks while it builds the site: pages that are made from other files take their place among those of docs/."""

import os
import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from PIL import Image

import sjdsl
from website import boards, dark, gallery
from website.chapters import Chapter, slug, split
from website.links import DOCS, PAGES, SOURCE, Places, plain_fences, source_page
from website.reference import MODULES, reference_pages
from website.source_pages import source_text

ROOT = Path(__file__).resolve().parents[1]
MANUAL = "docs/language.md"
CACHE = ROOT / "build" / "site-boards"
DARK = ROOT / "build" / "site-dark"
MODULES_FOLDER = (
    ROOT / "build" / "site-modules"
)  # in which `sjdsl.trainers` is where it is when installed
STRIP = (
    "clean_up",
    "harvest_open",
    "coins",
    "coop_mining",
    "mushrooms",
    "territory",
)  # on the front page
HOSTED = "https://sjdsl.github.io/sjdsl/"
WITHOUT_NAVIGATION = "---\nhide: [navigation]\n---"  # a front page has no pages beside it
OTHER_PAGES = "Other pages"


def on_startup(command: str, dirty: bool) -> None:
    """Lays out the modules before the plugins are configured: that of the reference leaves out folders that are not there yet."""
    del command, dirty
    _link_modules()


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """Completes the table of contents, and says what version this is. Commands come here that build nothing, too: no game is read."""
    config.mdx_configs.setdefault("toc", {})["slugify"] = slug
    config.copyright = f"sjdsl {sjdsl.__version__}, Apache-2.0"
    if (
        "MIKE_DOCS_VERSION" in os.environ
    ):  # only a site of several versions has a list of them to choose from
        config.extra["version"] = {"provider": "mike", "default": "latest"}
    _, chapters = _manual()
    _extend(config.nav, "language.md", [f"language/{chapter.name}.md" for chapter in chapters])
    _extend(
        config.nav, gallery.INDEX, [f"{gallery.FOLDER}/{name}.md" for name in gallery.shown_names()]
    )
    _extend(
        config.nav,
        "reference/messages.md",
        [{module: f"reference/{module}.md"} for module in MODULES],
    )
    tour, *others = _notebooks()
    _extend(config.nav, tour, others)
    named = set(_pages_of(config.nav))
    found = (
        path.relative_to(ROOT / DOCS).as_posix() for path in sorted((ROOT / DOCS).rglob("*.md"))
    )
    missing = [page for page in found if page not in named]
    config.nav += [{OTHER_PAGES: missing}] if missing else []
    return config


def _extend(nav: list[Any], page: str, pages: list[Any]) -> None:
    """Puts pages after one, in the section in which it is."""
    for entry in nav:
        for section in entry.values() if isinstance(entry, dict) else ():
            if isinstance(section, list):
                if page in section or any(
                    isinstance(e, dict) and page in e.values() for e in section
                ):
                    section += pages
                    return
                _extend(section, page, pages)


def _pages_of(nav: Any) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    else:
        for entry in nav.values() if isinstance(nav, dict) else nav:
            yield from _pages_of(entry)


def _notebooks() -> list[str]:
    """Returns the pages of the notebooks in examples/, the tour first."""
    paths = sorted(
        (ROOT / "examples").glob("*.ipynb"), key=lambda path: (path.stem != "tour", path.stem)
    )
    return [source_page(path.relative_to(ROOT).as_posix()) for path in paths]


def _manual() -> tuple[str, list[Chapter]]:
    return split((ROOT / MANUAL).read_text("utf-8"))


def _link_modules() -> None:
    package = MODULES_FOLDER / "sjdsl"
    package.mkdir(parents=True, exist_ok=True)
    for path in [*(ROOT / "sjdsl").iterdir(), ROOT / "trainers"]:
        link = package / path.name
        if not link.is_symlink():
            link.symlink_to(path)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages that are made, and takes those out of which they are made."""
    for page, text in _pages().items():
        before = files.get_file_from_path(page)
        if before is not None:
            files.remove(before)
        files.append(File.generated(config, page, content=text))
    shown = [board for game in gallery.shown_games() for board in game.boards]
    boards.write_all(shown, CACHE)
    for board in shown:
        for ending in (".html", ".gif", ".png"):
            name = f"{board.name}{ending}"
            files.append(
                File.generated(config, f"{gallery.BOARDS}/{name}", abs_src_path=str(CACHE / name))
            )
    for still in _stills(config):
        files.append(still)
    for picture in _dark_pictures(config):
        files.append(picture)
    return files


def on_page_content(html: str, **_more: Any) -> str:
    """Shows pictures of games in the colours of the page."""
    return dark.both_palettes(html)


def _pages() -> dict[str, str]:
    """Returns every page as Markdown, by its place on the site."""
    introduction, chapters = _manual()
    places = Places(ROOT, MANUAL, chapters, gallery.game_pages(ROOT))
    texts = {MANUAL: introduction}
    for path in [
        *PAGES,
        *(
            f"{DOCS}{page.relative_to(ROOT / DOCS).as_posix()}"
            for page in sorted((ROOT / DOCS).rglob("*.md"))
        ),
    ]:
        texts.setdefault(path, (ROOT / path).read_text("utf-8"))
    made = {
        page: plain_fences(places.relinked(text, path, page))
        for path, text in texts.items()
        for page in [PAGES.get(path, path.removeprefix(DOCS))]
    }
    made["index.md"] = front_page(made["index.md"])
    made |= {
        page: plain_fences(places.relinked(c.text, MANUAL, page))
        for c in chapters
        for page in [places.chapter_page(c)]
    }
    made |= {gallery.INDEX: gallery.gallery_page(), **reference_pages(ROOT)}
    made |= {
        f"{gallery.FOLDER}/{shown.name}.md": gallery.game_page(shown, ROOT)
        for shown in gallery.shown_games()
    }
    places.wanted |= {page.removeprefix(f"{SOURCE}/").removesuffix(".md") for page in _notebooks()}
    done = set[str]()
    while todo := sorted(places.wanted - done):
        done |= {*todo}
        made |= {source_page(path): source_text(places, path, source_page(path)) for path in todo}
    return made


def front_page(readme: str) -> str:
    """Returns the front page: its buttons after the first paragraph, films that stand still where asked for, and a strip of games."""
    head, mark, rest = readme.partition("\n## ")
    title, paragraph, *others = head.strip().split("\n\n")
    (buttons,) = (part for part in others if part.startswith("[**Playground**]"))
    links = [
        line.strip().replace("**", "")
        for line in buttons.replace(f"{HOSTED}{gallery.FOLDER}/", gallery.INDEX).split("·")
    ]
    made = " ".join(
        f"{link}{{ .md-button{'' if number else ' .md-button--primary'} }}"
        for number, link in enumerate(links)
    )
    films = re.sub(
        r'<img src="(pictures/\w+)\.gif"[^>]*>',
        _still_if_asked,
        "\n\n".join(part for part in others if part != buttons),
    )
    cards = [
        f'<a href="{gallery.FOLDER}/{name}.html">{gallery.picture(boards.Board(name, name), ".")}</a>'
        for name in STRIP
    ]
    strip = "\n".join(['<div class="strip">', *cards, "</div>"])
    return (
        "\n\n".join([WITHOUT_NAVIGATION, f"{title} {{ .home }}", paragraph, made, films, strip, ""])
        + mark.lstrip("\n")
        + rest
    )


def _still_if_asked(film: re.Match[str]) -> str:
    still = f'<source media="(prefers-reduced-motion: reduce)" srcset="{film[1]}.still.png">'
    return f"<picture>{still}{film[0]}</picture>"


def _stills(config: MkDocsConfig) -> Iterator[File]:
    """Yields the last picture of each film of docs/pictures, light and dark, as files."""
    for film in sorted((ROOT / DOCS / "pictures").glob("*.gif")):
        with Image.open(film) as frames:
            frames.seek(frames.n_frames - 1)
            last = frames.convert("RGB")
        name = f"pictures/{film.stem}.still.png"
        for place, picture in ((name, last), (dark.dark_name(name), dark.darkened(last))):
            content = BytesIO()
            picture.save(content, "png")
            yield File.generated(config, place, content=content.getvalue())


def _dark_pictures(config: MkDocsConfig) -> Iterator[File]:
    """Yields each film and picture of docs/pictures for dark pages, as a file."""
    for source in sorted((ROOT / DOCS / "pictures").rglob("*.*")):
        name = dark.dark_name(source.relative_to(ROOT / DOCS).as_posix())
        dark.write_dark(source, DARK / name)
        yield File.generated(config, name, abs_src_path=str(DARK / name))
