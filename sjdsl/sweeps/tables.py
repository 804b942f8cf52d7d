"""The tables of a sweep, `results.csv` and `status.csv`: read from the folders of its cells, and written anew whenever one has changed."""

import csv
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from sjdsl.files import write_whole
from sjdsl.sweeps.cells import Cell
from sjdsl.sweeps.folder import (
    Progress,
    as_text,
    cells_of,
    evaluation_of,
    is_finished,
    manifest_of,
    progress_of,
    run_dir,
    seed_dirs,
    steps_of,
)
from sjdsl.trainers.metrics_files import METRICS_JSONL

RESULTS = "results.csv"
STATUS = "status.csv"
Row = dict[str, str]

OF_CELL = ("cell", "game", "hash", "protocol", "stage", "point", "algorithm", "reward", "sharing", "variant")
OF_RUN = ("seed", "updates", "env_steps", "episodes", "together", "hardware")
FIRST = ("collective_return", "collective_return_low", "collective_return_high", "equality", "episode_length")
OF_STATUS = ("cell", "game", "stage", "point", "seeds", "state", "update", "updates", "env_steps", "seconds", "reason")


def results(folder: Path, known: Mapping[str, Any]) -> list[Row]:
    """Returns a row for each seed of each cell that is done, in the order of the cells.

    Args:
      folder: of the sweep.
      known: what its `sweep.json` says.
    """
    rows = []
    for cell in cells_of(known):
        path = run_dir(folder, cell)
        if not is_finished(path):
            continue
        found = {seed: evaluation_of(own, seed, known["episodes"]) for seed, own in seed_dirs(path, cell).items()}
        if any(evaluation is None for evaluation in found.values()):
            continue
        for seed, evaluation in found.items():
            assert evaluation is not None
            own = seed_dirs(path, cell)[seed]
            rows.append(_of_cell(cell, known) | _of_run(seed, path, own, evaluation) | figures(evaluation["summary"]))
    return rows


def collective_returns(folder: Path, known: Mapping[str, Any]) -> dict[str, list[float]]:
    """Returns the mean collective return of each seed of each cell that is done."""
    found: dict[str, list[float]] = {}
    for row in results(folder, known):
        found.setdefault(row["cell"], []).append(float(row["collective_return"]))
    return found


def _of_cell(cell: Cell, known: Mapping[str, Any]) -> Row:
    config = cell.config
    place = {
        "cell": cell.name,
        "game": cell.game,
        "hash": cell.hash,
        "protocol": known["protocol"],
        "stage": cell.stage,
        "point": cell.point,
    }
    way = {key: config.get(key) for key in ("algorithm", "reward", "sharing")} | {"variant": cell.provenance.get("variant")}
    return {key: as_text(value) for key, value in {**cell.values, **place, **way}.items()}


def _of_run(seed: int, path: Path, own: Path, evaluation: Mapping[str, Any]) -> Row:
    manifest = manifest_of(path)
    device = manifest.get("device", {})
    last = _last_row(own / METRICS_JSONL)
    known = {
        "seed": seed,
        "updates": last.get("update"),
        "env_steps": last.get("env_steps"),
        "episodes": evaluation["episodes"],
        "together": manifest.get("together", 1),
        "hardware": f"{device.get('platform', '?')} x{device.get('count', '?')}: {device.get('kind', '?')}",
    }
    return {key: str(value) for key, value in known.items()}


def _last_row(path: Path) -> dict[str, Any]:
    """Returns the last line of a file of JSON lines that is whole."""
    with open(path, "rb") as file:
        file.seek(0, io.SEEK_END)
        file.seek(max(0, file.tell() - 65_536))
        for line in islice(reversed(file.read().splitlines()), 2):
            try:
                return dict(json.loads(line))
            except (ValueError, TypeError):
                continue
    return {}


def figures(summary: Mapping[str, Mapping[str, float | None]]) -> Row:
    """Returns the means of an evaluation under the names that metrics have: `event eaten of agent 0` is `event_eaten_agent_0`."""
    row = {name.replace(" of agent ", "_agent_").replace(" ", "_"): _number(found["mean"]) for name, found in summary.items()}
    earned = summary["collective return"]
    return row | {f"collective_return_{end}": _number(earned[end]) for end in ("low", "high")}


def _number(value: float | None) -> str:
    return "" if value is None else repr(float(value))


def status(folder: Path, known: Mapping[str, Any]) -> list[Row]:
    """Returns a row for each cell: how far it is, why it failed."""
    return [_status_of(cell, progress_of(folder, cell, known["episodes"]), run_dir(folder, cell)) for cell in cells_of(known)]


def _status_of(cell: Cell, progress: Progress, path: Path) -> Row:
    seeds = cell.seeds
    steps = steps_of(cell)
    updates = cell.configuration().num_updates
    known = {
        "cell": cell.name,
        "game": cell.game,
        "stage": cell.stage,
        "point": as_text(cell.point),
        "seeds": f"{seeds[0]}-{seeds[-1]}" if len(seeds) > 1 else seeds[0],
        "state": progress.state,
        "update": progress.update,
        "updates": updates,
        "env_steps": steps * progress.update // updates,
        "seconds": _seconds(cell, progress, path),
        "reason": progress.reason,
    }
    return {key: str(value) for key, value in known.items()}


def _seconds(cell: Cell, progress: Progress, path: Path) -> str:
    """Returns the seconds of a cell's updates, all its seeds together; empty while it trains, for they change with every look.

    They are not among its results, which are to be the same whenever and wherever the cell is run.
    """
    try:
        last = _last_row(seed_dirs(path, cell)[cell.seeds[0]] / METRICS_JSONL)
    except FileNotFoundError:  # it is yet to be run, or to be run anew
        return ""
    return "" if progress.state == "running" else f"{last.get('seconds', 0.0):.1f}"


def write_tables(folder: Path, known: Mapping[str, Any]) -> None:
    """Writes both tables, each whole or not at all.

    Another process may write them at the same time, from what it has read before this one's cell was done. So they are read again
    afterwards, and written again until the file says what the folders say: whoever writes last has read everything.
    """
    _write(folder / RESULTS, lambda: result_table(results(folder, known)))
    write_status(folder, known)


def write_status(folder: Path, known: Mapping[str, Any]) -> None:
    """Writes `status.csv`, whole or not at all."""
    _write(folder / STATUS, lambda: table(OF_STATUS, status(folder, known)))


def _write(path: Path, make: Callable[[], str]) -> None:
    text = make()
    for _ in range(10):
        write_whole(path, text.encode())
        again = make()
        if again == text:
            return
        text = again


def result_table(rows: Sequence[Row]) -> str:
    """Returns `results.csv`: first what a cell is, then what its axes have, then its run, then its figures."""
    found = list(dict.fromkeys(name for row in rows for name in row))
    own = [name for name in found if name not in (*OF_CELL, *OF_RUN, *FIRST) and not _is_figure(name)]
    measured = [name for name in found if _is_figure(name) and name not in FIRST]
    return table((*OF_CELL, *own, *OF_RUN, *FIRST, *sorted(measured, key=_kind_of_figure)), rows)


KINDS = ("return_agent_", "event_", "mean_", "final_")


def _is_figure(name: str) -> bool:
    return name.startswith(KINDS) or name in FIRST


def _kind_of_figure(name: str) -> int:
    return next(number for number, kind in enumerate(KINDS) if name.startswith(kind))


def table(columns: Iterable[str], rows: Sequence[Row]) -> str:
    """Returns rows as CSV, empty where a row has no such column."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [*columns], restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
