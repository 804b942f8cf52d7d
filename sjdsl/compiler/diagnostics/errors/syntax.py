"""SJ0xx: syntax errors, and files that cannot be read."""

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Suggestion
from sjdsl.compiler.diagnostics.errors.names import NotKnown


class NewerLanguage(Diagnostic, code="SJ001", title="A file for another version of the language"):
    says = "this file is for `sj {version}`, and this compiler reads `sj {known}`"
    hints = (
        "get a newer compiler (`pip install --upgrade sjdsl`), or write the file for `sj {known}`",
    )
    instead = ("sj {known}",)
    version: str
    known: str


class Unexpected(Diagnostic, code="SJ002", title="Something unexpected"):
    says = "unexpected {actual}, expected {expected}"
    actual: str
    expected: str


class ReservedWord(Diagnostic, code="SJ003", title="A word of the language used as a name"):
    """`labels`: where else the word is used as a name."""

    says = "`{word}` is a word of the language and cannot be a name"
    hints = ("choose another name, such as `{other}`",)
    word: str
    other: str

    @property
    def suggestions(self) -> tuple[Suggestion, ...]:
        places = (self.span, *(label.span for label in self.labels))
        return (
            Suggestion(f"write `{self.other}`", tuple(Fix(span, self.other) for span in places)),
        )


class BadCharacter(Diagnostic, code="SJ004", title="Not a character of the language"):
    says = "character {character} is not part of the language"
    character: str


class FileTooLarge(Diagnostic, code="SJ005", title="A file too large"):
    says = "the file has {size} bytes, and a game has at most {limit}"
    hints = ("is this the right file? a game is a few kilobytes of text",)
    size: int
    limit: int


class TooDeep(Diagnostic, code="SJ006", title="Nested too deeply"):
    says = "this is nested deeper than {limit} levels"
    hints = ("give a part of it a name with `let` or `define`, or write it as a phase of its own",)
    limit: int


class TooMuch(Diagnostic, code="SJ007", title="More than the compiler takes"):
    says = "{problem}; the most is {limit}"
    problem: str
    limit: int


class Unreadable(NotKnown, code="SJ008", title="A file that cannot be read"):
    says = "`{name}` cannot be read: {problem}"
    problem: str


class NotText(Diagnostic, code="SJ009", title="Not a text file"):
    says = "this file is not text: {problem}"
    hints = ("a game is plain text in UTF-8; save it as such",)
    problem: str


class OpenString(Diagnostic, code="SJ010", title="A text without its closing quote"):
    says = "this text has no closing quote in its line"
    hints = ('write `"` where it ends',)


class OpenBlock(Diagnostic, code="SJ011", title="A block that is never closed"):
    says = "this `{{` is never closed"


class NoVersion(Diagnostic, code="SJ012", title="No version line"):
    says = "the file does not begin with `sj {known}`{but}"
    hints = ("write `sj {known}` as the first line",)
    known: str
    but: str
