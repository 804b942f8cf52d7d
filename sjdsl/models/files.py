"""Models by name: the tables of a `models.toml`."""

import json
import os
import re
import tomllib
from collections.abc import Mapping
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal
from urllib.parse import urlsplit

from pydantic import (
    ConfigDict,
    NonNegativeFloat,
    NonNegativeInt,
    PositiveFloat,
    PositiveInt,
    TypeAdapter,
    ValidationError,
    field_validator,
)
from pydantic.dataclasses import dataclass

from sjdsl.files import read_bytes
from sjdsl.models.errors import ModelError
from sjdsl.models.openai_server import OpenAIProvider, Schema
from sjdsl.models.policy import HostPolicy, Message, Reply
from sjdsl.models.providers import FakeProvider, LanguagePolicy
from sjdsl.near_names import meant
from sjdsl.told.message import HISTORY

# fields of a request that `extra` may not change
REQUEST = {"model", "messages", "max_tokens", "max_completion_tokens", "n", "stream"}
LARGEST = 2**20  # bytes of a file of models, and of a key
STRICT = ConfigDict(extra="forbid")
VARIABLE = re.compile(r"[A-Z_][A-Z0-9_]*")
MILLION = 10**6


@dataclass(frozen=True, config=STRICT)
class Price:
    """Dollars for a million tokens; `cached`: of the input, those that the server had cached."""

    input: NonNegativeFloat
    output: NonNegativeFloat
    cached: NonNegativeFloat | None = None


@dataclass(frozen=True, config=STRICT)
class KeyFile:
    """A file that holds a key and nothing else."""

    file: str


@dataclass(frozen=True, config=STRICT)
class Model(HostPolicy):
    """A language model that plays, as a table of `models.toml` describes it.

    key: where its key is: the name of an environment variable, or a file. Empty: it needs none.
    url, model, schema, max_tokens, limit, timeout, retries, extra: of `OpenAIProvider`.
    kind: `fake` answers by a hash of the message.
    notebook, ledger, history, role: of `HostPolicy`.
    """

    name: str = ""
    kind: Literal["openai", "fake"] = "openai"
    url: str = ""
    model: str = ""
    key: str | KeyFile = ""
    schema: Schema = "strict"
    max_tokens: PositiveInt = 4000
    limit: Literal["max_completion_tokens", "max_tokens"] = "max_completion_tokens"
    timeout: PositiveFloat = 600
    retries: NonNegativeInt = 8
    price: Price | None = None
    extra: dict[str, Any] = field(default_factory=dict, hash=False)
    notebook: bool = True
    ledger: bool = True
    history: PositiveInt = HISTORY
    role: str = ""

    @field_validator("key")
    @classmethod
    def _is_a_place(cls, key: str | KeyFile) -> str | KeyFile:
        if isinstance(key, str) and key and not VARIABLE.fullmatch(key):
            raise ValueError(
                "the name of an environment variable, such as OPENAI_API_KEY, or a file, "
                '{ file = "PATH" }; never the key itself'
            )
        return key

    @field_validator("extra")
    @classmethod
    def _leaves_ours_alone(cls, extra: dict[str, Any]) -> dict[str, Any]:
        taken = sorted(extra.keys() & REQUEST)
        if taken:
            raise ValueError(f"fields other than `{taken[0]}`, which sjdsl sets itself")
        try:
            json.dumps(extra)
        except TypeError as error:
            raise ValueError(f"what JSON can carry: {error}") from None
        return extra

    @field_validator("url")
    @classmethod
    def _has_no_password(cls, url: str) -> str:
        if url and (urlsplit(url).scheme not in ("http", "https") or urlsplit(url).password):
            raise ValueError("the address of a server, http:// or https://, without a password")
        return url

    def __post_init__(self) -> None:
        if self.kind == "openai" and not (self.url and self.model):
            raise ModelError(f"the model {self.name} needs a `url` and a `model`")

    def as_role(self, role: str) -> "Model":
        """Returns it as a player of a part (`sjdsl.models.roles`)."""
        return replace(self, role=role)

    def settings(self) -> dict[str, Any]:
        """Returns what its replies depend on, as JSON values, without its key."""
        adapter = TypeAdapter(Model)
        without = {"name", "key", "timeout", "retries", "price"}
        return adapter.dump_python(self, mode="json", exclude=without)  # type: ignore[no-any-return]

    def dollars(self, input: int, cached: int, output: int) -> float:
        """Returns the price of tokens: sent, of these cached, and answered; 0 without a price."""
        if self.price is None:
            return 0.0
        price = self.price
        of_cached = price.input if price.cached is None else price.cached
        total = price.input * (input - cached) + of_cached * cached + price.output * output
        return total / MILLION

    def decide(self, agent: int, message: Message) -> Reply:
        """Asks the model what an agent does."""
        return self._policy.decide(agent, message)

    def revise(self, agent: int, message: Message) -> Reply:
        """Asks the model for an agent's notes after a trial."""
        return self._policy.revise(agent, message)

    @cached_property
    def _policy(self) -> LanguagePolicy:
        if self.kind == "fake":
            return LanguagePolicy(FakeProvider(), self.notebook)
        provider = OpenAIProvider(
            url=self.url,
            model=self.model,
            key=self._secret(),
            schema=self.schema,
            max_tokens=self.max_tokens,
            limit=self.limit,
            timeout=self.timeout,
            retries=self.retries,
            extra=self.extra,
        )
        return LanguagePolicy(provider, self.notebook)

    def _secret(self) -> str:
        """Returns the key. Raises ModelError if it isn't where it should be, or can't be sent."""
        secret = self._read_secret()
        if not (secret.isascii() and secret.isprintable()):
            raise ModelError(f"{self.name}: its key has characters that a request can't carry")
        return secret

    def _read_secret(self) -> str:
        if isinstance(self.key, KeyFile):
            try:
                return read_bytes(Path(self.key.file).expanduser(), LARGEST).decode().strip()
            except (OSError, UnicodeError):
                raise ModelError(
                    f"{self.name}: the key file {self.key.file} can't be read"
                ) from None
        if self.key and self.key not in os.environ:
            raise ModelError(f"{self.name}: the environment variable {self.key} isn't set")
        return os.environ[self.key] if self.key else ""


