"""`models.toml`: what is read, and what is refused with its place and a repair."""

from pathlib import Path

import pytest

from sjdsl.models import ModelSettings, Price, load_models

LUNA = """
[luna]
url = "https://api.example.com/v1"
model = "gpt-6-luna"
key = "EXAMPLE_KEY"
price = { input = 0.1, output = 0.5 }
extra = { reasoning_effort = "low" }

[nobody]
kind = "fake"
"""


def load(tmp_path: Path, text: str) -> dict[str, ModelSettings]:
    path = tmp_path / "models.toml"
    path.write_text(text, encoding="utf-8")
    return load_models(path)


def test_models_are_read(tmp_path: Path) -> None:
    models = load(tmp_path, LUNA)
    assert models["nobody"] == ModelSettings("nobody", kind="fake")
    luna = models["luna"]
    assert luna.price == Price(input=0.1, output=0.5, cached=0.1)
    assert (luna.schema, luna.max_tokens) == ("strict", 4000)
    assert luna.extra == {"reasoning_effort": "low"}


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[luna", "this is no TOML"),
        ("luna = 3", "luna: a model is a table, such as \\[luna\\]"),
        ('["Luna+x"]\nkind = "fake"', "a name has small letters"),
        ('[a]\nkind = "fak"', "`kind` is one of openai, fake, not 'fak'"),
        ('[a]\nkind = "fake"\nmodel = "x"', "a fake model doesn't read `model`; remove it"),
        ('[a]\nurls = "x"', "there is no key `urls`; did you mean `url`?"),
        ('[a]\nurl = "https://x"', "`model` is missing"),
        ('[a]\nurl = "x.com"\nmodel = "m"', "`url` begins with https:// or http://, not 'x.com'"),
        ("[a]\nmax_tokens = true", "`max_tokens` is a whole number, not True"),
        ('[a]\nkind = "openai"\nmax_tokens = 0', "`max_tokens` is at least 1, not 0"),
        ("[a]\nprice = { input = -1 }", "`price.input` is dollars a million tokens"),
        ("[a]\nprice = { input = inf }", "`price.input` is dollars a million tokens"),
        ("[a]\nprice = { inputs = 1 }", "there is no price `inputs`; did you mean `input`?"),
        ("[a]\nprice = { input = 1 }", "`price.output` is missing"),
    ],
)
def test_mistakes_are_refused(tmp_path: Path, text: str, problem: str) -> None:
    with pytest.raises(ValueError, match=problem.replace("?", "\\?")):
        load(tmp_path, text)


def test_a_key_that_stands_in_the_file_is_not_repeated(tmp_path: Path) -> None:
    text = LUNA.replace("EXAMPLE_KEY", "sk-secret-1234")
    with pytest.raises(ValueError, match="never the key itself") as refused:
        load(tmp_path, text)
    assert "secret" not in str(refused.value)
