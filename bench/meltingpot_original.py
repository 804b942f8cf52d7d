"""Measures Melting Pot itself: environment steps a second of its substrates under random actions, one
environment in one process.

It runs in a Python of its own, with nothing of sjdsl:

    python3.11 -m venv original
    original/bin/pip install dmlab2d==1.0.2 dm-env dm-tree immutabledict ml-collections networkx 'numpy<2' chex reactivex absl-py
    original/bin/pip download --no-deps --no-binary :all: dm-meltingpot==2.4.1
    tar xzf dm_meltingpot-2.4.1.tar.gz
    original/bin/python bench/meltingpot_original.py dm-meltingpot-2.4.1 --seconds 3 > original.md

Only the substrates are loaded from the source archive; they don't need its other packages (bots,
assets, TensorFlow). One step moves all players and returns the observations of each, with the pictures
of 88 by 88 pixels.
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
    arguments = parser.parse_args()
    # The package's own `__init__` would load the bots, and with them TensorFlow.
    package = types.ModuleType("meltingpot")
    package.__path__ = [f"{arguments.source}/meltingpot"]
    sys.modules["meltingpot"] = package
    from meltingpot import substrate

    print(
        "| substrate | players | steps a second | slowest and fastest round "
        "| steps a processor second |\n| --- | --: | --: | --: | --: |"
    )
    for name in arguments.substrates or sorted(substrate.SUBSTRATES):
        players, rates, processor_rates = measure(substrate, name, arguments.seconds)
        median = f"{statistics.median(rates):,.0f}"
        spread = f"{min(rates):,.0f} to {max(rates):,.0f}"
        processor = f"{statistics.median(processor_rates):,.0f}"
        print(f"| {name} | {players} | {median} | {spread} | {processor} |", flush=True)


def measure(
    substrate: types.ModuleType, name: str, seconds: float
) -> tuple[int, list[float], list[float]]:
    """Returns the number of players, and for each round the steps a second and the steps a second of
    processor time.

    Resets at the end of episodes are included. On a machine that others use too, only processor time
    is reliable.
    """
    roles = substrate.get_config(name).default_player_roles
    env = substrate.build(name, roles=roles)
    env.reset()
    num_actions = [spec.num_values for spec in env.action_spec()]
    random = np.random.default_rng(0)
    rates = []
    processor_rates = []
    for _ in range(ROUNDS):
        steps = 0
        start = time.perf_counter()
        processor_start = time.process_time()
        while time.perf_counter() - start < seconds / ROUNDS:
            if env.step(random.integers(num_actions).tolist()).last():
                env.reset()
            steps += 1
        rates.append(steps / (time.perf_counter() - start))
        processor_rates.append(steps / (time.process_time() - processor_start))
    env.close()
    return len(roles), rates, processor_rates


if __name__ == "__main__":
    main()
