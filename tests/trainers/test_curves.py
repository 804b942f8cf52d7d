"""Learning curves of several runs: which numbers are drawn."""

import json
from pathlib import Path

import numpy as np
import pytest

from sjdsl.cli import run
from sjdsl.render.line_plots import Line, draw_panels, split_lines
from sjdsl.render.plot_style import apart
from sjdsl.trainers import RunError
from sjdsl.trainers.runs.curves import curve_line, draw_curves, figures, in_words, read_seeds
from sjdsl.trainers.runs.learning_curve import curve_panels
from sjdsl.trainers.runs.learning_signs import FIGURES
from sjdsl.trainers.runs.metrics_files import known_row

ROWS = [
    {
        "update": 1,
        "env_steps": 10,
        "collective_return": None,
        "event_own_agent_0": None,
        "event_own_agent_1": None,
        "event_other": None,
    },
    {
        "update": 2,
        "env_steps": 20,
        "collective_return": 4.0,
        "event_own_agent_0": 1.0,
        "event_own_agent_1": 2.0,
        "event_other": 1.0,
    },
    {
        "update": 3,
        "env_steps": 30,
        "collective_return": 6.0,
        "event_own_agent_0": 3.0,
        "event_own_agent_1": 3.0,
        "event_other": 2.0,
    },
]


@pytest.mark.parametrize(
    ("metric", "values"),
    [
        ("collective_return", [np.nan, 4, 6]),
        ("event_own", [np.nan, 3, 6]),
        ("event_own_agent_1", [np.nan, 2, 3]),
    ],
)
def test_a_metric_is_a_column_or_the_sum_over_agents(metric: str, values: list[float]) -> None:
    np.testing.assert_array_equal(figures(map(known_row, ROWS), metric), [[10, 20, 30], values])


def test_an_unknown_metric_is_told_with_those_there_are() -> None:
    with pytest.raises(
        RunError, match="no column `event_none`; they have update, env_steps, collective_return"
    ):
        figures(map(known_row, ROWS), "event_none")


