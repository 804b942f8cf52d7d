"""Reads arrays out of an `.npz` file from elsewhere: sizes are looked at before anything is unpacked, and nothing is unpickled."""

import hashlib
import io
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterable
from math import prod

import numpy as np

METHODS = (
    zipfile.ZIP_STORED,
    zipfile.ZIP_DEFLATED,
)  # of others, LZMA takes as much memory as the file says
# What a damaged file raises in zipfile, zlib and NumPy; a member that is encrypted raises RuntimeError.
FAULTS = (
    *(
        zipfile.BadZipFile,
        zipfile.LargeZipFile,
        zlib.error,
        struct.error,
        OSError,
        EOFError,
        RuntimeError,
        MemoryError,
    ),
    *(
        KeyError,
        IndexError,
        ValueError,
        TypeError,
        AttributeError,
        OverflowError,
        SyntaxError,
        tokenize.TokenError,
    ),
)


class TooLarge(ValueError):
    """Arrays take more memory than they may."""


def read_arrays(file: zipfile.ZipFile, names: Iterable[str], limit: int) -> dict[str, np.ndarray]:
    """Returns arrays by their names, which take at most `limit` bytes in all.

    Raises:
      TooLarge: they are larger. One of FAULTS: an array is missing or damaged.
    """
    members = {name: file.getinfo(f"{name}.npy") for name in names}
    size = sum(member.file_size for member in members.values())
    if size > limit:
        raise TooLarge(f"its arrays take {size:,} bytes, and {limit:,} are allowed")
    return {name: _array(_content(file, member)) for name, member in members.items()}


def array_digest(array: np.ndarray) -> bytes:
    """Returns the SHA-256 of an array: of its dtype, its shape and its entries in C order."""
    return hashlib.sha256(f"{array.dtype.str} {array.shape} ".encode() + array.tobytes()).digest()


def _content(file: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Returns what a member holds: as much as it says, for `ZipFile.read` unpacks more before it looks."""
    if member.compress_type not in METHODS:
        raise ValueError(f"{member.filename} is compressed in a way that is not read")
    with file.open(member) as opened:
        content = opened.read(member.file_size)
    if len(content) != member.file_size:
        raise ValueError(f"{member.filename} is cut")
    return content


def _array(content: bytes) -> np.ndarray:
    """Returns the array of a `.npy` file, whose header must say what follows it: NumPy makes room for as much as it says."""
    file = io.BytesIO(content)
    read_header = {
        (1, 0): np.lib.format.read_array_header_1_0,
        (2, 0): np.lib.format.read_array_header_2_0,
    }
    shape, _, dtype = read_header[np.lib.format.read_magic(file)](file)
    if dtype.hasobject or prod(shape) * dtype.itemsize != len(content) - file.tell():
        raise ValueError("it is not the array that it says it is")
    file.seek(0)
    return np.lib.format.read_array(file, allow_pickle=False)
