"""All that is measured on a device: in order, with nothing lost; figures are read back as they were."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from bench.speed.__main__ import main
from bench.speed.everything import Part, measure_everything
from bench.speed.kernels import Kernels, StepKernels
from bench.speed.resuming import Resume, differences
from bench.speed.stored import Figures, joined, read_figures
from bench.speed.sweep import Sweep
from bench.speed.tables import tables_of
from bench.speed.training import Split, Training
from sjdsl.bench import Compilation, Report, Speed
from sjdsl.bench.stored import write_figures

MACHINE = {
    "platform": "gpu",
    "device": "a device",
    "cpu_cores": 2,
    "devices": 1,
    "python": "3",
    "jax": "0",
    "sjdsl": "0",
    "compilation_cache": False,
}


def speeds(num_envs: int, peak: int | None = None) -> Report:
    speed = Speed("meadow", 2, "tokens", None, num_envs, 2e5, 1e5, 3e5, 2.0, 1.0, 100, 1e5)
    return Report(
        MACHINE, 3, (speed,), (Compilation("meadow", 2, "tokens", 1.5, 10, {"sort": 0}),), peak
    )


SPLIT = Split(
    "meadow", 2, "mlp", 4, 8, 1.0, (1.0, 2.0), (0.1,), (0.2,), (0.3,), 1e6, "mappo", "per_agent"
)
TRAINING = Training(MACHINE, 1e9, (SPLIT,), 10**9, ("meadow, mlp, vdn, shared: no memory",))
KERNELS = Kernels(
    MACHINE, 4e9, (StepKernels("meadow", 2, "tokens", 1000, 12, 5000.0, 2000.0, (1e-3,)),)
)
RESUME = Resume(MACHINE, "meadow", 40, 20, "--flag", ("loss",), 3.0)
SWEEP = Sweep(
    MACHINE, "meadow", "apple", 64, 16, 2.0, (4e5, 5e5), 10, (1.0, 3.0), (2e5, 2e5), 1.5, (5e5, 5e5)
)


def fail() -> Figures:
    raise RuntimeError("out of memory")


@pytest.mark.parametrize("found", [speeds(8, 7), speeds(8), TRAINING, KERNELS, RESUME, SWEEP])
def test_figures_are_read_back_as_they_were(found: Figures, tmp_path: Path) -> None:
    write_figures(tmp_path / "figures.json", found)
    assert read_figures(tmp_path / "figures.json") == found
    assert tables_of(read_figures(tmp_path / "figures.json")) == tables_of(found)
    assert [path.name for path in tmp_path.iterdir()] == ["figures.json"]


@pytest.mark.parametrize(
    "text", ["", "[]", "{}", '{"sort": "report"}', '{"sort": "speed of light"}']
)
def test_other_files_are_refused(text: str, tmp_path: Path) -> None:
    (tmp_path / "figures.json").write_text(text)
    with pytest.raises(ValueError, match="holds no figures that sjdsl bench wrote"):
        read_figures(tmp_path / "figures.json")


def test_what_was_measured_survives_a_failure_and_a_stop(tmp_path: Path) -> None:
    def stop() -> Figures:
        raise KeyboardInterrupt

    parts = [
        Part("few", lambda: speeds(1)),
        Part("many", fail),
        Part("kernels", lambda: KERNELS),
        Part("last", stop),
    ]
    failed = measure_everything(parts[:3], tmp_path / "whole", lambda _: None)
    assert failed == ["many failed: RuntimeError: out of memory"]
    with pytest.raises(KeyboardInterrupt):
        measure_everything(parts, tmp_path / "stopped", lambda _: None)
    for folder in ("whole", "stopped"):
        assert {path.name: read_figures(path) for path in (tmp_path / folder).iterdir()} == {
            "01_few.json": speeds(1),
            "03_kernels.json": KERNELS,
        }


def test_figures_of_one_sort_are_joined() -> None:
    both = joined(speeds(1, 5), speeds(8, 3))
    assert isinstance(both, Report)
    assert ([speed.num_envs for speed in both.speeds], both.device_peak_bytes) == ([1, 8], 5)
    trained = joined(TRAINING, TRAINING)
    assert isinstance(trained, Training)
    assert len(trained.splits) == 2
    with pytest.raises(ValueError, match="two files hold figures of one report"):
        joined(TRAINING, speeds(1))


def test_a_page_is_made_of_the_files(tmp_path: Path) -> None:
    """Nothing is measured; figures of one section are joined, and what no mark is for is refused."""
    parts = [
        Part("few", lambda: speeds(1)),
        Part("many", lambda: speeds(8)),
        Part("kernels", lambda: KERNELS),
        Part("r", lambda: RESUME),
    ]
    measure_everything(parts, tmp_path / "gpu", lambda _: None)
    page = tmp_path / "page.md"
    page.write_text(
        "".join(
            f"<!-- {what} gpu -->\n<!-- end {what} gpu -->\n"
            for what in ("speed", "kernels", "resuming")
        )
    )
    asked = [
        "tables",
        *(str(path) for path in sorted((tmp_path / "gpu").iterdir())),
        "--markdown",
        str(page),
    ]
    assert CliRunner().invoke(main, asked).exit_code == 0
    text = page.read_text()
    for part in ("on a device, 2 CPU cores", "| 1 env | 8 envs |", "50.0%", "no: loss"):
        assert part in text
    page.write_text("<!-- speed gpu -->\n<!-- end speed gpu -->\n")
    assert "kernels gpu" in CliRunner().invoke(main, asked).output
    assert page.read_text() == "<!-- speed gpu -->\n<!-- end speed gpu -->\n"
    assert (
        "exists already" in CliRunner().invoke(main, ["everything", str(tmp_path / "gpu")]).output
    )


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
    assert differences(tmp_path / "whole", tmp_path / "resumed") == (
        "loss",
        "policies/2.safetensors",
    )
    (tmp_path / "resumed" / "metrics.jsonl").write_text(lines[0] + "\n")
    assert differences(tmp_path / "whole", tmp_path / "resumed")[0] == "2 and 1 rows of metrics"
