"""Threefry against published vectors, and the record of used words."""

import pytest

from sjdsl.interpreter.threefry import Recorded, Threefry, Used, return_stream, threefry


@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ((0, 0), (0, 0), (0x9D1C5EC6, 0x8BD50731)),
        ((0xFFFFFFFF, 0xFFFFFFFF), (0xFFFFFFFF, 0xFFFFFFFF), (0xFD36D048, 0x2D17272C)),
        ((0x243F6A88, 0x85A308D3), (0x13198A2E, 0x03707344), (0xBA3E4725, 0xF27D669E)),
    ],
)
def test_threefry_gives_the_known_answers(counter, key, expected):
    """Source: kat_vectors of Random123 1.14, threefry2x32 with 13 rounds."""
    assert threefry(key, counter) == expected


def test_two_words_are_the_halves_of_one_block():
    draws, block = (
        Threefry(0x13198A2E, 0x03707344),
        threefry((0x13198A2E, 0x03707344), (0x243F6A88, 0x05A308D3)),
    )
    assert (draws.bits(0x243F6A88, 0x0B4611A6), draws.bits(0x243F6A88, 0x0B4611A7)) == block


def test_recorded_words_are_remembered_in_order():
    draws = Recorded(Threefry(0, 0))
    assert draws.bits(0, 0) == 0x9D1C5EC6
    draws.bits(7, 3)
    assert draws.used == [Used(0, 0, 0x9D1C5EC6), Used(7, 3, Threefry(0, 0).bits(7, 3))]


def test_agents_come_back_with_words_of_their_own():
    assert return_stream(0) == 0x52455455
    assert return_stream(return_stream(0x89ABCDEF)) == 0x89ABCDEF
