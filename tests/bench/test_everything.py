"""All that is measured on a device: in order, within its time, with nothing lost; figures are read back as they were."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from bench.speed.__main__ import main
from bench.speed.everything import Part, Plan, joined, measure_everything, parts_of, read_parts
from bench.speed.kernels import Kernels, StepKernels
from bench.speed.resuming import Resume, differences
from bench.speed.stored import Found, read_found
from bench.speed.sweep import Sweep
from bench.speed.tables import tables_of
from bench.speed.training import Split, Training
from sjdsl.bench import Compilation, Report, Speed, game_task
from sjdsl.bench.stored import write_found
from sjdsl.runtime.env import Environment

MACHINE = {"platform": "gpu", "device": "a device", "cpu_cores": 2, "python": "3", "jax": "0", "sjdsl": "0", "compilation_cache": False}


def speeds(num_envs: int, peak: int | None = None) -> Report:
    speed = Speed("meadow", 2, "tokens", None, num_envs, 2e5, 1e5, 3e5, 2.0, 1.0, 100)
    return Report(MACHINE, 3, (speed,), (Compilation("meadow", 2, "tokens", 1.5, 10, {"sort": 0}),), peak)


SPLIT = Split("meadow", 2, "mlp", 4, 8, 1.0, (1.0, 2.0), (0.1,), (0.2,), (0.3,), 1e6, "mappo", "per_agent")
TRAINING = Training(MACHINE, 1e9, (SPLIT,), 10**9, ("meadow, mlp, vdn, shared: no memory",))
KERNELS = Kernels(MACHINE, 4e9, (StepKernels("meadow", 2, "tokens", 1000, 12, 5000.0, 2000.0, (1e-3,)),))
RESUME = Resume(MACHINE, "meadow", 40, 20, "--flag", ("loss",), 3.0)
SWEEP = Sweep(MACHINE, "meadow", "apple", 64, 16, 2.0, (4e5, 5e5), 10, (1.0, 3.0), (2e5, 2e5), 1.5, (5e5, 5e5))


class Clock:
    """Seconds that pass only when a part takes them."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now

    def part(self, name: str, seconds: float, found: Callable[[], Found] = lambda: speeds(1), sort: str = "speed") -> Part:
        def measure() -> Found:
            self.now += seconds
            return found()

        return Part(name, sort, f"{sort}.json", measure)


def fail() -> Found:
    raise RuntimeError("out of memory")


@pytest.mark.parametrize("found", [speeds(8, 7), speeds(8), TRAINING, KERNELS, RESUME, SWEEP])
def test_figures_are_read_back_as_they_were(found: Found, tmp_path: Path) -> None:
    write_found(tmp_path / "figures.json", found)
    assert read_found(tmp_path / "figures.json") == found
    assert tables_of(read_found(tmp_path / "figures.json")) == tables_of(found)
    assert [path.name for path in tmp_path.iterdir()] == ["figures.json"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"sort": "report"}', '{"sort": "speed of light"}'])
def test_other_files_are_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "figures.json").write_text(text)
    with pytest.raises(ValueError, match="holds no figures that sjdsl bench wrote"):
        read_found(tmp_path / "figures.json")


def test_what_does_not_fit_is_left_out_and_the_rest_goes_on(tmp_path: Path) -> None:
    """Six minutes: a second part as long as the first would not fit, a shorter one of another sort does."""
    clock = Clock()
    parts = [clock.part("long", 200), clock.part("as long", 200), clock.part("short", 30, lambda: KERNELS, "kernels")]
    done = measure_everything(parts, tmp_path / "new", 6, "make gpu", clock, lambda _: None)
    assert [(part.name, part.status, part.seconds) for part in done] == [
        ("long", "measured", 200),
        ("as long", "no time left", 0),
        ("short", "measured", 30),
    ]
    assert read_parts(tmp_path / "new") == ("make gpu", done)
    assert read_found(tmp_path / "new" / "speed.json") == speeds(1)


