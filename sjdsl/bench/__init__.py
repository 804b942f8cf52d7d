"""Benchmarks: environment steps per second of compiled games, compared with a hand-written game in the same process."""

from sjdsl.bench.compilation import Compilation
from sjdsl.bench.loop import Task, game_task, yardstick_task
from sjdsl.bench.sweep import Sweep, measure_sweep
from sjdsl.bench.timing import Report, Speed, measure
from sjdsl.bench.training import Training, measure_training
from sjdsl.bench.training_setups import Setup, training_setups

__all__ = [
    "Compilation",
    "Report",
    "Setup",
    "Speed",
    "Sweep",
    "Task",
    "Training",
    "game_task",
    "measure",
    "measure_sweep",
    "measure_training",
    "training_setups",
    "yardstick_task",
]
