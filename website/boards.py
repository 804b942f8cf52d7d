"""The moving picture and the live board of a game: an episode of its policies on the interpreter, kept until something of it changes."""

import hashlib
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, repeat
from multiprocessing import get_context
from pathlib import Path

from PIL import Image

from sjdsl.cli.play import play_interpreted
from sjdsl.cli.policies import SIDE_BY_SIDE, players_of
from sjdsl.compiler import build, ir
from sjdsl.compiler.ir.hash import printed_digest
from sjdsl.compiler.syntax.read import read_source
from sjdsl.interpreter.state import default_params
from sjdsl.interpreter.threefry import Threefry
from sjdsl.library.games_folder import find_game
from sjdsl.policies.interpreted import choose
from sjdsl.render.board import draw_board
from sjdsl.render.episode_page import make_page
from sjdsl.render.film import save_gif
from sjdsl.render.look import make_look
from sjdsl.render.moment import Moment
from sjdsl.trace.choices import Chosen, chooser
from sjdsl.trace.jax_random import keys_of

ROOT = Path(__file__).resolve().parents[1]
STEPS = 40
SEED = 0
WIDTH = 400  # pixels of a moving picture, at most
# What a picture depends on, beside the rules.
CODE = (
    "sjdsl/cli/play.py",
    "sjdsl/cli/policies.py",
    "sjdsl/interpreter",
    "sjdsl/policies",
    "sjdsl/render",
    "sjdsl/runtime/episode_keys.py",
    "sjdsl/trace",
    "website/boards.py",
)
PROCESSES = 2


@dataclass(frozen=True)
class Board:
    """A game in a variant. name: of its files."""

    name: str
    game: str
    variant: str = ""


def rules_of(board: Board) -> ir.Game:
    """Returns the rules. Raises CompileError, FileNotFoundError."""
    return build(read_source(find_game(board.game)), [board.variant] if board.variant else []).game


def side_by_side(game: ir.Game, seed: int) -> Chosen:
    """Returns who plays: the policies of the game's file in turn, agent by agent, or, in a game without policies, random agents."""
    if not game.policies:
        return chooser(game, "random", seed)
    keys, count = keys_of(seed), len(game.policies)

    def choose_all(number: int, world: object) -> list[int]:
        draws = Threefry(*keys.of_choices(number))
        bits = [
            (draws.bits(0, 2 * agent), draws.bits(0, 2 * agent + 1))
            for agent in range(game.agents.number)
        ]
        return [
            choose(game.policies[agent % count], game, world, agent, two)
            for agent, two in enumerate(bits)
        ]  # type: ignore[arg-type]

    return choose_all


def played(game: ir.Game, steps: int = STEPS, seed: int = SEED) -> Iterator[Moment]:
    """Returns the moments of one episode, at most so many steps long."""
    return play_interpreted(
        game, default_params(game), seed, side_by_side(game, seed), repeat({}, steps)
    )


def write(board: Board, folder: Path) -> None:
    """Writes NAME.html, NAME.gif and NAME.png, the last moment; nothing if they are there and what they show is the same."""
    game = rules_of(board)
    note, digest = folder / f"{board.name}.digest", f"{printed_digest(game)} {code_digest()}"
    if note.is_file() and note.read_text("utf-8") == digest:
        return
    moments = list(played(game))
    page = make_page(game, moments, players=players_of(SIDE_BY_SIDE, game), seed=SEED)
    page.save(folder / f"{board.name}.html")
    frames = list(_frames(game, moments))
    save_gif(frames, folder / f"{board.name}.gif")
    frames[-1].save(folder / f"{board.name}.png")
    note.write_text(digest, "utf-8")


def _frames(game: ir.Game, moments: Sequence[Moment]) -> Iterator[Image.Image]:
    look = make_look(game)
    for before, moment in pairwise([None, *moments]):
        assert moment is not None
        picture = Image.fromarray(
            draw_board(
                look, moment.snapshot, moment.actions, None if before is None else before.snapshot
            )
        )
        smaller = min(1.0, WIDTH / picture.width)
        yield picture.resize(
            (round(picture.width * smaller), round(picture.height * smaller)),
            Image.Resampling.LANCZOS,
            reducing_gap=2.0,
        )


@cache
def code_digest() -> str:
    """Returns a digest of the code that plays and draws."""
    digest = hashlib.sha256()
    for place in CODE:
        path = ROOT / place
        files = (
            [path]
            if path.is_file()
            else sorted(p for p in path.rglob("*") if p.is_file() and "__pycache__" not in p.parts)
        )
        for file in files:
            digest.update(f"{file.relative_to(ROOT)}\n".encode() + file.read_bytes())
    return digest.hexdigest()[:16]


def write_all(boards: Sequence[Board], folder: Path) -> None:
    """Writes the files of all boards, several at once."""
    folder.mkdir(parents=True, exist_ok=True)
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        list(pool.map(write, boards, [folder] * len(boards)))