def test_a_part_that_fails_costs_no_other(tmp_path: Path) -> None:
    clock = Clock()
    parts = [clock.part("a", 1), clock.part("b", 1, fail), clock.part("c", 1, lambda: speeds(8))]
    done = measure_everything(parts, tmp_path, 1, "make gpu", clock, lambda _: None)
    assert [part.status for part in done] == ["measured", "failed: RuntimeError: out of memory", "measured"]
    found = read_found(tmp_path / "speed.json")
    assert isinstance(found, Report)
    assert [speed.num_envs for speed in found.speeds] == [1, 8]


def test_figures_of_one_sort_are_joined() -> None:
    both = joined(speeds(1, 5), speeds(8, 3))
    assert isinstance(both, Report)
    assert ([speed.num_envs for speed in both.speeds], both.device_peak_bytes) == ([1, 8], 5)
    trained = joined(TRAINING, TRAINING)
    assert isinstance(trained, Training)
    assert len(trained.splits) == 2
    with pytest.raises(TypeError, match="not measurements of one sort"):
        joined(TRAINING, speeds(1))


def test_the_plan_begins_with_what_tells_most(meadow_env: Environment) -> None:
    parts = list(parts_of(Plan([game_task(meadow_env)], (4, 8), 1, "meadow.sj", convolutional=3), lambda _: None))
    assert [part.name for part in parts] == [
        "speed of 4 environments, tokens",
        "speed of 8 environments, tokens",
        "kernels",
        "resuming",
        "training of meadow, mlp",
        "training of meadow, cnn",
    ]


def test_a_page_is_made_of_the_folder(tmp_path: Path) -> None:
    """Only from files: nothing is measured. What is missing is named."""
    clock = Clock()
    parts = [
        clock.part("few", 1),
        clock.part("many", 1, fail),
        clock.part("k", 1, lambda: KERNELS, "kernels"),
        clock.part("r", 1, lambda: RESUME, "resuming"),
    ]
    measure_everything(parts, tmp_path / "gpu", 1, "make gpu", clock, lambda _: None)
    page = tmp_path / "page.md"
    asked = ["tables", str(tmp_path / "gpu"), "--markdown", str(page)]
    assert CliRunner().invoke(main, asked).exit_code == 0
    text = page.read_text()
    for part in ("<!-- speed gpu -->\n`make gpu`, on a device", "not measured: many (failed", "<!-- kernels gpu -->", "50.0%", "no: loss"):
        assert part in text
    page.write_text("<!-- speed gpu -->\n<!-- end speed gpu -->\n")
    assert "kernels gpu" in CliRunner().invoke(main, asked).output
    assert "holds no figures" in CliRunner().invoke(main, ["tables", str(tmp_path)]).output


def test_runs_differ_where_a_number_does(tmp_path: Path) -> None:
    """Columns of the clock do not count; a policy counts as its bytes."""
    rows = [{"update": 1, "loss": 0.5, "seconds": 1.0}, {"update": 2, "loss": 0.25, "seconds": 2.0}]
    for name, clock in (("whole", 0.0), ("resumed", 5.0)):
        folder = tmp_path / name / "policies"
        folder.mkdir(parents=True)
        lines = [json.dumps({**row, "seconds": row["seconds"] + clock}) for row in rows]
        (tmp_path / name / "metrics.jsonl").write_text("\n".join(lines) + "\n")
        (folder / "2.safetensors").write_bytes(b"numbers")
    assert differences(tmp_path / "whole", tmp_path / "resumed") == ()
    (tmp_path / "resumed" / "policies" / "2.safetensors").write_bytes(b"others")
    lines[1] = json.dumps({**rows[1], "loss": 0.26})
    (tmp_path / "resumed" / "metrics.jsonl").write_text("\n".join(lines) + "\n")
    assert differences(tmp_path / "whole", tmp_path / "resumed") == ("loss", "policies/2.safetensors")
    (tmp_path / "resumed" / "metrics.jsonl").write_text(lines[0] + "\n" + lines[1][:10])
    assert differences(tmp_path / "whole", tmp_path / "resumed")[0] == "2 and 1 rows of metrics"
