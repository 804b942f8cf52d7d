"""Reads `models.toml`, which names language models and says how they are asked.

[luna]
url = "https://api.openai.com/v1"     # any server with OpenAI's protocol
model = "gpt-6-luna"
key = "OPENAI_API_KEY"                # the environment variable with the key; never the key itself
schema = "strict"                     # or "json", "none": how the form of a reply is asked for
max_tokens = 4000                     # of a reply
price = { input = 0.1, cached = 0.01, output = 0.5 }   # dollars a million tokens
extra = { reasoning_effort = "low" }  # passed on as it is

[nobody]
kind = "fake"                         # answers by a hash of the message, without a network
"""

import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sjdsl.files import MEGABYTE, read_bytes
from sjdsl.near_names import meant

KINDS = ("openai", "fake")
SCHEMAS = ("strict", "json", "none")
# The keys of a model, each with the type of its value.
KEYS: dict[str, type] = {
    "kind": str,
    "url": str,
    "model": str,
    "key": str,
    "schema": str,
    "max_tokens": int,
    "price": dict,
    "extra": dict,
}
PRICES = ("input", "cached", "output")
MEANS = {str: "text", int: "a whole number", dict: "a table"}
NAME = re.compile(r"[a-z][a-z0-9_-]*")
VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
MAX_TOKENS = 4000


@dataclass(frozen=True)
class Price:
    """Dollars a million tokens."""

    input: float
    output: float
    cached: float


@dataclass(frozen=True)
class ModelSettings:
    """How a language model is asked. The keys of `models.toml`, explained above.

    url, model: empty for a fake one. price: None if it isn't counted.
    """

    name: str
    kind: str = "openai"
    url: str = ""
    model: str = ""
    key: str = ""
    schema: str = "strict"
    max_tokens: int = MAX_TOKENS
    price: Price | None = None
    extra: Mapping[str, Any] = field(default_factory=dict)


def load_models(path: str | Path) -> dict[str, ModelSettings]:
    """Returns the models of a file by name.

    Raises:
      OSError: it can't be read.
      ValueError: it is no TOML, or a model has an unknown key, a wrong value or lacks one.
    """
    path = Path(path)
    try:
        tables = tomllib.loads(read_bytes(path, MEGABYTE).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: this is no TOML: {error}") from None
    return {name: _settings(name, table, f"{path}: {name}") for name, table in tables.items()}


def _settings(name: str, table: Any, place: str) -> ModelSettings:
    if not isinstance(table, dict):
        raise ValueError(f"{place}: a model is a table, such as [{name}]")
    if not NAME.fullmatch(name):
        raise ValueError(f"{place}: a name has small letters, digits, `-` and `_`, such as `luna`")
    for key, value in table.items():
        if key not in KEYS:
            raise ValueError(f"{place}: there is no key `{key}`{meant(key, KEYS, 'the keys are')}")
        if not isinstance(value, KEYS[key]) or isinstance(value, bool):
            raise ValueError(f"{place}: `{key}` is {MEANS[KEYS[key]]}, not {value!r}")
    price = table.get("price")
    settings = ModelSettings(
        name, **{**table, "price": None if price is None else _price(price, place)}
    )
    _check(settings, table, place)
    return settings


def _check(settings: ModelSettings, table: Mapping[str, Any], place: str) -> None:
    for key, value, known in (
        ("kind", settings.kind, KINDS),
        ("schema", settings.schema, SCHEMAS),
    ):
        if value not in known:
            raise ValueError(f"{place}: `{key}` is one of {', '.join(known)}, not {value!r}")
    if settings.max_tokens < 1:
        raise ValueError(f"{place}: `max_tokens` is at least 1, not {settings.max_tokens}")
    if settings.kind == "fake":
        unread = [key for key in table if key != "kind"]
        if unread:
            raise ValueError(f"{place}: a fake model doesn't read `{unread[0]}`; remove it")
        return
    for key in ("url", "model"):
        if not table.get(key):
            raise ValueError(f"{place}: `{key}` is missing")
    if not settings.url.startswith(("http://", "https://")):
        raise ValueError(f"{place}: `url` begins with https:// or http://, not {settings.url!r}")
    if settings.key and not VARIABLE.fullmatch(settings.key):
        # The value isn't repeated: it may be a key.
        raise ValueError(
            f"{place}: `key` is the name of an environment variable, such as OPENAI_API_KEY, "
            "never the key itself"
        )


def _price(table: Mapping[str, Any], place: str) -> Price:
    for key, value in table.items():
        if key not in PRICES:
            raise ValueError(
                f"{place}: there is no price `{key}`{meant(key, PRICES, 'the prices are')}"
            )
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        if not is_number or not 0 <= value < math.inf:
            raise ValueError(
                f"{place}: `price.{key}` is dollars a million tokens, 0 or more, not {value!r}"
            )
    for key in ("input", "output"):
        if key not in table:
            raise ValueError(f"{place}: `price.{key}` is missing")
    return Price(
        float(table["input"]), float(table["output"]), float(table.get("cached", table["input"]))
    )
