"""The edits that mean nothing, so that the rules stay the same and nothing is said: each class with its reason."""

from pathlib import Path

from tests.damage.edits import FOLDER, Edit, tokens

CLASSES = {
    "title of a variant": "the text beside a variant's name is for readers; the rules keep the names of variants alone",
    "number in other digits": "`00` is the number `0`",
    "plus before a value": "`+ 1` is `1`",
    "other path to the same file": "`maps//coins.txt` is `maps/coins.txt`",
}


def class_of(edit: Edit) -> str:
    """Returns the class of an edit that means nothing, empty if it should mean something."""
    if edit.kind == "row":
        return ""
    everything = tokens(edit.game)[1]
    places = [next(i for i, t in enumerate(everything) if t is token) for token in edit.tokens]
    if all(_is_title_of_variant(everything, place) for place in places):
        return "title of a variant"
    if edit.tokens[0].type in ("INT", "DEC") and _value(edit.after) == _value(edit.before):
        return "number in other digits"
    if edit.after.split() == ["+", "+"]:
        return "plus before a value"
    if edit.tokens[0].type == "STRING" and _file(edit.after) == _file(edit.before):
        return "other path to the same file"
    return ""


def _file(text: str) -> Path:
    return (FOLDER / text.strip('"')).resolve()


def _is_title_of_variant(everything: tuple, place: int) -> bool:
    return (
        everything[place].type == "STRING" and place > 1 and everything[place - 2].type == "VARIANT"
    )


def _value(digits: str) -> float | None:
    try:
        return float(digits)
    except ValueError:
        return None
