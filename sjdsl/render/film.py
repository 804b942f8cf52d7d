"""Writes pictures as files: many as a GIF or an MP4, one as a PNG."""

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path

from sjdsl.extras import needs
from sjdsl.files import written_whole

with needs("pictures"):
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

MILLISECONDS = 120  # a frame is shown
SAMPLES = 24  # frames whose colours make the palette
COLOURS = 200  # leaves room for the one that says "as before"


def save_gif(frames: Sequence[Image.Image], path: Path | str, milliseconds: int = MILLISECONDS) -> None:
    """Writes frames as an endless GIF with one palette, so that what does not change does not flicker."""
    palette = _palette(frames)
    plain = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [milliseconds] * (len(plain) - 1) + [8 * milliseconds]
    with written_whole(Path(path)) as file:
        plain[0].save(file, format="GIF", save_all=True, append_images=plain[1:], duration=durations, loop=0, optimize=True)


def save_mp4(frames: Sequence[Image.Image], path: Path | str, milliseconds: int = MILLISECONDS) -> None:
    """Writes frames as an H.264 film. Raises ModuleNotFoundError without the package `av` (`sjdsl[video]`)."""
    with needs("video"):
        import av

    width, height = (2 * (side // 2) for side in frames[0].size)  # the encoding halves both
    with written_whole(Path(path)) as file, av.open(file, "w", format="mp4") as film:
        stream = film.add_stream("libx264", rate=Fraction(1000, milliseconds))
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for frame in frames:
            film.mux(stream.encode(av.VideoFrame.from_image(frame.convert("RGB").crop((0, 0, width, height)))))
        film.mux(stream.encode())


def save_png(frame: Image.Image, path: Path | str, notes: Mapping[str, str] | None = None) -> None:
    """Writes one picture; `notes` stand in the file as texts by key."""
    texts = PngInfo()
    for key, note in (notes or {}).items():
        texts.add_text(key, note)
    with written_whole(Path(path)) as file:
        frame.save(file, format="PNG", optimize=True, pnginfo=texts)


def _palette(frames: Sequence[Image.Image]) -> Image.Image:
    """Returns a palette for all frames, from a sample of them side by side."""
    chosen = frames[:: max(1, len(frames) // SAMPLES)]
    width, height = frames[0].size
    sheet = Image.new("RGB", (width, height * len(chosen)))
    for number, frame in enumerate(chosen):
        sheet.paste(frame, (0, number * height))
    return sheet.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
