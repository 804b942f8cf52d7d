"""Minari adapter: recorded episodes as a dataset for offline reinforcement learning."""

import warnings
from collections.abc import Iterator

import numpy as np

from sjdsl.extras import needs
from sjdsl.interop.calls import by_name
from sjdsl.interop.gymnasium import environment_id
from sjdsl.library.factory import make
from sjdsl.replay import Dataset

with needs("minari"):
    import h5py  # noqa: F401, in which Minari stores
    import minari
    from gymnasium.envs.registration import EnvSpec
    from minari.data_collector import EpisodeBuffer
    from minari.dataset.minari_dataset import parse_dataset_id
    from minari.storage.datasets_root_dir import get_dataset_path


def save_minari(dataset: Dataset, dataset_id: str) -> minari.MinariDataset:
    """Makes a Minari dataset in which each episode is that of one agent: agent i of episode e is number `e * num_agents + i`.

    Observations are `[rows, cols, channels]` uint8, rewards the agent's own, as in `sjdsl.interop.gymnasium.AgentGame`, which
    `recover_environment()` makes. Infos have the events; an episode's options have its agent and number. Episodes are read and written
    one by one.

    Args:
      dataset: recorded with observations.
      dataset_id: `NAMESPACE/GAME/NAME-v0`; the first two parts are optional.
    Raises:
      ValueError: the dataset exists already, the id is invalid, or the episodes were recorded without observations.
    """
    check_name(dataset_id)
    header = dataset.header
    if header.observation == "none":
        raise ValueError(f"{dataset.path} has no observations; record with --observation tokens or onehot")
    given = {name: value for name, value in header.environment.items() if value not in (None, {})}
    others = header.policy if header.policy in ("random", "stay") else "random"  # a stored policy may be gone by now
    arguments = {**given, "observation": header.observation, "others": others}
    spec = EnvSpec(environment_id(header.game), entry_point="sjdsl.interop.gymnasium_agent:AgentGame", kwargs=arguments)
    env = make(observation=header.observation, **given)
    made_of = f"{header.episodes} episodes of {env.title or env.name} by all its {env.num_agents} agents"
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", module="minari")  # about a missing author and link
        return minari.create_dataset_from_buffers(
            dataset_id,
            _buffers(dataset, env.num_agents),  # one at a time
            env=spec,
            algorithm_name=header.policy,
            description=f"{made_of}; rules {header.hash}, seeds from {header.seed}",
            requirements=[f"sjdsl=={header.versions['sjdsl']}"],
            jpeg_encoding=False,  # which is lossy
        )


def check_name(dataset_id: str) -> None:
    """Raises ValueError for an id that Minari rejects, or already has."""
    try:
        _, _, version = parse_dataset_id(dataset_id)
    except (ValueError, TypeError):  # raised if the version is missing
        version = None
    if version is None:
        raise ValueError(
            f"`{dataset_id}` can't name a Minari dataset: a name has the form NAMESPACE/GAME/NAME-v0, such as sjdsl/coins/random-v0"
        )
    if get_dataset_path(dataset_id).exists():
        raise ValueError(f"the Minari dataset {dataset_id} exists already; choose another name or version")


def _buffers(dataset: Dataset, num_agents: int) -> Iterator[EpisodeBuffer]:
    for number, episode in enumerate(dataset):
        assert episode.observations is not None
        last = np.arange(len(episode.actions)) == len(episode.actions) - 1
        for agent in range(num_agents):
            infos = {name: count[:, agent] if count.ndim == 2 else count for name, count in by_name(episode.events).items()}
            yield EpisodeBuffer(
                id=number * num_agents + agent,
                seed=episode.seed,
                options={"agent": agent, "episode": number},
                observations=np.ascontiguousarray(np.moveaxis(episode.observations[:, agent], 1, -1)),
                actions=episode.actions[:, agent].astype(np.int64),
                rewards=episode.rewards[:, agent].astype(np.float64),
                terminations=last & episode.terminated,
                truncations=last & episode.truncated,
                infos={
                    name: np.concatenate([np.zeros(1, count.dtype), count]) for name, count in infos.items()
                },  # from the first observation on
            )
