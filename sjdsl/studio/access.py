"""Who may talk to the studio: this machine's browser, from the studio's own page, with the token of its address."""

import contextlib
import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

HOST = "127.0.0.1"
TOKEN = "studio_token"  # the file in the cache folder
SHORTEST = 32  # characters of a token


@dataclass(frozen=True)
class Access:
    """What a request has to show. `port`: of the server; `token`: hard to guess."""

    port: int
    token: str

    @property
    def address(self) -> str:
        """The address of the page, with the token."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    @property
    def hosts(self) -> frozenset[str]:
        return frozenset(f"{name}:{self.port}" for name in (HOST, "localhost"))

    def refusal(
        self, headers: Mapping[str, str], token: str | None, needs_token: bool = True
    ) -> str | None:
        """Returns why a request is refused, None if it is not.

        Another host: a name that somebody else has made to point at this machine (DNS rebinding). Another origin: another page in the
        same browser. No token: another program or user on this machine, or an old address.
        """
        if headers.get("host") not in self.hosts:
            return "this is not an address of the studio"
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{host}" for host in self.hosts}:
            return "another page may not use the studio"
        if needs_token and not (
            token
            and secrets.compare_digest(token.encode("utf-8", "surrogatepass"), self.token.encode())
        ):
            return "the address has no token, or an old one: open the address that `sjdsl studio` has printed"
        return None


def kept_token(folder: Path | None) -> str:
    """Returns the token of this user, made at the first call: a page finds a server that was started again.

    folder: where it is kept, in a file that nobody else can read. Without one, where none can be written, or where others can read it,
    the token is new.
    """
    if folder is None:
        return secrets.token_urlsafe(SHORTEST)
    path = folder / TOKEN
    try:
        token = path.read_text(encoding="ascii")
        if path.stat().st_mode & 0o077 == 0 and len(token) >= SHORTEST:
            return token
        path.unlink()
    except (OSError, UnicodeDecodeError):
        pass
    token = secrets.token_urlsafe(SHORTEST)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        with open(
            os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600), "w", encoding="ascii"
        ) as file:
            file.write(token)
    return token
