"""SJ1xx: names that are unknown, taken or misused."""

from typing import ClassVar

from sjdsl.compiler.diagnostics.diagnostic import AboutName, Diagnostic, Near


class NotKnown(AboutName):
    """A name of nothing, or of something of another sort."""

    hints = ("did you mean {near.nearest}?", "{near.listed}")
    instead: ClassVar[tuple[str, ...]] = ("{near.nearest}",)
    near: Near = Near()


class UnknownName(NotKnown, code="SJ101", title="Unknown name"):
    says = "`{name}` is not known here"


class NameTaken(AboutName, code="SJ102", title="Name already taken"):
    says = "`{name}` is already the name of {taken_by}"
    hints = ("choose another name, or bind with `as`",)
    taken_by: str


class WordClash(AboutName, code="SJ103", title="A word with the name of something else"):
    says = "`{name}` is both a word and {taken_by}"
    hints = ("rename one of the two",)
    taken_by: str


class NoField(NotKnown, code="SJ104", title="No such field"):
    says = "{owner} has no field `{name}`"
    owner: str


class NoAction(NotKnown, code="SJ105", title="No such action"):
    says = "`{name}` is not an action of the agents"


class StartScheduled(AboutName, code="SJ106", title="Phase and schedule disagree"):
    says = "phase `{name}` is run at reset, not in the schedule"


class PhaseNotScheduled(StartScheduled):
    says = "phase `{name}` is written but not scheduled"
    hints = ("add it to the schedule",)


class PhaseNotWritten(StartScheduled):
    says = "phase `{name}` is scheduled but not written"
    hints = ("did you mean {nearest}?",)
    instead = ("{nearest}",)
    nearest: tuple[str, ...]


class PhasesNotWritten(StartScheduled):
    says = "phases {listed} are scheduled but not written"
    hints = ("write each, `phase {name} {{ … }}`, or take it out of the schedule",)
    names: tuple[str, ...]

    @property
    def listed(self) -> str:
        return ", ".join(f"`{name}`" for name in self.names)


class NoEvent(NotKnown, code="SJ107", title="Event not declared"):
    says = "event `{name}` is not declared in `metrics`"
    hints = (
        "write `event {name}` in `metrics`, or did you mean {near.nearest}?",
        "write `event {name}` in `metrics`",
    )
    instead = ("{near.nearest}",)


class ChangeUnknown(NotKnown, code="SJ108", title="A change to what is not there"):
    says = "this changes `{name}`, which the game does not have"


class ChangeClash(AboutName, code="SJ109", title="Two variants disagree"):
    says = "variants `{first}` and `{second}` change `{name}` differently"
    hints = ("choose one of them",)
    first: str
    second: str


class ExtendsCycle(AboutName, code="SJ110", title="A game that extends itself"):
    says = "the chain of `extends` comes back to `{name}`"
    hints = ("break the circle",)


class NoFile(NotKnown, code="SJ111", title="Missing file"):
    says = "there is no file `{name}` beside this game"
    instead = ('"{near.nearest}"',)


class FileOutside(AboutName, code="SJ112", title="A path that leaves the folder"):
    says = "`{name}` leaves the folder of the game"
    hints = ("name a file in the game's own folder or below it",)


class LinkOutside(FileOutside):
    says = "`{name}` leaves the folder of the game: `{link}` is a link to `{target}`"
    hints = (
        "put a copy in place of the link; a link may lead to what is in the game's own folder",
    )
    link: str
    target: str


class WrongSort(NotKnown, code="SJ113", title="A name of another sort"):
    says = "`{name}` is {actual}; expected {wanted}"
    actual: str
    wanted: str


class MissingPart(Diagnostic, code="SJ114", title="Something every game needs"):
    says = "the game has no {part}"
    hints = ("write {example}",)
    part: str
    example: str


class WrittenTwice(Diagnostic, code="SJ115", title="Said twice"):
    says = "{part} is written twice"
    hints = ("keep one of them",)
    part: str


class NoVariant(NotKnown, code="SJ116", title="No such variant"):
    says = "the game has no variant `{name}`"
    instead = ()


class BadName(AboutName, code="SJ117", title="A name that cannot be used"):
    says = "`{name}` cannot be used as {role}: {problem}"
    hints = ("choose another name",)
    role: str
    problem: str


class WrongArguments(AboutName, code="SJ118", title="Wrong number of arguments"):
    says = "`{name}` takes {wanted}, not {actual}"
    wanted: str
    actual: int


class DefineCycle(AboutName, code="SJ119", title="A define that uses itself"):
    says = "`{name}` is used inside its own definition"
    hints = ("break the circle",)


class NoPaint(AboutName, code="SJ120", title="No such sprite or colour"):
    says = "`{name}` is neither a sprite nor a colour"
    hints = (
        "did you mean {nearest}? The sprites are {sprites}; the colours are {colours}, "
        'or any other as `"#rrggbb"`',
        'the sprites are {sprites}; the colours are {colours}, or any other as `"#rrggbb"`',
    )
    instead = ("{nearest}",)
    nearest: tuple[str, ...]
    sprites: str
    colours: str
