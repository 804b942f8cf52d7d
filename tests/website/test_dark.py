"""Pictures of games on dark pages: paper gets dark and letters light; boards and symbols stay as they are."""

import numpy as np
from PIL import Image

from website.dark import INK, PAPER, both_palettes, dark_name, darkened


def test_letters_and_paper_are_turned_round_and_pictures_stay() -> None:
    light = np.full((60, 60, 3), 255, np.uint8)
    light[2:22, 2:22] = (200, 40, 30)  # a symbol
    light[8:12, 8:12] = 255  # with an eye
    light[25:55, :20] = 120  # a grey wall, higher than letters, whose edge looks like an outline
    light[30:38, 40] = 0  # a letter
    dark = np.asarray(darkened(Image.fromarray(light)))
    assert (dark[2:22, 2:22] == light[2:22, 2:22]).all()
    assert (dark[26:54, :19] == 120).all()
    assert (dark[25, :20] < PAPER).all()
    assert (dark[30:38, 40] == INK).all()
    assert (dark[0, 30:] == PAPER).all()


def test_a_page_has_each_picture_twice() -> None:
    page = '<p><img alt="x" src="../pictures/coins.png" width="9"> <img src="a/schelling.svg"></p>'
    twice = both_palettes(page)
    assert twice.count("<img") == 3
    assert 'src="../pictures/coins.png#only-light"' in twice
    assert 'src="../pictures/coins.dark.png#only-dark"' in twice
    still = '<picture><source srcset="pictures/a.still.png"><img src="pictures/a.gif"></picture>'
    assert 'srcset="pictures/a.still.dark.png"' in both_palettes(still)
    board = '<picture><source srcset="b/a.png"><img src="b/a.gif"></picture>'
    assert both_palettes(board) == board
    assert dark_name("pictures/a/b.gif") == "pictures/a/b.dark.gif"
