"""Names the device that computations run on."""

import platform
from pathlib import Path

import jax


def device_name(device: jax.Device) -> str:
    """Returns the name of an accelerator, which JAX knows, or of a CPU's processor, which JAX calls `cpu`."""
    return _processor() if device.platform == "cpu" else device.device_kind


def _processor() -> str:
    """Returns the processor's name where Linux tells it, else its architecture."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(names, "") or platform.machine()
