"""Threefry against published vectors, and the record of used words."""

import pytest

from sjdsl.interpreter.draws import Near, Recorded, Threefry, Used, note_if_near, return_stream, threefry


@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ((0, 0), (0, 0), (0x6B200159, 0x99BA4EFE)),
        ((0xFFFFFFFF, 0xFFFFFFFF), (0xFFFFFFFF, 0xFFFFFFFF), (0x1CB996FC, 0xBB002BE7)),
        ((0x243F6A88, 0x85A308D3), (0x13198A2E, 0x03707344), (0xC4923A9C, 0x483DF7A0)),
    ],
)
def test_threefry_gives_the_known_answers(counter, key, expected):
    """Source: kat_vectors of Random123 1.14, threefry2x32 with 20 rounds."""
    assert threefry(key, counter) == expected


def test_a_word_is_the_first_half_of_the_counter_stream_and_number():
    assert Threefry(0x13198A2E, 0x03707344).word(0x243F6A88, 0x85A308D3) == 0xC4923A9C


def test_recorded_words_are_remembered_in_order():
    draws = Recorded(Threefry(0, 0))
    assert draws.word(0, 0) == 0x6B200159
    draws.word(7, 3)
    assert draws.used == [Used(0, 0, 0x6B200159), Used(7, 3, Threefry(0, 0).word(7, 3))]


def test_only_words_beside_a_threshold_are_near():
    draws = Recorded(Threefry(0, 0))
    note_if_near(draws, 1, 2, 2_000_000_000, 1_000_000_900)
    note_if_near(draws, 1, 2, 2_000_000_000, 1_000_001_100)
    note_if_near(draws, 1, 2, 20, 11)
    note_if_near(draws, 1, 2, 20, 12)
    assert draws.near == [Near(1, 2, 2_000_000_000, 1_000_000_900), Near(1, 2, 20, 11)]


def test_agents_come_back_with_words_of_their_own():
    assert return_stream(0) == 0x52455455
    assert return_stream(return_stream(0x89ABCDEF)) == 0x89ABCDEF
