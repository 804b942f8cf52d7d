"""Benchmarks: environment steps per second of compiled games, compared with a hand-written game in
the same process."""

from sjdsl.bench.compilation import Compilation
from sjdsl.bench.loop import Task, game_task, yardstick_task
from sjdsl.bench.timing import Report, Speed, measure

__all__ = ["Compilation", "Report", "Speed", "Task", "game_task", "measure", "yardstick_task"]
