"""SJ2xx: types, units that do not mix, ranges and proofs."""

from math import inf

from sjdsl.compiler.diagnostics.diagnostic import AboutName, Diagnostic
from sjdsl.near_names import nearest


class UnitMismatch(Diagnostic, code="SJ201", title="Units that do not go together"):
    says = "cannot {verb} {left} and {right}"
    verb: str
    left: str
    right: str


class ProbabilityRange(Diagnostic, code="SJ202", title="Not a probability"):
    says = "this probability can {leave}"
    hints = ("keep it between 0 and 1, for instance with a range `in a .. b` on its parameters",)
    low: float
    high: float

    @property
    def leave(self) -> str:
        if self.high <= 1 + 1e-9:
            return "fall below 0"
        return "exceed 1" if self.high == inf else f"reach {self.high:g}"


class TooFewToDeal(Diagnostic, code="SJ220", title="Too few different values"):
    says = "the {entries} entries of this row cannot all be different: it draws from {values}"
    hints = ("draw from more values, or leave out `different`",)
    entries: int
    values: int


class TableGap(Diagnostic, code="SJ203", title="A table with a gap or an overlap"):
    says = "no set of words has just these words"
    hints = ("list every case exactly once",)


class TableLacks(TableGap):
    says = "the table lacks {listed}"
    words: tuple[str, ...]

    @property
    def listed(self) -> str:
        return ", ".join(f"`{word}`" for word in self.words)


class CaseLacks(TableLacks):
    says = "`case` lacks {listed}"


class CaseLeavesOpen(TableGap):
    says = "`case` leaves {numbers} open"
    numbers: str


class CaseOverlaps(TableGap):
    says = "this case overlaps one before it, or is empty"


class UnequalRows(TableGap):
    says = "the rows of this table differ in their words"


class TableRepeats(TableGap):
    says = "the table has `{name}` twice"
    name: str


class CaseRepeats(TableRepeats):
    says = "`case` has `{name}` twice"


class WordForNumber(TableGap):
    says = "`{name}` cannot be the case of a number"
    name: str


class NumberForWord(TableGap):
    says = "a number cannot be the case of a word"


class OtherwiseNotLast(TableGap):
    says = "`otherwise` stands once, and last"


class NothingForOtherwise(TableGap):
    says = "nothing is left for `otherwise`"


class LastLabelConditional(TableGap):
    says = "the last label has no condition"


class LabelUnconditional(TableGap):
    says = "label `{name}` needs a condition (`where`)"
    name: str


class FieldRange(AboutName, code="SJ204", title="A field can leave its range"):
    """name: the path of one field. declared: the name by which it is declared."""

    says = "`{name}` can leave its range {low} .. {high} here: it can become {reached}"
    hints = ("write `capped` after the range, or guard the change with `when`",)
    declared: str
    low: float
    high: float
    reached: str


class LeavesFloat32InField(FieldRange):
    says = "`{name}` can get a number too large for float32, which is in no range"
    hints = ("compute it from fields and params with limits, such as `number in 0 .. 10`",)


class WordOutside(Diagnostic, code="SJ205", title="Not one of the words"):
    """owner: what has the words, as written. declared: the field or event that declares them."""

    says = "`{word}` is not one of the words of {owner}"
    hints = ("did you mean {nearest}? the words are {listed}", "its words are {listed}")
    instead = ("{nearest}",)
    word: str
    owner: str
    declared: str = ""
    words: tuple[str, ...]

    @property
    def nearest(self) -> tuple[str, ...]:
        return nearest(self.word, self.words)

    @property
    def listed(self) -> str:
        return ", ".join(self.words)


class NeverEqual(Diagnostic, code="SJ206", title="These can never be equal"):
    says = "these two can never be equal: they have no word in common"


class NeverOneCell(NeverEqual):
    says = "these two can never be one cell: they are of different kinds"
    hints = ()


class ZeroDivisor(Diagnostic, code="SJ207", title="Division by zero"):
    says = "this divisor can be 0"
    hints = ("give the parameter a range that leaves out 0, or write a `require`",)


class EmptyMix(Diagnostic, code="SJ208", title="Shares of nothing"):
    says = "this row can be empty, and then it has no shares"
    hints = ("guard it with `sum({row}) > 0`",)
    row: str


class CanBeNobody(Diagnostic, code="SJ209", title="Nobody there"):
    says = "`{path}` can be nobody here"
    hints = ("guard it with `{path} is not nobody`",)
    path: str


