"""Sprites: small SVG drawings, tinted."""

from functools import cache
from importlib.resources import files

FILLING = frozenset({"wall", "water", "floor"})  # these are as large as their cell, the others stand in it
SHAPES = ("disc", "diamond", "square", "triangle", "ring", "cross", "hexagon", "wedge")  # of words that have no sprite of their own


@cache
def sprite_source(name: str) -> str:
    """Returns the SVG text of a sprite; `currentColor` stands where its colour goes."""
    return files("sjdsl.render").joinpath(f"sprites/{name}.svg").read_text(encoding="utf-8")
