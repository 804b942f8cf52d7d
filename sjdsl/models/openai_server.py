"""Asks any OpenAI-compatible server through the package `openai`."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from sjdsl.extras import needs
from sjdsl.models.errors import ModelError, Unanswered
from sjdsl.models.policy import Answer, Message
from sjdsl.models.replies import whole_characters

if TYPE_CHECKING:
    from openai import OpenAI

Schema = Literal["strict", "json", "none"]
UNREACHED = ("ConnectError", "ConnectTimeout")  # of httpx or httpx2, as the package chooses
NO_KEY = "none"  # a server on this machine asks for none; the package wants some text


@dataclass(frozen=True)
class OpenAIProvider:
    """A model of a server.

    key: the secret itself, which is in no text that this returns or raises.
    schema: how the form of a reply is asked for: by a JSON schema, as JSON, or in the text alone.
    limit: the name of the request's field for the most tokens of an answer.
    retries: of the package, after 408, 409, 429, 5xx and lost connections; timeout: in seconds.
    extra: further fields of the request.
    """

    url: str
    model: str
    key: str
    schema: Schema = "strict"
    max_tokens: int = 4000
    limit: str = "max_completion_tokens"
    timeout: float = 600
    retries: int = 8
    extra: Mapping[str, Any] | None = None

    def __repr__(self) -> str:
        return f"OpenAIProvider({self.url!r}, {self.model!r})"

    @cached_property
    def _client(self) -> "OpenAI":
        with needs("models"):
            from openai import DefaultHttpxClient, OpenAI

        class PlainClient(OpenAI):
            """Adds nothing of this machine, such as `OPENAI_ORG_ID`, to a request."""

            @property
            def default_headers(self) -> dict[str, Any]:
                """Returns the headers of every request."""
                return {
                    "Accept": "application/json",
                    "Content-Type": "application/json",
                    "User-Agent": "sjdsl",
                }

        # With `api_key=None` the package would send the key of OpenAI to any server.
        return PlainClient(
            api_key=self.key or NO_KEY,
            base_url=self.url,
            timeout=self.timeout,
            max_retries=self.retries,
            http_client=DefaultHttpxClient(follow_redirects=False),
        )

    def complete(self, message: Message, schema: Mapping[str, Any]) -> Answer:
        """Returns the model's answer; an empty one if the server sends something else.

        Raises:
          Unanswered: the server was reached, and no answer came.
          ModelError: the server refuses the request, or can't be reached.
          MissingExtra: the package isn't installed.
        """
        client = self._client
        from openai import APIConnectionError, APIStatusError, OpenAIError

        fields: dict[str, Any] = {**(self.extra or {}), self.limit: self.max_tokens}
        if self.schema == "strict":
            form = {"name": "reply", "strict": True, "schema": schema}
            fields["response_format"] = {"type": "json_schema", "json_schema": form}
        elif self.schema == "json":
            fields["response_format"] = {"type": "json_object"}
        kind = ModelError
        try:
            completion = client.chat.completions.create(
                model=self.model,
                messages=[
                    {"role": "system", "content": message.system},
                    {"role": "user", "content": message.text},
                ],
                extra_body=fields,
            )
            return self._answer(completion)
        except APIStatusError as error:
            problem = f"the server refuses the request with {error.status_code}: {error.message}"
        except APIConnectionError as error:
            problem = f"no answer within {self.retries + 1} attempts: {error.message}"
            if type(error.__cause__).__name__ not in UNREACHED:
                kind = Unanswered
        except OpenAIError as error:
            problem = str(error)
        except ValueError:  # not JSON
            return Answer("", finish="not a completion")
        # `from None`: the error has the request, and the request the key.
        raise kind(f"{self.model} at {self.url}: {self._without_key(problem)}") from None

    def _answer(self, completion: Any) -> Answer:
        choices = getattr(completion, "choices", None)
        if not isinstance(choices, list) or not choices:
            return Answer("", finish="not a completion")
        # The package doesn't check what a server sends.
        said = getattr(choices[0], "message", None)
        usage = getattr(completion, "usage", None)
        details = getattr(usage, "prompt_tokens_details", None)
        return Answer(
            text=self._text(said, "content"),
            reasoning=self._text(said, "reasoning_content"),
            model=self._text(completion, "model"),
            finish=self._text(choices[0], "finish_reason"),
            input=_count(usage, "prompt_tokens"),
            cached=_count(details, "cached_tokens"),
            output=_count(usage, "completion_tokens"),
        )

    def _text(self, thing: Any, name: str) -> str:
        """Returns a text that a server sent, without the key; empty if it sent something else."""
        text = getattr(thing, name, None)
        return self._without_key(whole_characters(text)) if isinstance(text, str) else ""

    def _without_key(self, text: str) -> str:
        return text.replace(self.key, "[key]") if self.key else text


def _count(thing: Any, name: str) -> int:
    """Returns a number of tokens that a server sent; 0 if it sent something else."""
    number = getattr(thing, name, None)
    return number if isinstance(number, int) and number > 0 else 0
