"""The table of a sweep, `results.csv`: made from the folders of its cells whenever one of them
ends.
"""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sjdsl.files import write_whole
from sjdsl.sweeps.cells import Cell
from sjdsl.sweeps.folder import (
    as_text,
    cells_of,
    evaluation_of,
    is_finished,
    manifest_of,
    run_dir,
    seed_dirs,
)
from sjdsl.trainers.policies.stored_evaluation import RETURN, Figure, StoredEvaluation
from sjdsl.trainers.runs.stages import reward_label

RESULTS = "results.csv"
Row = dict[str, str]

OF_CELL = ("cell", "game", "hash", "algorithm", "reward", "sharing", "variant")
OF_RUN = ("seed", "updates", "env_steps", "episodes", "hardware")
FIRST = (
    "collective_return",
    "collective_return_low",
    "collective_return_high",
    "equality",
    "episode_length",
)
KINDS = ("return_agent_", "event_", "mean_", "final_")  # of further figures


def results(folder: Path, content: Mapping[str, Any]) -> list[Row]:
    """Returns a row for each seed of each finished cell, in the order of the cells.

    Args:
      folder: of the sweep.
      content: the content of its `sweep.json`.
    """
    rows = []
    for cell in cells_of(content):
        path = run_dir(folder, cell)
        if not is_finished(path):
            continue
        evaluations = {
            seed: evaluation_of(seed_dir, seed, content["episodes"])
            for seed, seed_dir in seed_dirs(path, cell).items()
        }
        if None in evaluations.values():
            continue
        manifest = manifest_of(path)
        for seed, evaluation in evaluations.items():
            assert evaluation is not None
            rows.append(_seed_row(cell, manifest, seed, evaluation))
    return rows


def _seed_row(
    cell: Cell, manifest: Mapping[str, Any], seed: int, evaluation: StoredEvaluation
) -> Row:
    """Returns the row of a seed. manifest: of the cell's run."""
    updates = manifest["updates"]
    earlier_steps = sum(stage.steps for stage in cell.earlier)
    device = manifest.get("device", {})
    platform = device.get("platform", "?")
    count = device.get("count", "?")
    kind = device.get("kind", "?")
    values = {
        **cell.values,
        "cell": cell.name,
        "game": cell.game,
        "hash": cell.hash,
        "algorithm": cell.config.get("algorithm"),
        "sharing": cell.config.get("sharing"),
        "variant": cell.provenance.get("variant"),
        "reward": reward_label(cell.config["reward"], bool(cell.earlier)),
    }
    run = {
        "seed": str(seed),
        "updates": str(updates),
        "env_steps": str(earlier_steps + updates * cell.configuration().steps_per_update),
        "episodes": str(evaluation.episodes),
        "hardware": f"{platform} x{count}: {kind}",
    }
    texts = {name: as_text(value) for name, value in values.items()}
    return {**texts, **run, **figures(evaluation.summary)}


def figures(summary: Mapping[str, Figure]) -> Row:
    """Returns the means of an evaluation under the names of metrics.

    `event eaten of agent 0` is `event_eaten_agent_0`.
    """
    values = {
        name.replace(" of agent ", "_agent_").replace(" ", "_"): figure.mean
        for name, figure in summary.items()
    }
    values["collective_return_low"] = summary[RETURN].low
    values["collective_return_high"] = summary[RETURN].high
    return {name: "" if value is None else repr(float(value)) for name, value in values.items()}


def write_results(folder: Path, content: Mapping[str, Any]) -> None:
    """Writes `results.csv`, whole or not at all.

    Another process may write it at the same time, and may have read the folders before this
    process's cell was done. So this process reads the folders again afterwards, and writes the
    table again until both agree: the last process to write has read everything.
    """
    text = result_table(results(folder, content))
    for _ in range(10):  # rather than for ever, should others keep writing
        write_whole(folder / RESULTS, text.encode())
        new_text = result_table(results(folder, content))
        if new_text == text:
            return
        text = new_text


def result_table(rows: Sequence[Row]) -> str:
    """Returns `results.csv`: first the columns of the cell, then its axes, its run, and its
    figures.
    """
    names = dict.fromkeys(name for row in rows for name in row)
    others = [name for name in names if name not in (*OF_CELL, *OF_RUN, *FIRST)]
    figures_by_kind = [name for kind in KINDS for name in others if name.startswith(kind)]
    axes = [name for name in others if name not in figures_by_kind]
    columns = (*OF_CELL, *axes, *OF_RUN, *FIRST, *figures_by_kind)
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
