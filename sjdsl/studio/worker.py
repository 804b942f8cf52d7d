"""The process of a bench, with requests and answers as lines of JSON.

Its arguments are the folder of the games and, with seats, a `Seats` as JSON.

Whatever a text makes it do ends with the process.
"""

import contextlib
import gc
import json
import os
import sys
import traceback
from pathlib import Path

from pydantic import ValidationError

from sjdsl.studio.bench import Bench
from sjdsl.studio.child import number_of
from sjdsl.studio.requests import READ
from sjdsl.studio.seats import Seats

MEMORY = 8 * 2**30  # bytes of address space for a bench; JAX reserves some


def main() -> None:
    """Prints that it is ready, then an answer to every line of the standard input."""
    _limit_memory()
    # An accelerator is left to trainings beside the studio.
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    answers = sys.stdout
    sys.stdout = sys.stderr  # so that nothing else is printed among the answers
    folder, *seats = sys.argv[1:]
    bench = Bench(Path(folder), Seats(**json.loads(seats[0])) if seats else None)
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):  # the server has ended
        collect_seldom()
        print(json.dumps({"ready": True}), file=answers, flush=True)
        for line in sys.stdin.buffer:
            answer = answer_line(bench, line.decode())
            print(json.dumps(answer), file=answers, flush=True)


def collect_seldom() -> None:
    """Lets Python collect cyclic garbage less often, and skip what is loaded.

    By default that takes a fifth of the time of an edit.
    """
    gc.freeze()
    gc.set_threshold(10_000, 10, 10)


def answer_line(bench: Bench, line: str) -> dict[str, object]:
    """Returns the answer to a request, a line of JSON.

    A request that is invalid, or needs too much memory, is refused with the reason.
    """
    try:
        request = READ.validate_json(line)
    except ValidationError as error:
        first = error.errors()[0]
        location = ".".join(map(str, first["loc"]))
        subject = f"something unknown, {location}" if location else "something unknown"
        reason = f"the page asked for {subject}: {first['msg']}"
        return {"id": number_of(line), "refused": reason[:1000]}
    try:
        return bench.answer(request)
    except MemoryError:
        reason = f"this takes more memory than the studio allows, {MEMORY // 2**30} GiB"
    except RecursionError:
        reason = "the text is nested too deeply"
    except Exception as error:  # the user's work isn't lost for it
        traceback.print_exc()
        reason = (
            "this is a fault of sjdsl, not of yours; the terminal has more: "
            f"{type(error).__name__}: {error}"
        )
    return {"id": request.id, "do": request.do, "refused": reason[:1000]}


def _limit_memory() -> None:
    """Lets this process have no more than MEMORY, where the system has such a limit."""
    with contextlib.suppress(ImportError, ValueError, OSError):
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


if __name__ == "__main__":
    main()
