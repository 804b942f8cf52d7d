"""What `sjdsl bench --devices` asks of JAX, and what it refuses."""

import contextlib
from collections.abc import Sequence

import click


def divide_cpu(devices: int) -> None:
    """Has JAX divide the CPU into as many devices, which it does before the first computation of a process alone."""
    if devices == 1:
        return
    import jax

    with contextlib.suppress(RuntimeError):  # JAX has begun; `check_devices` says so where the devices it has are too few
        jax.config.update("jax_num_cpu_devices", devices)


def check_devices(context: click.Context, devices: int, num_envs: Sequence[int]) -> None:
    """Refuses what cannot be split over so many devices.

    Args:
      num_envs: the numbers of environments that are measured.
    Raises:
      UsageError: a number of environments is no multiple of the devices.
      ClickException: JAX has fewer devices.
    """
    if devices == 1:
        return
    for number in num_envs:
        if number % devices:
            raise click.UsageError(f"--envs {number} cannot be split evenly over {devices} devices; change --envs or --devices", context)
    if not num_envs:
        raise click.UsageError(f"name --envs that are multiples of {devices}, such as --envs {devices * 128}", context)
    import jax

    if len(found := jax.devices()) < devices:
        some = f"{len(found)} device{'s' * (len(found) > 1)}"
        raise click.ClickException(f"JAX has {some} here ({found[0].platform}), not {devices}; change --devices")
