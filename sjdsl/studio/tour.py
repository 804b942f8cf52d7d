"""The tour inside the studio: the steps of docs/tour.md, each with the game after that step."""

import re
from importlib.resources import files
from pathlib import Path

PREFIX = "tour:"  # of the path of a game of the tour, in the page
# After the language, a fence has words for the tests of docs/tour.md.
FENCE = re.compile(r"^```(\w*)[^\n]*$", re.MULTILINE)
LINK = re.compile(r"\[([^\]]+)\]\([^)]+\)")


def tour_folder() -> Path:
    """Returns the folder of the tour's games."""
    return Path(__file__).resolve().parent / "tour"


def steps() -> list[dict[str, str]]:
    """Returns the steps of the tour.

    Keys: `title`; `text`, Markdown without links; `game`, the path of the game after the step, ""
    for the opening.
    """
    text = files("sjdsl.studio").joinpath("tour/tour.md").read_text(encoding="utf-8")
    text = LINK.sub(r"\1", FENCE.sub(r"```\1", text))
    opening, *chapters = re.split(r"^## ", text, flags=re.MULTILINE)
    _, _, opening = opening.partition("\n")
    described = [{"title": "A tour", "text": opening.strip(), "game": ""}]
    for number, chapter in enumerate(chapters, 1):
        title, _, body = chapter.partition("\n")
        game = f"{PREFIX}berries_{number}.sj"
        described.append({"title": title, "text": body.strip(), "game": game})
    return described


def games() -> list[str]:
    """Returns the paths of the tour's games, in order."""
    return [step["game"] for step in steps() if step["game"]]
