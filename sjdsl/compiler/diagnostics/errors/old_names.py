"""The codes by their names of before, for calls that still use them."""

from typing import Any

from sjdsl.compiler.diagnostics.diagnostic import Diagnostic, Fix, Label, Near
from sjdsl.compiler.diagnostics.errors import maps, names, rules, syntax, values
from sjdsl.compiler.diagnostics.source import Span

NEWER_LANGUAGE = syntax.NewerLanguage
UNEXPECTED = syntax.Unexpected
RESERVED_WORD = syntax.ReservedWord
BAD_CHARACTER = syntax.BadCharacter
FILE_TOO_LARGE = syntax.FileTooLarge
TOO_DEEP = syntax.TooDeep
TOO_MUCH = syntax.TooMuch
UNREADABLE = syntax.Unreadable
NOT_TEXT = syntax.NotText
OPEN_STRING = syntax.OpenString
OPEN_BLOCK = syntax.OpenBlock
NO_VERSION = syntax.NoVersion
UNKNOWN_NAME = names.UnknownName
NAME_TAKEN = names.NameTaken
WORD_CLASH = names.WordClash
NO_FIELD = names.NoField
NO_ACTION = names.NoAction
PHASE_USE = names.PhaseUse
NO_EVENT = names.NoEvent
CHANGE_UNKNOWN = names.ChangeUnknown
CHANGE_CLASH = names.ChangeClash
EXTENDS_CYCLE = names.ExtendsCycle
NO_FILE = names.NoFile
FILE_OUTSIDE = names.FileOutside
NOT_A = names.WrongSort
MISSING_PART = names.MissingPart
TWICE = names.WrittenTwice
NO_VARIANT = names.NoVariant
BAD_NAME = names.BadName
ARGUMENTS = names.WrongArguments
DEFINE_CYCLE = names.DefineCycle
NO_PAINT = names.NoPaint
UNIT_MISMATCH = values.UnitMismatch
PROBABILITY_RANGE = values.ProbabilityRange
TABLE_GAP = values.TableGap
FIELD_RANGE = values.FieldRange
WORD_OUTSIDE = values.WordOutside
NEVER_EQUAL = values.NeverEqual
ZERO_DIVISOR = values.ZeroDivisor
EMPTY_MIX = values.EmptyMix
CAN_BE_NOBODY = values.CanBeNobody
SHAPE_PARAM = values.ShapeParam
WEIGHTS = values.Weights
REQUIRE_FALSE = values.RequireFalse
WRONG_TYPE = values.WrongType
OUT_OF_LIMITS = values.OutOfLimits
CROSSED = values.Crossed
NOT_FIXED = values.NotFixed
UNKNOWN_GLYPH = maps.UnknownGlyph
RAGGED_MAP = maps.RaggedMap
TOO_FEW_CELLS = maps.TooFewCells
GLYPH_TWICE = maps.GlyphTwice
BAD_PICTURE = maps.BadPicture
KIND_ABSENT = maps.KindAbsent
EMPTY_MAP = maps.EmptyMap
BAD_GLYPH = maps.BadGlyph
MAP_FILE = maps.MapFile
DIRECTED_SHAPE = maps.DirectedShape
WRITE_CONFLICT = rules.WriteConflict
ADD_AND_SET = rules.AddAndSet
TWO_DESTINATIONS = rules.TwoDestinations
NO_FREE_CELL = rules.NoFreeCell
MOVE_ALONE = rules.MoveAlone
OVERLAPPING_SENDS = rules.OverlappingSends
NO_START = rules.NoStart
TICK = rules.TickTwice
TIMER_BOTH_SIDES = rules.TimerBothSides
NEVER_HAPPENS = rules.NeverHappens
UNUSED = rules.Unused
IDLE_ACTION = rules.IdleAction
FORBID_READS = rules.ForbidReads
NO_PLACE_YET = rules.NoPlaceYet
NEVER_COUNTED = rules.NeverCounted
LOOK_READS = rules.LookReads
NOT_SUPPORTED = rules.Unsupported


def diagnostic(kind: type[Diagnostic], span: Span, labels: tuple[Label, ...], fix: Fix | None, facts: dict[str, Any]) -> Diagnostic:
    """Returns a diagnostic from facts that are not typed yet."""
    if issubclass(kind, names.NotKnown):
        facts["near"] = Near(facts.pop("nearest", ""), facts.pop("known", ""))
    if kind is FIELD_RANGE:
        facts |= {"low": float(facts["low"]), "high": float(facts["high"]), "declared": _declared(facts["name"])}
    if kind is WORD_OUTSIDE:
        facts.pop("nearest")
        facts["owner"] = facts.pop("name")
        facts |= {"words": tuple(facts["words"].split(", ")), "declared": _declared(facts["owner"])}
    if kind is NO_START:
        facts.clear()
    if kind is MISSING_PART:
        facts["how"] = facts.pop("help")
    if kind is UNKNOWN_GLYPH:
        facts["other_case"] = facts.pop("nearest")
    if kind is NO_PAINT:
        facts["nearest"] = facts.pop("lead").removeprefix("the").removeprefix("did you mean `").removesuffix("`? The")
    return kind(span, labels=labels, fix=fix, **facts)


def _declared(name: str) -> str:
    return name.strip("`").split("[")[0].split(".")[-1]
