"""What the sections of a report are about: the evidence, and the games in the order and under the names that tables have."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, replace

from sjdsl.experiments.bundled_rules import rules_now, variant_now
from sjdsl.games_folder import game_names
from sjdsl.report.cells import Index, Setting
from sjdsl.report.evidence import DiagramRow, Evidence, Meeting
from sjdsl.report.published import remarks, suite, variant


@dataclass(frozen=True)
class Game:
    """A game of a report. `setting`: as it was trained in; None for a game of the suite in which nothing was trained under its rules."""

    name: str
    label: str
    setting: Setting | None

    @property
    def published(self) -> str:
        """The name under which the paper has figures of it: of its own rules, numbers and map only."""
        of_the_paper = self.setting is None or (self.setting.plain and self.setting.variant == variant(self.name))
        return self.name if of_the_paper else ""

    @property
    def asked(self) -> tuple[str, str]:
        """Its name and the variant that it was, or is to be, trained in."""
        return self.name, variant(self.name) if self.setting is None else self.setting.variant


@dataclass(frozen=True)
class Contents:
    """The evidence and the games that it is shown of."""

    index: Index
    games: tuple[Game, ...]
    whole_suite: bool

    @property
    def evidence(self) -> Evidence:
        """What was read."""
        return self.index.evidence

    @property
    def names(self) -> tuple[str, ...]:
        """The games that tables without training are of: those found anywhere, and with `whole_suite` the nine."""
        tables = ("runs", "diagrams", "speeds", "updates", "meetings")
        found = {row.game for table in tables for row in getattr(self.evidence, table)}
        return tuple(_ordered(found | (set(suite()) if self.whole_suite else set())))

    @property
    def plain_names(self) -> tuple[str, ...]:
        """The names without those of variants, which are games only in measurements of speed: commands are made for these."""
        return tuple(name for name in self.names if "+" not in name)

    def wanted_variant(self, name: str) -> str:
        """Returns the variant of a game in which commands find what is missing: the paper's on the page of the whole suite, else none."""
        return variant(name) if self.whole_suite and name in suite() else ""

    def of_the_paper(self, row: DiagramRow | Meeting) -> bool:
        """Returns whether a game was played by the rules and numbers of the paper."""
        theirs = variant(row.game)
        trained = {s.hash for s in self.index.settings if s.game == row.game and s.variant == theirs}
        return not row.params and (row.hash in trained or row.hash == (rules_now(row.game, theirs) or ("",))[0])

    def form(self, row: DiagramRow | Meeting) -> str:
        """Returns what differs in the game that was played from the bundled game as it is now, in words; `""` where nothing does."""
        now = rules_now(row.game, "")
        if now is None or row.hash == now[0]:
            return row.params
        trained = (setting for setting in self.index.settings if (setting.game, setting.hash) == (row.game, row.hash))
        known = next((_forms(setting.variant, setting.map) for setting in trained if setting.variant or setting.map), None)
        theirs = self.of_the_paper(replace(row, params=""))
        forms = known or _forms(variant(row.game) if theirs else variant_now(row.game, row.hash) or "")
        forms = forms or [f"rules {row.hash[:6]}", f"{row.num_agents} agents"]
        return ", ".join([*forms, *filter(None, (row.params,))])


def called(names: Iterable[str], form: str = "") -> str:
    """Returns games as a command names them, each once: bundled and installed ones by name, others by their file; and their variant."""
    known = set(game_names())
    games = [name if name in known else f"{name}.sj" for name in dict.fromkeys(names)]
    return " ".join([*games, *(("--variant", form) if form else ())])


def sweeps_of(games: Iterable[tuple[str, str]], options: str, run: str) -> tuple[str, ...]:
    """Returns the commands that train in games, each with its variant: one for all of the same. `run`: the folder, without the variant."""
    by_variant: dict[str, list[str]] = {}
    for name, form in games:
        by_variant.setdefault(form, []).append(name)
    return tuple(
        f"sjdsl sweep {called(names, form)} {options} --preset two_cores --seeds 5 --run {in_folder(run, form)}"
        for form, names in by_variant.items()
    )


def in_folder(run: str, form: str) -> str:
    """Returns the folder of a sweep in a variant."""
    return f"{run}_{form}" if form else run


def contents_of(evidence: Evidence, whole_suite: bool) -> Contents:
    """Returns what there is to show; `whole_suite`: the nine games of the paper, also where nothing is known of them."""
    index = Index(evidence)
    settings = index.settings
    plain = {setting: _label(setting) for setting in settings}
    twice = {label for label, count in Counter(plain.values()).items() if count > 1}
    games = [
        Game(s.game, f"{label}, rules {s.hash[:6]}, {s.num_agents} agents" if label in twice else label, s) for s, label in plain.items()
    ]
    there = {game.published for game in games}
    games += [Game(name, f"{name}, variant {variant(name)}", None) for name in suite() if whole_suite and name not in there]
    order = _ordered({game.name for game in games})
    return Contents(index, tuple(sorted(games, key=lambda game: (order.index(game.name), game.label))), whole_suite)


def _ordered(names: set[str]) -> list[str]:
    """Returns the games of the paper in its order, then the others by name."""
    return [name for name in suite() if name in names] + sorted(names - set(suite()))


def _label(setting: Setting) -> str:
    variant, other_map = _forms(setting.variant), _forms(map_name=setting.map)
    return ", ".join([setting.game, *variant, *filter(None, (setting.params,)), *other_map])


def _forms(variant: str = "", map_name: str = "") -> list[str]:
    """Returns a variant and a map as labels name them, those that there are."""
    return [f"{word} {name}" for word, name in (("variant", variant), ("map", map_name)) if name]


def remarks_of(contents: Contents, table: str) -> list[str]:
    """Returns what is to be known of the paper's figures of the games shown, in one of its tables: a list, as one paragraph."""
    shown = {game.published for game in contents.games}
    lines = [f"* {game}: {note}." for game, note in remarks(table).items() if game in shown]
    return ["\n".join(["Of the published figures:", "", *lines])] if lines else []


def notes_of_rules(contents: Contents) -> list[str]:
    """Returns which results are of other rules than the bundled games have now."""
    notes = []
    for game in contents.games:
        setting = game.setting
        if setting is None or not setting.plain:
            continue
        now = rules_now(setting.game, setting.variant)
        if now is not None and now[1] == setting.num_agents and now[0] != setting.hash:
            notes.append(f"the runs of {game.label} are of other rules ({setting.hash}) than the game has now ({now[0]})")
    trained = {game.setting.hash for game in contents.games if game.setting is not None}
    played = [("diagram", row.game, row.hash) for row in contents.evidence.diagrams]
    played += [("cross-play", row.game, row.hash) for row in contents.evidence.meetings]
    for what, name, rules in played:
        now = rules_now(name, "")
        if now is not None and rules not in {now[0], *trained} and variant_now(name, rules) is None:
            notes.append(f"the {what} of {name} is of other rules ({rules}) than the game has now ({now[0]})")
    return list(dict.fromkeys(notes))
