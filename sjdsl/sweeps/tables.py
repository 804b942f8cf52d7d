"""The table of a sweep, `results.csv`: made from the folders of its cells whenever one of them ends."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from sjdsl.files import write_whole
from sjdsl.sweeps.folder import (
    as_text,
    cells_of,
    evaluation_of,
    is_finished,
    manifest_of,
    run_dir,
    seed_dirs,
)
from sjdsl.trainers.policies.stored_evaluation import RETURN, Figure
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


def results(folder: Path, known: Mapping[str, Any]) -> list[Row]:
    """Returns a row for each seed of each finished cell, in the order of the cells.

    Args:
      folder: of the sweep.
      known: the content of its `sweep.json`.
    """
    rows = []
    for cell in cells_of(known):
        path = run_dir(folder, cell)
        seeds = seed_dirs(path, cell) if is_finished(path) else {}
        evaluations = {
            seed: evaluation_of(own, seed, known["episodes"]) for seed, own in seeds.items()
        }
        if None in evaluations.values():
            continue
        for seed, evaluation in evaluations.items():
            assert evaluation is not None
            manifest = manifest_of(path)
            updates, device = manifest["updates"], manifest.get("device", {})
            place = {"cell": cell.name, "game": cell.game, "hash": cell.hash}
            way = {key: cell.config.get(key) for key in ("algorithm", "sharing")} | {
                "variant": cell.provenance.get("variant")
            }
            way["reward"] = reward_label(cell.config["reward"], bool(cell.earlier))
            run = {
                "seed": seed,
                "updates": updates,
                "env_steps": sum(stage.steps for stage in cell.earlier)
                + updates * cell.configuration().steps_per_update,
                "episodes": evaluation.episodes,
                "hardware": f"{device.get('platform', '?')} x{device.get('count', '?')}: {device.get('kind', '?')}",
            }
            texts = {key: as_text(value) for key, value in {**cell.values, **place, **way}.items()}
            rows.append(
                texts
                | {key: str(value) for key, value in run.items()}
                | figures(evaluation.summary)
            )
    return rows


def figures(summary: Mapping[str, Figure]) -> Row:
    """Returns the means of an evaluation under the names of metrics: `event eaten of agent 0` is `event_eaten_agent_0`."""
    values = {
        name.replace(" of agent ", "_agent_").replace(" ", "_"): figure.mean
        for name, figure in summary.items()
    }
    values |= {
        "collective_return_low": summary[RETURN].low,
        "collective_return_high": summary[RETURN].high,
    }
    return {name: "" if value is None else repr(float(value)) for name, value in values.items()}


def write_results(folder: Path, known: Mapping[str, Any]) -> None:
    """Writes `results.csv`, whole or not at all.

    Another process may write it at the same time, from what it read before this one's cell was done. So the folders are read again
    afterwards, and the table written again until they agree: the last process to write has read everything.
    """
    text = result_table(results(folder, known))
    for _ in range(10):
        write_whole(folder / RESULTS, text.encode())
        again = result_table(results(folder, known))
        if again == text:
            return
        text = again


def result_table(rows: Sequence[Row]) -> str:
    """Returns `results.csv`: first the columns of the cell, then its axes, its run, and its figures."""
    others = [
        name
        for name in dict.fromkeys(name for row in rows for name in row)
        if name not in (*OF_CELL, *OF_RUN, *FIRST)
    ]
    figures_by_kind = [name for kind in KINDS for name in others if name.startswith(kind)]
    columns = (
        *OF_CELL,
        *(name for name in others if name not in figures_by_kind),
        *OF_RUN,
        *FIRST,
        *figures_by_kind,
    )
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
