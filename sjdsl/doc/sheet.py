"""The rule sheet of a game in plain English, in the order of the ODD protocol (Grimm et al. 2020, JASSS 23(2) 7)."""

from sjdsl.doc.checks import checks, episode, metrics
from sjdsl.doc.defines import explained, vocabulary
from sjdsl.doc.entities import entities
from sjdsl.doc.numbers import parameters
from sjdsl.doc.observation import observation
from sjdsl.doc.policies import heading, policies, scenarios
from sjdsl.doc.quoted import laid_out, written_text
from sjdsl.doc.randomness import draws
from sjdsl.doc.reading import how_to_read
from sjdsl.doc.schedule import overview
from sjdsl.doc.statements import block, turn_lines
from sjdsl.doc.vocabulary import Vocabulary
from sjdsl.doc.wording import bullets, code, fenced, plain
from sjdsl.doc.written import Written


def rule_sheet(w: Written) -> str:
    """Returns the whole sheet as Markdown."""
    v = vocabulary(w.game)
    sections = (
        ("Purpose", purpose(w)),
        ("Entities, state and scales", entities(v)),
        ("Parameters", parameters(w)),
        ("Process overview: one step", overview(v)),
        ("How to read the rules", how_to_read(v)),
        *([("Names", names(w, v))] if w.composition.defines else []),
        ("Initialisation", initialisation(v)),
        ("Phases", phases(v)),
        ("Random draws", draws(v)),
        ("Observation", observation(v)),
        ("Episode", episode(v)),
        ("Metrics", metrics(v)),
        ("Checks", checks(w)),
        *([("Policies", policies(w))] if w.game.policies else []),
        *([("Scenarios", scenarios(w))] if w.game.scenarios else []),
        *([("Pictures", pictures(w))] if w.game.looks else []),
        ("Variants", variants(w)),
    )
    name = f"{code(w.game.name)}, from {code(w.file)}" + (f", variant {code('+'.join(w.chosen))}" if w.chosen else "")
    found = [f"# {plain(w.game.title or w.game.name)}", "", f"The rules of the game {name}.", ""]
    for title, lines in sections:
        found += [f"## {title}", "", *lines]
    return "\n".join(found).rstrip("\n") + "\n"


def purpose(w: Written) -> list[str]:
    """Returns what the file says the game is about."""
    about = dict(w.game.about)
    summary = about.pop("summary", "")
    found = [plain(summary), ""] if summary else []
    found += [f"- {plain(key.replace('_', ' '))}: {plain(text)}" for key, text in about.items()]
    found += [f"- source: {plain(cite)}" for cite in w.game.cites]
    return [*found, ""] if found else ["The file does not say.", ""]


def names(w: Written, v: Vocabulary) -> list[str]:
    """Returns what each define means, or how it is written where that depends on what it is used for."""
    rest = [define for name, define in w.composition.defines.items() if name not in v.defined]
    quoted = [*fenced(laid_out(written_text(w.composition, rest))), ""] if rest else []
    return [*bullets(explained(v)), *([""] if v.defined else []), *quoted]


def initialisation(v: Vocabulary) -> list[str]:
    """Returns how an episode begins."""
    first = "Fields have their starting values, cells the state that their glyph on the map stands for; no agent has a place, all look north. Then:"
    return [first, "", *bullets(block(v.game.start.body, v)), ""]


def phases(v: Vocabulary) -> list[str]:
    """Returns each turn of the schedule with its statements."""
    found = []
    for number, (name, lines) in enumerate(turn_lines(v), 1):
        found += [f"### {number}. {code(name)}", "", *(bullets(lines) if lines else ["Nothing happens."]), ""]
    return found


def pictures(w: Written) -> list[str]:
    """Returns how cells and agents are drawn, as it is written."""
    intro = "No rule depends on this. What is not said is drawn as the game's rules suggest."
    looks = [look for found in w.composition.looks.values() for look in found]
    return [intro, "", *fenced(laid_out(written_text(w.composition, looks))), ""]


def variants(w: Written) -> list[str]:
    """Returns the variants of the game; their differences are another report."""
    if not w.variants:
        return ["None.", ""]
    return [
        *(f"- {heading(*variant)}" for variant in w.variants),
        "",
        f"`sjdsl diff {w.file} --variants default {w.variants[0][0]}` says what a variant changes.",
        "",
    ]