def test_runs_of_several_seeds_are_drawn(tmp_path: Path) -> None:
    for seed in (0, 1):
        (tmp_path / "run" / f"seed_{seed}").mkdir(parents=True)
        (tmp_path / "run" / f"seed_{seed}" / "metrics.jsonl").write_text(
            "".join(json.dumps(row) + "\n" for row in ROWS)
        )
    with pytest.raises(RunError, match="is not the folder of a training run"):
        read_seeds(tmp_path / "run", "collective_return")
    (tmp_path / "run" / "manifest.json").write_text(
        json.dumps({"game": {}, "config": {}, "versions": {}})
    )
    assert [seed.shape for seed in read_seeds(tmp_path / "run", "collective_return")] == [
        (2, 3),
        (2, 3),
    ]
    draw_curves([("a", tmp_path / "run")], "collective_return", tmp_path / "curve.png")
    assert (tmp_path / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_runs_whose_folders_have_the_same_name_are_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[str] = []
    monkeypatch.setattr(
        "sjdsl.trainers.runs.curves.draw_curves",
        lambda named, *_: drawn.extend(name for name, _ in named),
    )
    assert (
        run(
            [
                "plot",
                "slow/cells/coins",
                "fast/cells/coins/",
                "c=elsewhere",
                "-o",
                str(tmp_path / "curves.png"),
            ]
        )
        == 0
    )
    assert drawn == ["slow", "fast", "c"]


@pytest.mark.parametrize(
    ("metric", "words"),
    [
        ("collective_return", "collective return"),
        ("event_own", "own in an episode"),
        ("mean_apples_left", "mean of apples left over an episode"),
        ("final_owned", "owned at the end of an episode"),
        ("event_own_agent_1", "own of agent 1 in an episode"),
    ],
)
def test_an_axis_is_titled_in_words(metric: str, words: str) -> None:
    assert in_words(metric) == words


@pytest.mark.parametrize(
    ("lines", "plots"), [(1, [1]), (5, [5]), (6, [3, 3]), (7, [4, 3]), (11, [4, 3, 4])]
)
def test_a_plot_has_five_lines_at_most(lines: int, plots: list[int]) -> None:
    panels = split_lines(
        [Line(f"run {number}", np.arange(3), np.arange(3)) for number in range(lines)], "return"
    )
    assert [len(panel.lines) for panel in panels] == plots
    assert [shown.label for panel in panels for shown in panel.lines] == [
        f"run {number}" for number in range(lines)
    ]
    figure = draw_panels(panels)
    assert [len(axes.lines) for axes in figure.axes] == plots
    named = [{(text.get_text(), text.get_color()) for text in axes.texts} for axes in figure.axes]
    assert sorted(text for names in named for text, _ in names) == sorted(
        f"run {number}" for number in range(lines)
    )
    assert [{colour for _, colour in names} for names in named] == [
        {shown.get_color() for shown in axes.lines} for axes in figure.axes
    ]
    assert len({shown.get_color() for axes in figure.axes for shown in axes.lines}) == lines
    assert {axes.get_ylim() for axes in figure.axes} == {figure.axes[0].get_ylim()}, (
        "side by side they can be compared"
    )


def test_axes_begin_at_0_unless_a_measurement_is_below() -> None:
    """A mean and its interval say nothing about the sign of what was measured; the smallest measurement does."""
    values, low = np.array([3.0, 4.0]), np.array([-1.0, 2.0])
    for least, begins in ((0.5, True), (-0.5, False)):
        (axes,) = draw_panels(
            split_lines([Line("a", np.arange(2), values, low, values + 1, least=least)], "return")
        ).axes
        assert (axes.get_ylim()[0] == 0) == begins


@pytest.mark.parametrize(
    ("wanted", "places"),
    [
        ([0.1, 0.5, 0.9], [0.1, 0.5, 0.9]),
        ([0.5, 0.5], [0.45, 0.55]),
        ([0.2, 0.22, 0.24, 0.9], [0.12, 0.22, 0.32, 0.9]),
        ([0.0, 0.0, 0.2], [0.05, 0.15, 0.25]),
    ],
)
def test_names_of_lines_do_not_overlap(wanted: list[float], places: list[float]) -> None:
    assert apart(wanted, [0.1] * len(wanted)) == pytest.approx(places)


def test_agents_stand_beside_the_return_of_all() -> None:
    agents = {f"return_agent_{number}": 1.0 for number in range(7)}
    rows = [{"env_steps": 10, "episodes": 0, "collective_return": np.nan, **agents}]
    assert curve_panels(rows) == []
    rows.append({"env_steps": 20, "episodes": 2, "collective_return": 7.0, **agents})
    panels = curve_panels(rows)
    assert [panel.title for panel in panels] == [
        "all agents together",
        "agents 0 to 3",
        "agents 4 to 6",
    ]
    assert panels[0].lines[0].steps.tolist() == [20], "where an episode has ended"
    assert [
        panel.title
        for panel in curve_panels(
            [{key: rows[1][key] for key in ("env_steps", "episodes", "collective_return")}]
        )
    ] == ["all agents together"]


def test_figures_of_learning_that_were_never_finite_are_not_drawn() -> None:
    """As of a run whose first loss was not finite."""
    rows = [
        {
            "env_steps": 10,
            "episodes": 1,
            "collective_return": 7.0,
            "entropy": np.nan,
            "explained_variance": value,
        }
        for value in (np.nan, 0.5)
    ]
    assert [panel.title for panel in curve_panels(rows[:1])] == ["all agents together"]
    assert [panel.title for panel in curve_panels(rows)] == [
        "all agents together",
        FIGURES["explained_variance"],
    ]


def test_a_run_without_values_is_no_curve(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(json.dumps({"game": {}, "config": {}, "versions": {}}))
    (tmp_path / "metrics.jsonl").write_text(json.dumps(ROWS[0]) + "\n")
    with pytest.raises(
        RunError, match=r"there is no curve to draw\. Perhaps no episode ended in the run"
    ):
        curve_line("a", tmp_path, "collective_return")
