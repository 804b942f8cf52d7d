"""Measures Melting Pot itself: environment steps a second of its substrates under random actions, one environment in one process.

It runs in a Python of its own, with nothing of sjdsl:

    python3.11 -m venv original
    original/bin/pip install dmlab2d==1.0.2 dm-env dm-tree immutabledict ml-collections networkx 'numpy<2' chex reactivex absl-py
    original/bin/pip download --no-deps --no-binary :all: dm-meltingpot==2.4.1
    tar xzf dm_meltingpot-2.4.1.tar.gz
    original/bin/python bench/meltingpot_original.py dm-meltingpot-2.4.1 --seconds 3 > original.md

Only the substrates are loaded from the source archive; what it installs besides (bots, assets, TensorFlow) is not needed for them.
One step moves all players and gives each its observations, the pictures of 88 by 88 pixels among them.
"""

import argparse
import statistics
import sys
import time
import types

import numpy as np

ROUNDS = 3


def main() -> None:
    """Prints a row of Markdown for each substrate as soon as it is measured."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("source", help="the unpacked source archive of dm-meltingpot")
    parser.add_argument("substrates", nargs="*", help="names; all without any")
    parser.add_argument(
        "--seconds", type=float, default=3.0, help="of each substrate, in three rounds"
    )
    asked = parser.parse_args()
    package = types.ModuleType(
        "meltingpot"
    )  # its own `__init__` would load the bots, and with them TensorFlow
    package.__path__ = [f"{asked.source}/meltingpot"]
    sys.modules["meltingpot"] = package
    from meltingpot import substrate

    print(
        "| substrate | players | steps a second | slowest and fastest round | steps a processor second |\n| --- | --: | --: | --: | --: |"
    )
    for name in asked.substrates or sorted(substrate.SUBSTRATES):
        players, rates, busy = measure(substrate, name, asked.seconds)
        spread = f"{min(rates):,.0f} to {max(rates):,.0f}"
        print(
            f"| {name} | {players} | {statistics.median(rates):,.0f} | {spread} | {statistics.median(busy):,.0f} |",
            flush=True,
        )


def measure(
    substrate: types.ModuleType, name: str, seconds: float
) -> tuple[int, list[float], list[float]]:
    """Returns the number of players, and of each round the steps a second and the steps a second of processor time.

    Resets at the end of episodes are included. On a machine that others use, too, only processor time says something.
    """
    roles = substrate.get_config(name).default_player_roles
    env = substrate.build(name, roles=roles)
    env.reset()
    choices, random = [spec.num_values for spec in env.action_spec()], np.random.default_rng(0)
    rates, busy = [], []
    for _ in range(ROUNDS):
        steps, began, worked = 0, time.perf_counter(), time.process_time()
        while time.perf_counter() - began < seconds / ROUNDS:
            if env.step(random.integers(choices).tolist()).last():
                env.reset()
            steps += 1
        rates.append(steps / (time.perf_counter() - began))
        busy.append(steps / (time.process_time() - worked))
    env.close()
    return len(roles), rates, busy


if __name__ == "__main__":
    main()
