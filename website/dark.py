"""Films and pictures of games for dark pages: what is written below the board is light on dark."""

import re
from pathlib import Path

import numpy as np
from PIL import Image, ImageSequence
from scipy import ndimage

from sjdsl.files import written_whole
from sjdsl.render.film import save_gif

PAPER = np.array((30, 33, 41))  # of the theme's dark pages
INK = np.array((226, 228, 233))
WHITE = 246  # of 255: a pixel from here on in all colours is paper
LETTER = 14  # pixels: what is higher is a picture
GREY = 40  # a letter's colours differ by less
PICTURES = r"pictures/[\w/]+"
SHOWN = re.compile(rf'<picture>.*?</picture>|<img [^>]*src="[^"]*{PICTURES}\.(?:png|gif)"[^>]*>')
NAME = re.compile(rf"({PICTURES}(?:\.still)?)\.(png|gif)")


def dark_name(name: str) -> str:
    """Returns the name of the dark form of a picture's file."""
    return NAME.sub(r"\1.dark.\2", name)


def both_palettes(html: str) -> str:
    """Returns a page in which each picture of a game is there for light and for dark pages.

    The theme shows one of the two, by the end of its address.
    """

    def twice(shown: re.Match[str]) -> str:
        text = shown.group()
        if not NAME.search(text):
            return text
        light = re.sub(r'(<img [^>]*src="[^"]+)"', r'\1#only-light" loading="lazy"', text)
        return light + dark_name(light).replace("#only-light", "#only-dark")

    return SHOWN.sub(twice, html)


def darkened(frame: Image.Image) -> Image.Image:
    """Returns a picture whose paper is dark and whose letters are light; boards and symbols stay."""
    pixels = np.array(frame.convert("RGB")).astype(int)  # [H, W, 3]
    is_paper = (pixels >= WHITE).all(axis=2)
    parts, _ = ndimage.label(~is_paper, structure=np.ones((3, 3)))
    spread = pixels.max(axis=2) - pixels.min(axis=2)
    is_letter = np.zeros(is_paper.shape, bool)
    for number, place in enumerate(ndimage.find_objects(parts), 1):
        inside = parts[place] == number
        if inside.shape[0] <= LETTER and spread[place][inside].max() < GREY:
            is_letter[place] |= inside
    is_kept = ndimage.binary_fill_holes(~is_paper & ~is_letter)
    darkness = 1 - pixels.mean(axis=2, keepdims=True) / 255  # [H, W, 1]
    flipped = PAPER + darkness * (INK - PAPER)
    is_outline = is_kept & (spread < GREY) & ndimage.binary_dilation(~is_kept)
    outline = (1 - darkness) * PAPER  # black, as far as it covers the paper
    kept = np.where(is_outline[..., None], outline, pixels)
    return Image.fromarray(np.where(is_kept[..., None], kept, flipped).astype(np.uint8))


def write_dark(source: Path, target: Path) -> None:
    """Writes the dark form of a film or a picture, unless it is there and newer."""
    if target.is_file() and target.stat().st_mtime > source.stat().st_mtime:
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    with Image.open(source) as picture:
        milliseconds = picture.info.get("duration", 0)
        frames = [darkened(frame) for frame in ImageSequence.Iterator(picture)]
    if source.suffix == ".gif":
        save_gif(frames, target, milliseconds)
    else:
        with written_whole(target) as file:
            frames[0].save(file, format="PNG")
