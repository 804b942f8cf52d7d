"""A bare install: what it does without any extra, and that all else says which extra it needs, before it begins."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

REPOSITORY = Path(__file__).parents[2]
EXTRAS = tomllib.loads((REPOSITORY / "pyproject.toml").read_text("utf-8"))["project"][
    "optional-dependencies"
]
# What extras bring, by the names that are imported: none of them is there.
ABSENT = (
    "PIL",
    "resvg_py",
    "matplotlib",
    "pygls",
    "lsprotocol",
    "starlette",
    "uvicorn",
    "websockets",
    "av",
    "pandas",
    "rliable",
    "hypothesis",
)
BARE = f"import sys\nfor name in {ABSENT}: sys.modules[name] = None\nfrom sjdsl.cli import run\n"
NEEDS = {
    "render coins -o a.gif": "pictures",
    "render coins -o a.png": "pictures",
    "render coins -o a.mp4": "video",
    "plot runs/a": "plots",
    "report runs": "results",
    "crossplay coins --slots stay,stay": "plots",
    "schelling coins --cooperators stay --defectors random": "plots",
    "studio": "studio",
    "lsp": "editor",
    "train coins --log wandb --run runs/new": "wandb",
}
WORK = """
import jax, sjdsl, sjdsl.trainers
env = sjdsl.make("coins")
observation, state = env.reset(jax.random.key(0))
env.step(jax.random.key(1), state, jax.numpy.zeros(env.num_agents, int))
small = [part for text in ("total_timesteps=64", "num_envs=4", "num_steps=8", "num_minibatches=1", "network=mlp", "network_width=4") for part in ("--set", text)]
for call in (
    ["new", "pond"], ["check", "pond.sj"], ["fmt", "pond.sj"], ["compile", "pond.sj"], ["test", "pond.sj", "--examples", "5"], ["list"],
    ["doc", "pond.sj"], ["trace", "pond.sj", "--steps", "2"], ["render", "pond.sj", "-o", "pond.html", "--steps", "2"],
    ["train", "pond.sj", *small, "--run", "run", "--episodes", "2", "--param", "length=8"],
):
    assert run(call) == 0, call
"""


def bare(program: str, folder: Path) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, "-c", BARE + program],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_what_is_missing_is_named_with_its_extra(tmp_path: Path) -> None:
    calls = "\n".join(f"print({call!r}, run({call.split()!r}), file=sys.stderr)" for call in NEEDS)
    done = bare(calls, tmp_path)
    assert done.returncode == 0, done.stderr
    said = [
        line
        for line in done.stderr.splitlines()
        if line.startswith("error: ") or line.endswith((" 0", " 1", " 2"))
    ]
    for (call, extra), error, status in zip(NEEDS.items(), said[::2], said[1::2], strict=True):
        assert extra in EXTRAS
        assert error.endswith(f"is needed: pip install 'sjdsl[{extra}]'"), error
        assert status == f"{call} 1"
    assert [*tmp_path.iterdir()] == []


@pytest.mark.thorough
def test_a_bare_install_makes_checks_compiles_tests_and_trains(tmp_path: Path) -> None:
    done = bare(WORK, tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert (
        "no learning curve was drawn: the package matplotlib is needed: pip install 'sjdsl[plots]'"
        in done.stdout
    )
    assert (tmp_path / "run/policies/last.safetensors").is_file()
