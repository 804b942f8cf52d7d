"""Measures everything that needs a device within a time limit, most important first, and stores each figure at once."""

import json
import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from bench.speed.kernels import measure_kernels
from bench.speed.resuming import measure_resume
from bench.speed.stored import Found, read_found
from bench.speed.training import Training, measure_training, training_setups
from sjdsl.bench.loop import Task, steps_for
from sjdsl.bench.machine import describe_machine
from sjdsl.bench.stored import write_found
from sjdsl.bench.timing import Report, measure
from sjdsl.files import read_json, write_whole
from sjdsl.runtime.env import Environment

PARTS = "parts.json"  # what was measured, what was not, and why


@dataclass(frozen=True)
class Plan:
    """What is measured: speeds at each number of environments, kernels and training at one, and `resumed`, a game by name or file."""

    tasks: Sequence[Task]
    num_envs: Sequence[int]
    repeats: int
    resumed: str
    training_envs: int = 256
    training_steps: int = 128
    convolutional: int = 0  # games whose training with convolutions is measured, too, from the smallest observation to the largest
    workers: int = 1  # programs compiled at the same time


@dataclass(frozen=True)
class Part:
    """One measurement: `file` is where its figures are added to; parts of a `sort` take about equally long."""

    name: str
    sort: str
    file: str
    measure: Callable[[], Found]


@dataclass(frozen=True)
class Done:
    """How a part ended: `measured`, `no time left`, or `failed: ` and the error."""

    name: str
    file: str
    status: str
    seconds: float


def parts_of(plan: Plan, tell: Callable[[str], object]) -> Iterator[Part]:
    """Yields what the plan asks for in order of importance: speeds with tokens, kernels, resuming, training, speeds with one-hot."""
    tokens = [task for task in plan.tasks if task.observation == "tokens"]
    others = [task for task in plan.tasks if task.observation != "tokens"]
    envs = [task.env for task in tokens if task.env is not None]
    yield from _speed_parts(plan, tokens, "tokens", tell)
    most = max(plan.num_envs)
    yield Part("kernels", "kernels", "kernels.json", lambda: measure_kernels(tokens, most, plan.repeats, tell=tell))
    yield Part("resuming", "resuming", "resuming.json", lambda: measure_resume(plan.resumed, tell))
    yield from (_training_part(plan, env, "mlp", tell) for env in envs)
    yield from _speed_parts(plan, others, "onehot", tell)
    yield from (_training_part(plan, env, "cnn", tell) for env in spread(envs, plan.convolutional))


def spread(envs: Sequence[Environment], number: int) -> list[Environment]:
    """Returns at most `number` environments, evenly spaced from the smallest to the largest observation of all agents."""
    ordered = sorted(envs, key=lambda env: math.prod(env.observation_shape))
    last = len(ordered) - 1
    chosen = {round(last * index / max(1, number - 1)) for index in range(number)} if ordered else set()
    return [ordered[index] for index in sorted(chosen)]


def _speed_parts(plan: Plan, tasks: Sequence[Task], observation: str, tell: Callable[[str], object]) -> Iterator[Part]:
    for number in plan.num_envs if tasks else ():

        def race(number: int = number) -> Report:
            return measure(tasks, [number], plan.repeats, steps_for, tell, plan.workers, one_step=False)

        yield Part(f"speed of {number} environments, {observation}", f"speed {observation}", "speed.json", race)


def _training_part(plan: Plan, env: Environment, network: Any, tell: Callable[[str], object]) -> Part:
    def split() -> Training:
        setups, refused = training_setups([(env.name, env)], [network], num_envs=plan.training_envs, num_steps=plan.training_steps)
        if refused:
            raise ValueError("; ".join(refused))
        return measure_training(setups, plan.repeats, tell)

    return Part(f"training of {env.name}, {network}", f"training {network}", f"training_{network}.json", split)


def measure_everything(
    parts: Sequence[Part],
    folder: Path,
    minutes: float,
    command: str,
    clock: Callable[[], float] = time.monotonic,
    tell: Callable[[str], object] = print,
) -> tuple[Done, ...]:
    """Measures the parts in turn and adds each one's figures to its file in `folder`.

    A part is left out when the longest of its sort so far would not fit into the time that is left. One that fails is noted with
    its error, and the next begins: what was measured is never lost. `folder/parts.json` says how every part ended.

    Args:
      parts: in order of importance.
      folder: made if it is not there; files of an earlier run in it are replaced.
      minutes: the time limit, counted from this call.
      command: what is being run, to be quoted beside the figures.
      clock: seconds.
      tell: called with a line whenever a part begins or ends.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in {part.file for part in parts}:
        (folder / name).unlink(missing_ok=True)
    began = clock()
    longest: dict[str, float] = {}
    done: list[Done] = []
    for part in parts:
        start = clock()
        left = minutes * 60 - (start - began)
        if left <= longest.get(part.sort, 0.0):
            done.append(Done(part.name, part.file, "no time left", 0.0))
        else:
            tell(f"{part.name}: {left:.0f} seconds left")
            status = _measured(part, folder)
            seconds = clock() - start
            longest[part.sort] = max(seconds, longest.get(part.sort, 0.0))
            done.append(Done(part.name, part.file, status, seconds))
            tell(f"{part.name}: {status}, {seconds:.0f} s")
        _write_parts(folder, done, command)
    return tuple(done)


def _measured(part: Part, folder: Path) -> str:
    """Measures a part and stores its figures; returns how it ended."""
    try:
        found = part.measure()
    except Exception as error:  # whatever it is, the other parts are still worth measuring
        return f"failed: {type(error).__name__}: {error}"
    path = folder / part.file
    write_found(path, joined(read_found(path), found) if path.exists() else found)
    return "measured"


def joined(before: Found, found: Found) -> Found:
    """Returns the figures of two measurements of one sort as one: speeds and splits one after the other."""
    if isinstance(before, Report) and isinstance(found, Report):
        peaks = [peak for peak in (before.device_peak_bytes, found.device_peak_bytes) if peak is not None]
        return replace(
            found,
            speeds=before.speeds + found.speeds,
            compilations=before.compilations + found.compilations,
            device_peak_bytes=max(peaks, default=None),
        )
    if isinstance(before, Training) and isinstance(found, Training):
        return replace(found, splits=before.splits + found.splits, left_out=before.left_out + found.left_out)
    raise TypeError(f"{type(before).__name__} and {type(found).__name__} are not measurements of one sort")


def _write_parts(folder: Path, done: Sequence[Done], command: str) -> None:
    rows = [{**asdict(part), "seconds": round(part.seconds, 1)} for part in done]
    text = json.dumps({"command": command, "machine": describe_machine(), "parts": rows}, indent=2)
    write_whole(folder / PARTS, text + "\n")


def read_parts(folder: Path) -> tuple[str, tuple[Done, ...]]:
    """Returns the command that left these figures, and how each part ended. Raises ValueError where the folder holds none."""
    path = folder / PARTS
    try:
        stored = read_json(path)
        return stored["command"], tuple(Done(**row) for row in stored["parts"])
    except (OSError, KeyError, TypeError, json.JSONDecodeError) as error:
        raise ValueError(f"{folder} holds no figures of `python -m bench.speed everything` ({type(error).__name__}: {error})") from None
