"""Who may talk to the studio: a browser on this machine, from the studio's page, with its token."""

import contextlib
import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

HOST = "127.0.0.1"
TOKEN_FILE = "studio_token"  # in the cache folder
TOKEN_LENGTH = 32  # characters of a token, at least


@dataclass(frozen=True)
class Access:
    """What a request has to prove. port: of the server; token: a secret."""

    port: int
    token: str

    @property
    def address(self) -> str:
        """The address of the page, with the token."""
        return f"http://{HOST}:{self.port}/?token={self.token}"

    @property
    def hosts(self) -> frozenset[str]:
        """The values of the header Host that mean this server."""
        return frozenset(f"{name}:{self.port}" for name in (HOST, "localhost"))

    def refusal(
        self, headers: Mapping[str, str], token: str | None, needs_token: bool = True
    ) -> str | None:
        """Returns why a request is refused, None if it is allowed.

        Another host is a name that somebody else has pointed at this machine (DNS rebinding),
        another origin another page in the same browser. A request without the token comes from
        another program or user on this machine, or uses an old address.
        """
        if headers.get("host") not in self.hosts:
            return "this is not an address of the studio"
        origin = headers.get("origin")
        if origin is not None and origin not in {f"http://{host}" for host in self.hosts}:
            return "another page may not use the studio"
        sent = (token or "").encode("utf-8", "surrogatepass")
        if needs_token and not secrets.compare_digest(sent, self.token.encode()):
            return (
                "the address has no token, or an old one: open the address that `sjdsl studio` has "
                "printed"
            )
        return None


def kept_token(folder: Path | None) -> str:
    """Returns the token of this user, so that an open page finds a server that was started again.

    It is new at the first call, without a folder, if it can't be stored, or if others can read it.

    Args:
      folder: where it is stored, in a file that nobody else can read.
    """
    if folder is None:
        return secrets.token_urlsafe(TOKEN_LENGTH)
    path = folder / TOKEN_FILE
    try:
        token = path.read_text(encoding="ascii")
        if path.stat().st_mode & 0o077 == 0 and len(token) >= TOKEN_LENGTH:
            return token
        path.unlink()
    except (OSError, UnicodeDecodeError):
        pass
    token = secrets.token_urlsafe(TOKEN_LENGTH)
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600)
        with open(descriptor, "w", encoding="ascii") as file:
            file.write(token)
    return token
