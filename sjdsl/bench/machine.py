"""Describes the machine that figures were measured on, and how much of its memory was used."""

import os
import platform
from typing import Any

import jax

from sjdsl.trainers.devices.device import device_name
from sjdsl.version import __version__


def describe_machine(devices: int = 1) -> dict[str, Any]:
    """Returns the machine and the versions.

    `devices` is the number of JAX's devices over which the environments were split;
    `compilation_cache` says whether XLA may have loaded programs that were compiled before.
    """
    device = jax.devices()[0]
    has_cache = (
        jax.config.values["jax_compilation_cache_dir"]
        and jax.config.values["jax_enable_compilation_cache"]
    )
    return {
        "platform": device.platform,
        "device": device_name(device),
        "cpu_cores": os.cpu_count(),
        "devices": devices,
        "python": platform.python_version(),
        "jax": jax.__version__,
        "sjdsl": __version__,
        "compilation_cache": bool(has_cache),
    }


def machine_line(machine: dict[str, Any]) -> str:
    """Returns the machine in one line."""
    cores = f"{machine['cpu_cores']} CPU cores{and_devices(machine)}"
    line = f"{machine['device']}, {cores}, JAX {machine['jax']}, Python {machine['python']}"
    if machine["compilation_cache"]:
        line += "; compile seconds with JAX's cache of compiled programs"
    return line


def and_devices(machine: dict[str, Any]) -> str:
    """Returns `, 2 devices` if environments were split over several devices, else an empty text."""
    return f", {machine['devices']} devices" if machine["devices"] > 1 else ""


def device_peak_bytes() -> int | None:
    """Returns the peak memory of the device in this process; None if the device doesn't report it
    (a CPU).
    """
    return (jax.devices()[0].memory_stats() or {}).get("peak_bytes_in_use")