def load_models(path: Path | str) -> dict[str, Model]:
    """Returns the models of a file by name: a table each, with the fields of `Model`.

    Raises:
      ModelError: there is no such file, or a table is wrong.
    """
    try:
        tables = tomllib.loads(read_bytes(Path(path), LARGEST).decode())
    except OSError as error:
        raise ModelError(f"{path} can't be read: {error.strerror}") from None
    except (UnicodeError, tomllib.TOMLDecodeError) as error:
        raise ModelError(f"{path} is not TOML: {error}") from None
    return {name: _model(path, name, table) for name, table in tables.items()}


def _model(path: Path | str, name: str, table: Any) -> Model:
    if not isinstance(table, Mapping):
        raise ModelError(f"{path}: `{name}` is not a table; write [{name}] above its fields")
    try:
        return TypeAdapter(Model).validate_python({"name": name, **table})
    except ValidationError as error:
        # The input may hold a key.
        fault = error.errors(include_input=False, include_context=False, include_url=False)[0]
        place = ".".join(map(str, fault["loc"]))
        raise ModelError(f"{path}: [{name}] {place}: {fault['msg']}") from None


def is_model_name(name: str) -> bool:
    """Returns whether a text is of the form `FILE.toml:NAME` or `FILE.toml:NAME+ROLE`."""
    file, colon, _ = name.rpartition(":")
    return bool(colon) and file.endswith(".toml")


def find_model(name: str) -> Model:
    """Returns the model of `FILE.toml:NAME`, in a role with `+ROLE`.

    Raises:
      ModelError: there is none.
    """
    file, _, model_and_role = name.rpartition(":")
    model, _, role = model_and_role.partition("+")
    models = load_models(file)
    if model not in models:
        raise ModelError(f"{file} has no model `{model}`{meant(model, models, 'its models are')}")
    return models[model].as_role(role)
