"""Reads arrays from an untrusted `.npz` file: checks sizes before unpacking, never unpickles."""

import hashlib
import io
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterable
from math import prod

import numpy as np

# Other methods are refused: LZMA takes as much memory as the file says.
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
# What zipfile, zlib and NumPy raise for a damaged file; RuntimeError for an encrypted member.
FAULTS = (
    zipfile.BadZipFile,
    zipfile.LargeZipFile,
    zlib.error,
    struct.error,
    OSError,
    EOFError,
    RuntimeError,
    MemoryError,
    KeyError,
    IndexError,
    ValueError,
    TypeError,
    AttributeError,
    OverflowError,
    SyntaxError,
    tokenize.TokenError,
)


class TooLarge(ValueError):
    """Arrays take more memory than is allowed."""


def read_arrays(file: zipfile.ZipFile, names: Iterable[str], limit: int) -> dict[str, np.ndarray]:
    """Returns arrays by their names.

    Args:
      limit: bytes of all arrays together.

    Raises:
      TooLarge: they are larger. One of FAULTS: an array is missing or damaged.
    """
    members = {name: file.getinfo(f"{name}.npy") for name in names}
    size = sum(member.file_size for member in members.values())
    if size > limit:
        raise TooLarge(f"its arrays take {size:,} bytes, and {limit:,} are allowed")
    return {name: _read_array(_read_member(file, member)) for name, member in members.items()}


def array_digest(array: np.ndarray) -> bytes:
    """Returns the SHA-256 of an array: of its dtype, its shape and its entries in C order."""
    return hashlib.sha256(f"{array.dtype.str} {array.shape} ".encode() + array.tobytes()).digest()


def _read_member(file: zipfile.ZipFile, member: zipfile.ZipInfo) -> bytes:
    """Returns the content of a member, as long as it states; `ZipFile.read` would unpack more."""
    if member.compress_type not in METHODS:
        raise ValueError(f"{member.filename} is compressed in a way that is not read")
    with file.open(member) as opened:
        content = opened.read(member.file_size)
    if len(content) != member.file_size:
        raise ValueError(f"{member.filename} is cut")
    return content


def _read_array(content: bytes) -> np.ndarray:
    """Returns the array of a `.npy` file.

    NumPy allocates as much as the header states, so this has to be what follows the header.
    """
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
