"""Speed: how many environment steps a second compiled games do, beside a game written by hand in the same process."""

from sjdsl.bench.loop import Task, game_task, yardstick_task
from sjdsl.bench.timing import Compilation, Report, Speed, measure

__all__ = ["Compilation", "Report", "Speed", "Task", "game_task", "measure", "yardstick_task"]
