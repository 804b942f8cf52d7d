"""The tour inside the studio: the steps of docs/tour.md, each with the game as it is after that step."""

import re
from importlib.resources import files
from pathlib import Path

PREFIX = "tour:"  # of the path of a game of the tour, as the page has it
FENCE = re.compile(
    r"^```(\w*)[^\n]*$", re.MULTILINE
)  # after the language, what the tests of the page read
LINK = re.compile(r"\[([^\]]+)\]\([^)]+\)")


def tour_folder() -> Path:
    """Returns the folder of the tour's games."""
    return Path(__file__).resolve().parent / "tour"


def steps() -> list[dict[str, str]]:
    """Returns the steps: `title`, `text` in Markdown without links, and `game`, the path of the game after it; of the opening none."""
    text = files("sjdsl.studio").joinpath("tour/tour.md").read_text(encoding="utf-8")
    opening, *chapters = re.split(
        r"^## ", LINK.sub(r"\1", FENCE.sub(r"```\1", text)), flags=re.MULTILINE
    )
    found = [{"title": "A tour", "text": opening.split("\n", 1)[1].strip(), "game": ""}]
    for number, chapter in enumerate(chapters, 1):
        title, body = chapter.split("\n", 1)
        found.append({"title": title, "text": body.strip(), "game": f"{PREFIX}berries_{number}.sj"})
    return found


def games() -> list[str]:
    """Returns the paths of the tour's games, in order."""
    return [step["game"] for step in steps() if step["game"]]
