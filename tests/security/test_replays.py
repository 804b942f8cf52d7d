"""Files of episodes from elsewhere: damage is a message, sizes are looked at before anything is read, and no other file is shown."""

import io
import json
import random
import resource
import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sjdsl.cli import run
from sjdsl.replay import (
    Dataset,
    DatasetWriter,
    Episode,
    Header,
    Recording,
    RecordingError,
    dataset,
    load_recording,
    save_recording,
)

HEADER = Header(
    game="coins", environment={"game": "coins"}, hash="0", policy="stay", policy_digest=None, seed=0, episodes=0, observation="tokens",
    planes=["content"], action_names=["stay"], versions={"sjdsl": "1"},
)  # fmt: skip
SECRET = "root:x:0:0:secret"
STAGES = ("loading ", "compiling ", "playing ")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An episode of coins as `sjdsl play` writes it."""
    path = tmp_path_factory.mktemp("recorded") / "episode.json"
    assert run(["play", "coins", "--watch", "--steps", "3", "--record", str(path)]) == 0
    return path


@pytest.fixture
def many(tmp_path: Path) -> Path:
    path = tmp_path / "many.npz"
    seen = np.zeros((4, 2, 1, 3, 3), np.uint8)
    actions, rewards = np.ones((3, 2), np.int32), np.ones((3, 2), np.float32)
    with DatasetWriter(path, HEADER) as writer:
        for seed in range(2):
            writer.add(
                Episode(
                    seed,
                    seen,
                    actions,
                    rewards,
                    {"eaten": np.ones((3, 2), np.int32), "all": np.ones(3, np.int32)},
                    False,
                    True,
                )
            )
    return path


def replays(path: Path, capsys: pytest.CaptureFixture[str]) -> str:
    """Returns what `sjdsl replay` says of a damaged file: one message and no traceback."""
    capsys.readouterr()
    assert run(["replay", str(path)]) == 1
    told = capsys.readouterr()
    first, *_ = (line for line in told.err.splitlines() if not line.startswith(STAGES))
    assert first.startswith("error: "), told.err
    return told.err


def test_what_was_recorded_is_shown(recorded: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["replay", str(recorded)]) == 0
    assert "step 3" in capsys.readouterr().out
    empty = Recording.model_validate_json(recorded.read_text()).model_copy(
        update={"actions": [], "returns": [0.0, 0.0]}
    )
    save_recording(empty, recorded.with_name("empty.json"))
    assert run(["replay", str(recorded.with_name("empty.json"))]) == 0


DAMAGE: dict[str, dict[str, Any]] = {
    "no game": {"environment": {}},
    "a game that is a number": {"environment": {"game": 5}},
    "an argument that there is not": {"environment": {"game": "coins", "speed": 3}},
    "a game that there is not": {"environment": {"game": "nowhere"}},
    "a game that is a folder": {"environment": {"game": "/"}},
    "a name with a NUL": {"environment": {"game": "a\0.sj"}},
    "a long name": {"environment": {"game": "a" * 5000 + ".sj"}},
    "a variant that there is not": {"environment": {"game": "coins", "variant": "none"}},
    "a map that is a number": {"environment": {"game": "coins", "map": 5}},
    "a map that is rows": {"environment": {"game": "coins", "map": ["CC"]}},
    "a map that is a device": {"environment": {"game": "coins", "map": "/dev/zero"}},
    "a map that is not there": {"environment": {"game": "coins", "map": "/nowhere\0"}},
    "many agents": {"environment": {"game": "coins", "num_agents": 10**9}},
    "no agents": {"environment": {"game": "coins", "num_agents": -1}},
    "other numbers": {"environment": {"game": "coins", "params": {"spawn": [1, {}]}}},
    "no such number": {"environment": {"game": "coins", "params": {"none": 1}}},
    "a huge number": {"environment": {"game": "coins", "params": {"coin": 10**400}}},
    "numbers that are a list": {"environment": {"game": "coins", "params": [1]}},
    "another hash": {"hash": "0"},
    "a negative seed": {"seed": -1},
    "a huge seed": {"seed": 2**80},
    "no seed": {"seed": None},
    "too few agents": {"actions": [[0]]},
    "a negative action": {"actions": [[-1, 0]]},
    "an action that there is not": {"actions": [[0, 7]]},
    "an action that is no number": {"actions": [[0, "stay"]]},
    "actions without steps": {"actions": [0, 1]},
    "other returns": {"returns": [5.0, 5.0]},
    "returns of one agent": {"returns": [0.0]},
    "another format": {"format": "other"},
    "another key": {"more": 1},
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_episode_is_a_message(
    damage: str, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "episode.json"
    path.write_text(json.dumps(json.loads(recorded.read_text()) | DAMAGE[damage]))
    replays(path, capsys)


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[" * 100_000,
        b"null",
        b"\xff\xfe",
        b"PK\x03\x04",
        b"PK\x05\x06" + b"\0" * 18,
        b'{"seed": 1e999}',
    ],
)
def test_what_is_no_episode_is_a_message(
    content: bytes, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "episode.json"
    path.write_bytes(content)
    replays(path, capsys)


def test_bytes_of_an_episode_change(recorded: Path, tmp_path: Path) -> None:
    whole, chosen = recorded.read_bytes(), random.Random(0)
    for _ in range(300):
        damaged = bytearray(whole)
        for _ in range(chosen.choice([1, 1, 3])):
            damaged[chosen.randrange(len(damaged))] = chosen.randrange(256)
        (tmp_path / "a.json").write_bytes(damaged)
        try:
            load_recording(tmp_path / "a.json")
        except RecordingError as error:
            assert "a.json" in str(error)  # noqa: PT017 (others load: a digit has become another)


@pytest.mark.parametrize("part", ["map", "game"])
@pytest.mark.parametrize("way", ["show", "film"])
def test_no_line_of_another_file_is_printed(
    part: str, way: str, recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    secret = tmp_path / "passwd"
    secret.write_text(f"{SECRET}\nsecond:{SECRET}\n")
    content = json.loads(recorded.read_text())
    content["environment"][part] = str(secret)
    path = tmp_path / "episode.json"
    path.write_text(json.dumps(content))
    capsys.readouterr()
    assert (
        run(["replay", str(path), *(["-o", str(tmp_path / "a.gif")] if way == "film" else [])]) == 1
    )
    told = "".join(capsys.readouterr())
    assert f"{path} names a game, or a map for it, with errors: SJ" in told
    for line in (SECRET, "secret", "second"):
        assert line not in told


def test_a_folder_of_a_run_shows_no_other_file_either(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "passwd").write_text(SECRET)
    manifest = {
        "provenance": {"game": "coins", "map": str(tmp_path / "passwd")},
        "game": {},
        "config": {},
        "versions": {},
    }
    (tmp_path / "manifest.json").write_text(json.dumps(manifest))
    for command in (["evaluate", str(tmp_path)], ["train", "--resume", str(tmp_path)]):
        assert run(command) == 1
        told = "".join(capsys.readouterr())
        assert "names a game, or a map for it, with errors: SJ" in told
        assert "secret" not in told


# many episodes in one file


def test_what_was_written_is_read(many: Path) -> None:
    episodes = [*Dataset(many)]
    assert [episode.seed for episode in episodes] == [0, 1]
    assert set(episodes[0].events) == {"eaten", "all"}


@pytest.mark.parametrize("first", [0.0, 0.7], ids=["anywhere", "in the directory"])
def test_bytes_of_a_data_set_change(first: float, many: Path) -> None:
    whole, chosen, refused = many.read_bytes(), random.Random(1), 0
    written = [*Dataset(many)]
    for number in range(400):
        damaged = bytearray(whole)
        damaged[chosen.randrange(int(first * len(damaged)), len(damaged))] ^= 1 << chosen.randrange(
            8
        )
        many.write_bytes(damaged[: chosen.randrange(len(damaged))] if number % 10 == 0 else damaged)
        try:
            for episode, before in zip(Dataset(many), written, strict=True):
                np.testing.assert_equal(vars(episode), vars(before))
        except RecordingError as error:
            refused += 1
            assert "many.npz" in str(error)  # noqa: PT017 (bytes that mean nothing are in the file, too)
    assert refused > 200


def archive(path: Path, members: dict[str, bytes], method: int = zipfile.ZIP_DEFLATED) -> Path:
    with zipfile.ZipFile(path, "w", method) as file:
        for name, content in members.items():
            file.writestr(name, content)
    return path


def npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array)
    return file.getvalue()


def header(**changes: Any) -> bytes:
    return npy(np.array(HEADER.model_copy(update=changes).model_dump_json()))


def peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


@pytest.mark.parametrize("lies", [False, True], ids=["says so", "says that it is small"])
@pytest.mark.parametrize("where", ["header.npy", "returns.npy", "episode_00000/actions.npy"])
def test_a_small_file_cannot_take_much_memory(
    where: str, lies: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A member of 192 MB of zeros in 0.2 MB, where 64 MB are allowed; one that lies says in the directory that it has 100 bytes."""
    monkeypatch.setattr(dataset, "LARGEST", 64 * 2**20)
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        for name, content in (
            ("header.npy", header(episodes=1)),
            ("returns.npy", npy(np.zeros((1, 2)))),
        ):
            if name != where:
                file.writestr(name, content)
        with file.open(where, "w", force_zip64=False) as member:
            for _ in range(12):
                member.write(bytes(16 * 2**20))
    if lies:
        content = bytearray(path.read_bytes())
        for signature, offset in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
            place = content.rindex(
                signature,
                0,
                content.rindex(where.encode())
                if signature[2] == 1
                else content.index(where.encode()),
            )
            content[place + offset : place + offset + 4] = struct.pack("<I", 100)
        path.write_bytes(content)
    assert path.stat().st_size < 500_000
    before = peak()
    with pytest.raises(
        RecordingError, match=r"bomb\.npz (cannot be read|holds no recorded episodes)"
    ):
        Dataset(path)[0]
    assert peak() - before < 100 * 2**20


