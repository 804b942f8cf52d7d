"""Raises the first line of a file, `sj 1`, to the version of the language that the file needs."""

from dataclasses import dataclass

from sjdsl.compiler.diagnostics.source import Source
from sjdsl.compiler.syntax.parse import parse, read_tree
from sjdsl.compiler.syntax.versions import VERSIONS, needed


@dataclass(frozen=True)
class Upgrade:
    """A file with another first line. `version`: what it says now; `reason`: what that is needed for; `line`: where it stands first."""

    source: Source
    version: str
    reason: str
    line: int


def upgrade(source: Source) -> Upgrade | None:
    """Returns a file that says the version it needs; None if it says that, or a newer one, already. Raises CompileError."""
    version, reason, span = needed(parse(source))
    said = read_tree(source)[0][1]  # behind the word `sj`
    if VERSIONS.index(version) <= VERSIONS.index(str(said)):
        return None
    assert said.start_pos is not None and said.end_pos is not None
    text = source.text[: said.start_pos] + version + source.text[said.end_pos :]
    return Upgrade(Source(source.name, text, source.folder, source.over), version, reason, span.line)
