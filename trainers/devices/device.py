"""Names the device that computations run on."""

import platform
from contextlib import suppress
from pathlib import Path

import jax


def device_name(device: jax.Device) -> str:
    """Returns the name of an accelerator, or of a CPU's processor (JAX says only `cpu`).

    The latter is its model on Linux, else its architecture.
    """
    if device.platform != "cpu":
        return str(device.device_kind)
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip() or platform.machine()
    return platform.machine()