class CanBeNowhere(CanBeNobody):
    says = "`{path}` can be nowhere here"
    hints = ("guard it with `{path} is not nowhere`",)


class ShapeParam(AboutName, code="SJ210", title="A number that sets a shape"):
    says = "`{name}` sets {quantity}, so it is a `size`, not a `param`"
    hints = ("write `size {name} : ...`",)
    quantity: str


class Weights(Diagnostic, code="SJ211", title="Weights that do not sum to 1"):
    says = "the weights sum to {total}, not 1"
    total: float | str


class RequireFalse(Diagnostic, code="SJ212", title="A requirement that does not hold"):
    says = "this requirement does not hold: {problem}"
    hints = ("change the numbers, or the requirement",)
    problem: str


class WrongType(Diagnostic, code="SJ213", title="Wrong type"):
    says = "expected {wanted}, found {actual}"
    wanted: str
    actual: str


class Negative(AboutName, code="SJ214", title="A number outside its limits"):
    says = "{name} can be negative"


class OutOfLimits(Negative):
    says = "{name} is {value}, outside {low} .. {high}{reason}"
    value: float | str
    low: float
    high: float
    reason: str = ""


class RoundsTooFar(Negative):
    says = "{name} gets a number that can leave -{limit} .. {limit}"
    hints = (
        "give its parameters limits, `in a .. b`, or keep it between two numbers: "
        "`round(min(max(x, 0), 100))`",
    )
    limit: int


class Crossed(Diagnostic, code="SJ215", title="Bounds that can cross"):
    says = "the bounds {low} and {high} can cross"
    hints = ("write `require {low} <= {high}` in `checks`, or give the parameters ranges",)
    low: str
    high: str


class RoundedToOne(Crossed):
    says = (
        "the bounds {low} and {high} can be one number once they are rounded to float32, "
        "as whole numbers beyond 16777216 are"
    )
    hints = ("give them limits within -16777216 .. 16777216, such as `in 0 .. 1000`",)


class NotFixed(Diagnostic, code="SJ216", title="Not known when compiled"):
    says = "{quantity} must be known when the game is compiled"
    hints = ("use numbers and `size`s only",)
    quantity: str


class ExtremeOfNothing(AboutName, code="SJ217", title="The largest of none"):
    """`domain`: as it is written."""

    says = "`{domain}` can be empty here, and then `{name}` has no value"
    hints = (
        "give its value for that case: `{name}(… over {domain} otherwise 0)`; "
        "or guard it with `count({domain}) > 0`",
    )
    domain: str


class BeyondInt32(AboutName, code="SJ218", title="A whole number too large for 32 bits"):
    """`reached`: how far the number can go, beyond the limit."""

    says = "`{name}` can {reach}; whole numbers {end}"
    reached: float
    limit: int

    @property
    def reach(self) -> str:
        return "grow without end" if self.reached == inf else f"become {int(self.reached)}"

    @property
    def end(self) -> str:
        return f"end at {self.limit}" if self.limit > 0 else f"begin at {self.limit}"


class AddedBeyondInt32(BeyondInt32):
    """`often`: how often the statement can add to one entry in a phase, or count in a step."""

    says = "{often:time} in a phase, this can let `{name}` {reach}; whole numbers {end}"
    often: int


class TalliedBeyondInt32(AddedBeyondInt32):
    says = "{often:time} in a step, this can let the count of `{name}` {reach}; whole numbers {end}"


class NotChosen(Diagnostic, code="SJ219", title="An argument of an action that was not chosen"):
    """`path`: as it is written, `agent.offer.apples`."""

    says = "`{path}` exists only if `{agent}` chose `{action}`, which isn't certain here"
    hints = ("guard it with `{agent} chose {action}`",)
    agent: str
    action: str
    path: str


class PowerTooLarge(Diagnostic, code="SJ221", title="A number that a function does not take"):
    says = "this power can be too large for float32"
    hints = ("give its numbers limits, `in a .. b`, or bound them with `min` and `max`",)


class OutsideDomain(PowerTooLarge):
    says = "`{name}` takes {taken}, and this can be {reached}"
    name: str
    taken: str
    reached: str


# Mistakes that a guard can rule out: reported only where the guards around could be read.
GUARDABLE = (
    ProbabilityRange, TableGap, FieldRange, WordOutside, ZeroDivisor, EmptyMix, CanBeNobody,
    Weights, Crossed, ExtremeOfNothing, NotChosen, PowerTooLarge,
)  # fmt: skip
