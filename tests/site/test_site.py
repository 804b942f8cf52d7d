"""The built site (`make site`): every link and anchor leads somewhere, nothing is loaded from elsewhere, and what should be there is."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from sjdsl.library.games_folder import bundled, main_games
from sjdsl.library.substrates import written_substrates

ROOT = Path(__file__).parents[2]
SITE = ROOT / "build" / "site"
PAGES = sorted(SITE.rglob("*.html"))
LOADED = {
    ("script", "src"),
    ("img", "src"),
    ("iframe", "src"),
    ("source", "srcset"),
    ("link", "href"),
}
LED = LOADED | {("a", "href")}
INLINE = "data:"


@dataclass
class Seen(HTMLParser):
    """What a page names. anchors: its own; links: (tag, URL)."""

    anchors: set[str] = field(default_factory=set)
    links: list[tuple[str, str]] = field(default_factory=list)
    text: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.anchors |= {value for key in ("id", "name") if (value := values.get(key))}
        self.links += [
            (tag, value) for key, value in attrs if value is not None and (tag, key) in LED
        ]

    def handle_data(self, data: str) -> None:
        self.text.append(data)


@cache
def seen(page: Path) -> Seen:
    parser = Seen()
    parser.feed(page.read_text("utf-8"))
    return parser


@dataclass
class Prose(HTMLParser):
    """What a page says outside of code. inside: how many elements of code are open."""

    text: list[str] = field(default_factory=list)
    inside: int = 0

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, _attributes: list[tuple[str, str | None]]) -> None:
        self.inside += tag in ("pre", "code", "script", "style")

    def handle_endtag(self, tag: str) -> None:
        self.inside -= tag in ("pre", "code", "script", "style")

    def handle_data(self, data: str) -> None:
        if not self.inside:
            self.text.append(data)


def elsewhere(url: str) -> bool:
    return bool(urlsplit(url).scheme or urlsplit(url).netloc)


def dead_links(page: Path, site: Path = SITE) -> Iterator[str]:
    """Yields the links of a page into the site that lead nowhere, by file or by anchor."""
    for _, url in seen(page).links:
        if elsewhere(url):
            continue
        parts = urlsplit(url)
        target = page if not parts.path else (page.parent / unquote(parts.path)).resolve()
        if not target.is_file() or not target.is_relative_to(site):
            yield f"{url}: no such file"
        elif (
            parts.fragment
            and target.suffix == ".html"
            and unquote(parts.fragment) not in seen(target).anchors
            and parts.fragment != "__skip"
        ):
            yield f"{url}: no such anchor"


def test_every_link_and_anchor_leads_somewhere() -> None:
    pages = [
        page for page in PAGES if page.name != "404.html"
    ]  # its links begin at the root of the server
    assert len(pages) > 100
    found = {
        str(page.relative_to(SITE)): dead for page in pages if (dead := list(dead_links(page)))
    }
    assert found == {}


def test_a_dead_link_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text(
        '<a id="here" href="#here"></a><a href="#gone"></a><img src="none.png"><a href="page.html#here"></a>',
        "utf-8",
    )
    assert list(dead_links(page, tmp_path)) == ["#gone: no such anchor", "none.png: no such file"]


def test_nothing_is_loaded_from_elsewhere() -> None:
    loaded = {
        url
        for page in PAGES
        for tag, url in seen(page).links
        if tag != "a" and elsewhere(url) and not url.startswith(INLINE)
    }
    assert loaded == set()


def test_every_game_and_substrate_has_a_picture_and_a_board() -> None:
    names = [
        *bundled(),
        *(f"{s.game}__{s.variant}" if s.variant else s.game for s in written_substrates()),
    ]
    assert [
        name for name in names if not (SITE / "gallery" / f"{name.split('__')[0]}.html").is_file()
    ] == []
    small = [
        n
        for n in names
        for end in ("gif", "html", "png")
        if (SITE / "boards" / f"{n}.{end}").stat().st_size < 500
    ]
    assert small == []
    gallery = {url for tag, url in seen(SITE / "gallery" / "index.html").links if tag == "img"}
    substrates = {
        f"../boards/{s.game}__{s.variant}.gif" if s.variant else f"../boards/{s.game}.gif"
        for s in written_substrates()
    }
    assert gallery == substrates | {f"../boards/{name}.gif" for name in main_games()}


def test_no_mark_of_code_is_left_as_it_was_written() -> None:
    left = {}
    for page in PAGES:
        prose = Prose()
        prose.feed(page.read_text("utf-8"))
        lines = [line.strip() for line in prose.text if "`" in line]
        if lines:
            left[str(page.relative_to(SITE))] = lines[:3]
    assert left == {}
    assert "`" not in "".join(seen(SITE / "reference" / "commands.html").text)


def test_games_have_one_tab_and_pictures_are_there_for_dark_pages() -> None:
    home = (SITE / "index.html").read_text("utf-8")
    tabs = home[home.index('<nav class="md-tabs"') : home.index("</nav>", home.index("md-tabs"))]
    assert tabs.count("gallery/") == 1
    assert "games.html" not in tabs
    links = {url for tag, url in seen(SITE / "index.html").links if tag == "img"}
    assert {"pictures/orchard.gif#only-light", "pictures/orchard.dark.gif#only-dark"} <= links


def test_the_manual_is_in_pages_and_says_everything() -> None:
    chapters = sorted((SITE / "language").glob("*.html"))
    titles = [
        line
        for line in (ROOT / "docs/language.md").read_text("utf-8").splitlines()
        if line.startswith("## ")
    ]
    assert len(chapters) == len(titles) > 20
    assert "51-kinds-and-glyphs" in seen(SITE / "language" / "the-world.html").anchors
    led = {url for _, url in seen(SITE / "recipes.html").links}
    assert "language/how-to-read-the-examples.html#2-how-to-read-the-examples" in led


@pytest.mark.parametrize(
    ("page", "wanted"),
    [
        ("reference/sjdsl.html", {"sjdsl.make", "sjdsl.Environment", "sjdsl.Environment.step"}),
        (
            "reference/sjdsl.trainers.html",
            {"sjdsl.trainers.train", "sjdsl.trainers.evaluate", "sjdsl.trainers.PPOConfig"},
        ),
        ("reference/sjdsl.experiments.html", {"sjdsl.experiments.schelling_diagram"}),
        ("reference/messages.html", {"sj204-a-field-can-leave-its-range"}),
        ("reference/commands.html", {"sjdsl-train", "sjdsl-render"}),
    ],
)
def test_the_reference_has_the_public_names(page: str, wanted: set[str]) -> None:
    assert wanted - seen(SITE / page).anchors == set()


def test_blocks_of_the_language_are_coloured() -> None:
    text = (SITE / "tour.html").read_text("utf-8")
    assert '<span class="kd">kind</span>' in text
    assert text.count('class="highlight') > 5


def test_pages_are_found_by_search() -> None:
    entries = json.loads((SITE / "search" / "search_index.json").read_text("utf-8"))["docs"]
    places = {entry["location"].split("#")[0] for entry in entries}
    assert {
        "tour.html",
        "language/agents.html",
        "gallery/clean_up.html",
        "reference/sjdsl.html",
        "training.html",
    } <= places
    assert not [place for place in places if place.startswith("source/") and "ipynb" not in place]
