"""The manual as pages: chapters, anchors and links, without MkDocs."""

from pathlib import Path

import pytest

from website.chapters import anchors, raised, slug, split
from website.links import DeadLink, Places, plain_fences

ROOT = Path(__file__).parents[2]
TEXT = """# Manual

See [one](#11-part).

## 1. The `first`

### 1.1 Part

```
## no heading
```

## 2. Second

Back to [part](#11-part), to [chapter two](#2-second) and [elsewhere](https://example.org), `[not](gone.md)`.
"""


def places() -> Places:
    _, chapters = split(TEXT)
    return Places(ROOT, "docs/language.md", chapters, {"games/coins.sj": "gallery/coins.md"})


def test_a_chapter_is_a_page() -> None:
    introduction, (first, second) = split(TEXT)
    assert introduction.startswith("# Manual") and "##" not in introduction
    assert (first.name, first.title) == ("the-first", "1. The `first`")
    assert first.text.splitlines()[:3] == ["# 1. The `first`", "", "## 1.1 Part"]
    assert "\n## no heading\n" in first.text  # code is left as it is
    assert anchors(first.text) == {"1-the-first", "11-part"}
    assert second.text.startswith("# 2. Second")


def test_the_manual_loses_nothing() -> None:
    text = (ROOT / "docs" / "language.md").read_text("utf-8")
    introduction, chapters = split(text)
    assert introduction + "".join(raised(chapter.text, -1) for chapter in chapters) == text
    assert anchors(introduction).union(*(anchors(chapter.text) for chapter in chapters)) == anchors(
        text
    )


def test_two_headings_with_one_anchor_are_refused() -> None:
    with pytest.raises(ValueError, match="part"):
        split("# a\n\n## Part\n\n## part\n")


def test_anchors_are_those_of_github() -> None:
    assert slug("5.6 Pictures: `look`") == "56-pictures-look"
    assert slug("What `a` - b_c, and [d](e.md)") == "what-a---b_c-and-d"


def test_links_lead_to_the_page_that_has_the_anchor() -> None:
    _, (_, second) = split(TEXT)
    found = places().relinked(second.text, "docs/language.md", "language/second.md")
    assert "[part](the-first.md#11-part)" in found
    assert "[chapter two](#2-second)" in found
    assert "[elsewhere](https://example.org)" in found and "`[not](gone.md)`" in found
    assert (
        places().relinked("[x](docs/language.md#11-part)", "README.md", "index.md")
        == "[x](language/the-first.md#11-part)"
    )
    assert (
        places().relinked("[x](../language.md)", "docs/interop/rllib.md", "interop/rllib.md")
        == "[x](../language.md)"
    )


def test_of_pictures_of_other_servers_the_text_stays() -> None:
    badge = "[![Open in Colab](https://example.org/badge.svg)](https://example.org/open) `![x](https://example.org/y.png)`"
    assert places().relinked(badge, "README.md", "index.md") == badge.replace(
        "![Open in Colab](https://example.org/badge.svg)", "Open in Colab"
    )


def test_links_out_of_docs_lead_to_pages_of_files() -> None:
    known = places()
    assert (
        known.relinked("[x](games/coins.sj) [y](CONTRIBUTING.md)", "README.md", "index.md")
        == "[x](gallery/coins.md) [y](contributing.md)"
    )
    assert (
        known.relinked('<img src="CITATION.cff" align="right">', "README.md", "index.md")
        == '<img src="source/CITATION.cff.md" align="right">'
    )
    assert (
        known.relinked("![x](../CITATION.cff)", "docs/tour.md", "tour.md")
        == "![x](source/CITATION.cff.md)"
    )
    assert known.wanted == {"CITATION.cff"}
    with pytest.raises(DeadLink, match=r"docs/tour.md: link `../gone.txt`"):
        known.relinked("[x](../gone.txt)", "docs/tour.md", "tour.md")


def test_blocks_say_what_a_highlighter_wants_to_know() -> None:
    assert plain_fences("```sj in=meadow name=x\na\n```\n") == "``` { .sj }\na\n```\n"
    assert plain_fences("```error\n```") == "``` { .text .message }\n```"
    assert plain_fences("  ```text file=a.txt\n  ```") == '  ``` { .text title="a.txt" }\n  ```'
