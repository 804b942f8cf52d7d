"""Files that pages link to and that are no pages themselves, as pages of their text; folders as lists; notebooks as they read."""

import json
import posixpath
from collections.abc import Iterator
from typing import Any

from website.links import Places

LANGUAGES = {
    ".sj": "sj",
    ".py": "python",
    ".toml": "toml",
    ".json": "json",
    ".txt": "text",
    ".cff": "yaml",
    ".js": "javascript",
}
TEXTS = {*LANGUAGES, ".csv", ".md", ".lark"}
LARGEST = 100_000  # bytes of a file that is shown
HIDDEN = "---\nsearch:\n  exclude: true\nhide:\n  - navigation\n---\n"


def source_text(places: Places, path: str, page: str) -> str:
    """Returns the page of a file or folder; `places` then wants the files of a folder, too.

    Args:
      path: in the repository.
      page: where it stands on the site.
    """
    found = places.root / path
    if found.is_dir():
        return HIDDEN + "\n".join(_listing(places, path, page)) + "\n"
    text = found.read_text("utf-8")
    if found.suffix == ".ipynb":
        return places.relinked("\n".join(notebook(json.loads(text))), path, page)
    fence = "`" * 6
    return f"{HIDDEN}# `{path}`\n\n{fence} {{ .{LANGUAGES.get(found.suffix, 'text')} }}\n{text.rstrip()}\n{fence}\n"


def _listing(places: Places, path: str, page: str) -> Iterator[str]:
    yield from (f"# `{path}/`", "")
    for file in sorted((places.root / path).iterdir()):
        if file.suffix in TEXTS and file.stat().st_size <= LARGEST:
            there = places.page_of(f"{path}/{file.name}", "")
            yield f"* [`{file.name}`]({posixpath.relpath(there, posixpath.dirname(page))})"
        elif file.is_file() and not file.name.startswith("."):
            yield f"* `{file.name}`"


def notebook(content: dict[str, Any]) -> Iterator[str]:
    """Yields the lines of a notebook as Markdown: its texts, its code, and what the code printed, if that is kept."""
    for cell in content["cells"]:
        text = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            yield from (text, "")
        elif cell["cell_type"] == "code":
            yield from ("``` { .python }", text, "```", "")
            for output in cell["outputs"]:
                yield from _output(output)


def _output(output: dict[str, Any]) -> Iterator[str]:
    data = output.get("data", {})
    if "image/png" in data:
        yield from (f"![](data:image/png;base64,{''.join(data['image/png']).strip()})", "")
        return
    text = "".join(output.get("text", data.get("text/plain", ())))
    if text:
        yield from ("``` { .text .result }", text.rstrip(), "```", "")
