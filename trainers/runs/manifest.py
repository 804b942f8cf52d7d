"""The manifest of a run, `manifest.json`: its fields, and how to read it."""

from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sjdsl.files import read_json

from .run_errors import RunError

MANIFEST = "manifest.json"

Number = Annotated[int, Field(ge=0, lt=2**63)]


class _Part(BaseModel):
    """A part of a manifest; other versions may have more fields, or fewer."""

    model_config = ConfigDict(strict=True, extra="allow")


class _Game(_Part):
    name: str = ""
    hash: str = ""
    params: dict[str, Any] = {}
    num_agents: Number = 0


class _Asked(_Part):
    episodes: Number = 0
    callback: str = ""


class _Device(_Part):
    platform: str = ""
    kind: str = ""
    count: Number = 0


class _Diverged(_Part):
    seed: Number
    update: Number


class _Manifest(_Part):
    game: _Game
    config: dict[str, Any]
    versions: dict[str, str | None]
    status: str = ""
    provenance: dict[str, Any] = {}
    own_files: dict[str, str | None] = {}
    derived: dict[str, float] = {}
    device: _Device = _Device()
    loggers: list[str] = []
    asked: _Asked = _Asked()
    resumed: list[str] = []
    extended: list[dict[str, Any]] = []
    diverged: list[_Diverged] = []
    updates: Number = 0
    stages: list[str] = []
    stage: Number = 0


def read_manifest(run_dir: Path) -> dict[str, Any]:
    """Returns the manifest of a run, whose fields have the right types or are missing.

    Raises:
      RunError: there is no readable manifest, or a field has another type.
    """
    try:
        manifest = read_json(run_dir / MANIFEST)
        _Manifest.model_validate(manifest)
    except ValidationError as error:
        fault = error.errors()[0]
        field = ".".join(map(str, fault["loc"]))
        damage = f"`{field}` in its {MANIFEST}: {fault['msg']}"
        if not field:
            damage = f"its {MANIFEST} has no fields"
        raise RunError(
            f"{run_dir} is not the folder of a training run, or is damaged: {damage}"
        ) from None
    except (OSError, ValueError):
        raise RunError(
            f"{run_dir} is not the folder of a training run: it has no readable {MANIFEST}"
        ) from None
    return dict(manifest)
