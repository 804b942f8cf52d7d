"""The process in which a bench works: requests and answers as lines of JSON. What a text makes it do ends with it."""

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

MEMORY = 8 * 2**30  # bytes of addresses that a bench may take; JAX reserves some


def main() -> None:
    """Says that it is ready, then answers every line of the standard input with one of the standard output, until there are no more."""
    _limit_memory()
    os.environ.setdefault(
        "JAX_PLATFORMS", "cpu"
    )  # an accelerator is for whoever trains beside the studio
    answers = sys.stdout
    sys.stdout = sys.stderr  # what anything prints is no answer
    bench = Bench(Path(sys.argv[1]))
    with contextlib.suppress(BrokenPipeError, KeyboardInterrupt):  # the server has gone
        collect_seldom()
        print(json.dumps({"ready": True}), file=answers, flush=True)
        for line in sys.stdin.buffer:
            print(json.dumps(answered(bench, line.decode())), file=answers, flush=True)


def collect_seldom() -> None:
    """Has Python look for garbage in circles less often, and not among what is loaded: by default that takes a fifth of the time of an edit."""
    gc.freeze()
    gc.set_threshold(10_000, 10, 10)


def answered(bench: Bench, line: str) -> dict[str, object]:
    """Returns the answer to a request, a line of JSON; one that is not understood, or takes too much, is refused with the reason."""
    try:
        request = READ.validate_json(line)
    except ValidationError as error:
        wrong = error.errors()[0]
        place = ".".join(map(str, wrong["loc"]))
        told = (
            f"the page asked for something unknown{f', {place}' if place else ''}: {wrong['msg']}"
        )
        return {"id": number_of(line), "refused": told[:1000]}
    try:
        return bench.answer(request)
    except MemoryError:
        return {
            "id": request.id,
            "do": request.do,
            "refused": f"this takes more memory than the studio allows, {MEMORY // 2**30} GiB",
        }
    except RecursionError:
        return {"id": request.id, "do": request.do, "refused": "the text is nested too deeply"}
    except Exception as error:  # what somebody has made so far is not lost for it
        traceback.print_exc()
        told = f"this is a fault of sjdsl, not of yours; the terminal has more: {type(error).__name__}: {error}"
        return {"id": request.id, "do": request.do, "refused": told[:1000]}


def _limit_memory() -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):  # not every system has this limit
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


if __name__ == "__main__":
    main()
