"""Where the links of a page lead on the site: pages by their place in the repository, and files that are no pages as pages of their text."""

import posixpath
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from website.chapters import Chapter, anchors

CODE = r"^(?P<indent> *)(?P<fence>`{3,}).*?^(?P=indent)(?P=fence) *$|(?P<tick>`+).+?(?P=tick)"
PICTURE_ELSEWHERE = r"!\[(?P<said>[^\]]*)\]\(https?://[^)]*\)"
LINK = r"\]\((?P<target>[^)\s]+)\)"
IMAGE = r'<img src="(?P<image>[^"]+)"'
CODE_OR_LINK = re.compile(f"{CODE}|{PICTURE_ELSEWHERE}|{LINK}|{IMAGE}", re.DOTALL | re.MULTILINE)
ELSEWHERE = re.compile(r"[a-z]+:|//")
SOURCE = "source"  # the folder of the pages of files
PAGES = {
    "README.md": "index.md",
    "CONTRIBUTING.md": "contributing.md",
    "CODE_OF_CONDUCT.md": "code_of_conduct.md",
    "SECURITY.md": "security.md",
    "ARCHITECTURE.md": "architecture.md",
    "CHANGELOG.md": "changelog.md",
}
DOCS = "docs/"


class DeadLink(ValueError):
    """A link of a page leads to a file that is not there."""


@dataclass
class Places:
    """Where the files of the repository are on the site.

    Attributes:
      root: of the repository.
      manual: the file that is split, with its chapters.
      games: pages of the gallery, by the file of the game.
      wanted: files that pages link to, and that are no pages: filled as links are followed.
    """

    root: Path
    manual: str
    chapters: list[Chapter]
    games: Mapping[str, str]
    wanted: set[str] = field(default_factory=set)

    def page_of(self, path: str, anchor: str) -> str:
        """Returns the page of a file of the repository; of the manual, the page with that anchor. Raises DeadLink."""
        if path == self.manual:
            return next(
                (self.chapter_page(c) for c in self.chapters if anchor in anchors(c.text)),
                path.removeprefix(DOCS),
            )
        if path in PAGES or path in self.games:
            return PAGES.get(path) or self.games[path]
        if path == "docs" or not (self.root / path).exists():
            raise DeadLink(f"there is no file `{path}`")
        if path.startswith(DOCS) and (self.root / path).is_file():
            return path.removeprefix(DOCS)
        self.wanted.add(path)
        return source_page(path)

    def chapter_page(self, chapter: Chapter) -> str:
        return f"{self.manual.removeprefix(DOCS).removesuffix('.md')}/{chapter.name}.md"

    def relinked(self, text: str, path: str, page: str) -> str:
        """Returns a page whose links lead to pages of the site. Of pictures of other servers, such as badges, only the text stays.

        Args:
          text: Markdown; links in code are left as they are.
          path: the file in the repository that the text is from.
          page: where it stands on the site.

        Raises:
          DeadLink: naming the page and the link.
        """

        def lead(found: re.Match[str]) -> str:
            if found.group("said") is not None:
                return found.group("said")
            target = found.group("target") or found.group("image")
            if target is None or ELSEWHERE.match(target):
                return found.group()
            file, _, anchor = target.partition("#")
            wanted = (
                posixpath.normpath(posixpath.join(posixpath.dirname(path), file)) if file else path
            )
            try:
                there = self.page_of(wanted, anchor)
            except DeadLink as dead:
                raise DeadLink(f"{path}: link `{target}`: {dead}") from None
            near = (
                ""
                if there == page and anchor
                else posixpath.relpath(there, posixpath.dirname(page) or ".")
            )
            link = f"{near}{'#' + anchor if anchor else ''}"
            return f"]({link})" if found.group("target") else f'<img src="{link}"'

        return CODE_OR_LINK.sub(lead, text)


def source_page(path: str) -> str:
    """Returns the page of a file or a folder that is no page of its own."""
    return f"{SOURCE}/{path.strip('/')}.md"


INFO = re.compile(r"^(?P<indent> *)(?P<fence>`{3,})(?P<language>\w+)(?P<rest>[^\n]*)$", re.M)
SHOWN = {
    "result": "result",
    "error": "message",
    "warning": "message",
}  # our blocks that are no language, by their style


def plain_fences(text: str) -> str:
    """Returns a page whose blocks of code say what a highlighter wants to know, and not what the tests do."""

    def line(found: re.Match[str]) -> str:
        language = found.group("language")
        file = re.search(r"\bfile=(\S+)", found.group("rest"))
        parts = [".text", f".{SHOWN[language]}"] if language in SHOWN else [f".{language}"]
        parts += [f'title="{file.group(1)}"'] if file else []
        return f"{found.group('indent')}{found.group('fence')} {{ {' '.join(parts)} }}"

    return INFO.sub(line, text)
