"""What movers cost: a step of one game with them as a ratio to a step without, processor time, in turns in one process: `python -m tests.bench.cost_of_movers`."""

import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any

import jax

import sjdsl

GAME = """sj 1
game lawn "A lawn" {{
  episode 1000
  kind grass "." {{ field grown : {{ lush, bare }} = lush }}
  kind wall  "#" {{ blocks agents{blocks} }}
  map {{
    "...........#..........."
    "...........#..........."
    "..#...........#........"
    "..#...........#........"
    "......................."
    "......##..............."
    "..............##......."
    "......................."
    "...#..............#...."
    "...#..............#...."
    "......................."
    "......................."
  }}
  agents 6 {{ acts turn_left, turn_right, step_left, step_right, forward, backward, stay  moves relative }}
  {movers}
  phase start {{ each agent {{ send agent to grass }}  {start} }}
  schedule walk{turns} -> graze -> grow
  phase walk {{ move each agent }}
  {phases}
  phase graze {{ each agent on grass where grass.grown is lush {{ set grass.grown = bare  give 1 to agent }} }}
  phase grow {{ each grass where grass.grown is bare {{ chance 0.02 {{ set grass.grown = lush }} }} }}
  observe {{ window ahead 5, behind 1, left 3, right 3 }}
}}
"""
WAYS = {
    "4 at random": (4, "move each deer at random"),
    "16 away from agents": (16, "move each deer away from agent"),
}
ENVS = (128,)
ROUNDS, STEPS = 15, 64


def text(number: int = 0, way: str = "") -> str:
    """Returns the game with so many deer that go this way; without movers for 0."""
    if not number:
        return GAME.format(blocks="", movers="", start="", turns="", phases="")
    return GAME.format(
        blocks=", deer",
        movers=f'movers deer {number} "d"',
        start="each deer { send deer to grass }",
        turns=" -> roam",
        phases=f"phase roam {{ {way} }}",
    )


def runner(game: str, envs: int, folder: Path) -> Callable[[], float]:
    """Returns a function that gives the processor seconds of some steps of a batch, compiled before: others on the machine matter less."""
    file = folder / "field.sj"
    file.write_text(game)
    env = sjdsl.make(file)

    def play(state: Any, key: jax.Array) -> Any:
        def step(state: Any, key: jax.Array) -> tuple[Any, Any]:
            keys = jax.random.split(key, envs)
            actions = jax.random.randint(key, (envs, env.num_agents), 0, env.num_actions)
            seen, state, reward, *_ = jax.vmap(env.step)(keys, state, actions)
            return state, (seen.sum(), reward.sum())

        return jax.lax.scan(step, state, jax.random.split(key, STEPS))

    _, state = jax.jit(jax.vmap(env.reset))(jax.random.split(jax.random.key(0), envs))
    run = jax.jit(play).lower(state, jax.random.key(1)).compile()

    def seconds() -> float:
        start = time.process_time()
        jax.block_until_ready(run(state, jax.random.key(1)))
        return time.process_time() - start

    seconds()
    return seconds


def main() -> None:
    """Prints a row for each way, with its ratio for each number of environments: the median over rounds, and the least and the greatest."""
    print(
        "\n".join(
            [
                "| movers | " + " | ".join(f"{envs} environments" for envs in ENVS) + " |",
                "|---" * (1 + len(ENVS)) + "|",
            ]
        )
    )
    with TemporaryDirectory() as folder:
        ratios: dict[str, list[str]] = {name: [] for name in WAYS}
        for envs in ENVS:
            runs = {"": runner(text(), envs, Path(folder))} | {
                name: runner(text(*w), envs, Path(folder)) for name, w in WAYS.items()
            }
            rounds = [{name: run() for name, run in runs.items()} for _ in range(ROUNDS)]
            for name in WAYS:
                each = sorted(r[name] / r[""] for r in rounds)
                ratios[name].append(f"{median(each):.2f} ({each[0]:.2f} to {each[-1]:.2f})")
    for name, found in ratios.items():
        print(f"| {name} | {' | '.join(found)} |")


if __name__ == "__main__":
    main()
