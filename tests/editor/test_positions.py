"""Positions count code units as the protocol does; Python's own encoders are the oracle."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lsprotocol import types

from sjdsl.editor.positions import Lines, Moved

TEXTS = st.text(st.sampled_from("aé€😀\n\r\u2028\t# "), max_size=30)
WIDTH = {"utf-8": 1, "utf-16": 2, "utf-32": 4}


def units(text: str, encoding: str) -> int:
    return (
        len(
            text.encode(
                "utf-16-le"
                if encoding == "utf-16"
                else "utf-32-le"
                if encoding == "utf-32"
                else "utf-8"
            )
        )
        // WIDTH[encoding]
    )


@pytest.mark.parametrize("encoding", WIDTH)
@given(text=TEXTS, data=st.data())
def test_a_position_counts_code_units_of_its_line(
    encoding: str, text: str, data: st.DataObject
) -> None:
    offset = data.draw(st.integers(0, len(text)))
    lines = Lines(text, encoding)
    position = lines.position(offset)
    before = text[:offset].replace("\r\n", "\n").replace("\r", "\n").rpartition("\n")
    if text[offset - 1 : offset + 1] != "\r\n":  # between the two is the end of the line before
        assert position == types.Position(
            before[0].count("\n") + bool(before[1]), units(before[2], encoding)
        )
        assert lines.offset(position) == offset
    else:
        assert lines.offset(position) == offset - 1


def test_places_outside_a_text_are_moved_inside() -> None:
    lines = Lines("a😀b\ncd")
    assert lines.offset(types.Position(0, 99)) == 3
    assert lines.offset(types.Position(9, 0)) == 6
    assert lines.offset(types.Position(0, 2)) == 1, (
        "inside the two halves of a character is before it"
    )
    assert lines.range(0, 3) == types.Range(types.Position(0, 0), types.Position(0, 4))


@given(front=TEXTS, old=TEXTS, new=TEXTS, behind=TEXTS, data=st.data())
def test_what_an_edit_leaves_keeps_its_text(
    front: str, old: str, new: str, behind: str, data: st.DataObject
) -> None:
    before, after = front + old + behind, front + new + behind
    moved = Moved(before, after)
    start, end = sorted(
        (data.draw(st.integers(0, len(before))), data.draw(st.integers(0, len(before))))
    )
    now = after[moved.start(start) : moved.end(end)]
    if end <= len(front) and end > start:
        assert now == before[start:end]
        assert moved.back(moved.start(start)) == start
    if start >= len(front) + len(old) and end > start:
        assert now == before[start:end]
    assert 0 <= moved.start(start) <= len(after)
    assert 0 <= moved.back(data.draw(st.integers(0, len(after)))) <= len(before)