@pytest.mark.parametrize(
    "content",
    [
        b"\x93NUMPY\x01\x00\x76\x00"
        + b"{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776,), }".ljust(117)
        + b"\n",
        b"\x93NUMPY\x01\x00\x76\x00"
        + b"{'descr': '|O', 'fortran_order': False, 'shape': (1,), }".ljust(117)
        + b"\n"
        + b"cos\nsystem\n",
        b"\x93NUMPY\x01\x00\x76\x00"
        + b"{'descr': '<f8', 'fortran_order': False, 'shape': (-1, 8), }".ljust(117)
        + b"\n",
        b"\x93NUMPY\x09\x00\x76\x00",
        b"\x93NUMPY\x01\x00\x76\x00" + (b"(" * 117) + b"\n",
        b"",
        npy(np.zeros((3, 2))),
        npy(np.zeros((1, 2), np.complex128)),
    ],
)
def test_an_array_that_lies_is_refused(content: bytes, tmp_path: Path) -> None:
    path = archive(tmp_path / "a.npz", {"header.npy": header(episodes=1), "returns.npy": content})
    with pytest.raises(
        RecordingError, match=r"a\.npz (cannot be read|holds no recorded episodes|is damaged)"
    ):
        Dataset(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_other_ways_to_compress_are_not_read(method: int, tmp_path: Path) -> None:
    path = archive(
        tmp_path / "a.npz",
        {"header.npy": header(episodes=0), "returns.npy": npy(np.zeros((0, 2)))},
        method,
    )
    with pytest.raises(RecordingError):
        Dataset(path)


@pytest.mark.parametrize(
    "changed",
    [
        {"actions": np.zeros((3, 2))},
        {"actions": np.zeros(3, np.int32)},
        {"rewards": np.zeros((3, 3), np.float32)},
        {"rewards": np.zeros((3, 2), "<U3")},
        {"observations": np.zeros((3, 2, 1, 3, 3), np.uint8)},
        {"observations": np.zeros((4, 2, 1, 3, 3), np.float32)},
        {"events/eaten": np.zeros((4, 2), np.int32)},
        {"events/eaten": np.zeros((3, 2), np.float32)},
        {"seed": np.zeros((2, 2), np.int32)},
        {"terminated": np.array("yes please")},
        {"more": np.zeros(3)},
        {"actions": None},
        {"seed": None},
    ],
)
def test_arrays_of_no_episode_are_refused(
    changed: dict[str, np.ndarray | None], many: Path
) -> None:
    with zipfile.ZipFile(many) as file:
        members = {name: file.read(name) for name in file.namelist()}
    for name, array in changed.items():
        members.pop(f"episode_00000/{name}.npy", None)
        if array is not None:
            members[f"episode_00000/{name}.npy"] = npy(array)
    archive(many, members)
    with pytest.raises(RecordingError, match=r"many\.npz (cannot be read|is damaged)"):
        Dataset(many)[0]


def test_what_is_changed_with_its_checksum_is_seen(many: Path) -> None:
    """An archive that is whole, with other numbers in one array."""
    with zipfile.ZipFile(many) as file:
        members = {name: file.read(name) for name in file.namelist()}
    for name in (
        "returns.npy",
        "digests.npy",
        "episode_00001/rewards.npy",
        "episode_00001/terminated.npy",
        "episode_00001/observations.npy",
    ):
        changed = bytearray(members[name])
        changed[-1] ^= 1
        archive(many, {**members, name: bytes(changed)})
        with pytest.raises(RecordingError, match=r"many\.npz (cannot be read|is damaged)"):
            Dataset(many)[1]
    archive(many, {**members, "header.npy": header(episodes=2)})
    with pytest.raises(RecordingError, match="is damaged: its arrays are not those"):
        Dataset(many)
    archive(
        many, {name: content for name, content in members.items() if "observations" not in name}
    )
    with pytest.raises(
        RecordingError, match="is damaged: its arrays are not those that its header names"
    ):
        Dataset(many)


@pytest.mark.parametrize("episodes", [3, 10**12, 10**30])
def test_more_episodes_than_there_are(episodes: int, many: Path) -> None:
    with zipfile.ZipFile(many) as file:
        members = {name: file.read(name) for name in file.namelist()}
    told = Dataset(many).header.model_copy(update={"episodes": episodes})
    archive(many, {**members, "header.npy": npy(np.array(told.model_dump_json()))})
    with pytest.raises(
        RecordingError, match=rf"is damaged: it doesn't hold the returns of {episodes} episodes"
    ):
        Dataset(many)
