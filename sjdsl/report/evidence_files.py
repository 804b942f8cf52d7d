"""The evidence of a report as a folder of CSV files, one a table, and back."""

import csv
import io
from collections.abc import Mapping
from dataclasses import astuple, fields
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from sjdsl.report.evidence import ROW_TYPES, Evidence
from sjdsl.report.refusals import ReportError

NEEDED = ("runs.csv", "seeds.csv")  # by which such a folder is known


def is_evidence(folder: Path) -> bool:
    """Returns whether a folder holds the evidence of a report."""
    return all((folder / name).is_file() for name in NEEDED)


def evidence_files(evidence: Evidence) -> dict[str, str]:
    """Returns the text of each file by its name."""
    return {f"{name}.csv": _text(ROW_TYPES[name], rows) for name, rows in evidence.rows().items()}


def _text(kind: type, rows: tuple[Any, ...]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([entry.name for entry in fields(kind)])
    writer.writerows([_plain(value) for value in astuple(row)] for row in rows)
    return text.getvalue()


def _plain(value: Any) -> Any:
    """Returns a value as CSV has it: a whole float without its `.0`."""
    return f"{value:.6g}" if isinstance(value, float) else value


def read_evidence(folder: Path) -> Evidence:
    """Returns the evidence that a folder holds; a table without a file is empty.

    Raises:
      ReportError: a file has other columns, or a value that is none; which file and line.
    """
    return Evidence(**{name: _read(folder / f"{name}.csv", kind) for name, kind in ROW_TYPES.items()})


@cache
def _adapter(kind: type) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _read(path: Path, kind: type) -> tuple[Any, ...]:
    if not path.is_file():
        return ()
    names = [entry.name for entry in fields(kind)]
    optional = {entry.name for entry in fields(kind) if "None" in str(entry.type)}
    rows = []
    with open(path, encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames is None or list(reader.fieldnames) != names:
            raise ReportError(f"{path} must have the columns {', '.join(names)}, and has {', '.join(reader.fieldnames or ()) or 'none'}")
        for row in reader:
            rows.append(
                _row(kind, {name: None if name in optional and row[name] == "" else row[name] for name in names}, path, reader.line_num)
            )
    return tuple(rows)


def _row(kind: type, values: Mapping[str, Any], path: Path, line: int) -> Any:
    try:
        return _adapter(kind).validate_python(values)
    except ValidationError as error:
        fault = error.errors()[0]
        raise ReportError(
            f"{path}, line {line}: {fault['loc'][0]} = {values.get(str(fault['loc'][0]))!r}: {fault['msg'].lower()}"
        ) from None
