"""SJ4xx: write conflicts; SJ5xx: time and unused names; SJ6xx: limits of the compiler."""

from sjdsl.compiler.diagnostics.diagnostic import AboutName, Diagnostic


class WriteConflict(AboutName, code="SJ401", title="Two writes in one phase"):
    says = "`{name}` of one {owner} can be written twice in phase `{phase}`"
    hints = (
        "{lot}",
        "write `by lot` after it, to let one of the writers win at random; or `otherwise`, "
        "if one of two should happen; "
        "or `pick 1`, if one of several should; or pair them with `match`; or write two phases; "
        "or collect into a `set of agent` and `pick 1` from it in the next phase; or use `add`",
    )
    owner: str
    phase: str
    lot: str = ""


class AddAndSet(AboutName, code="SJ402", title="Set and add in one phase"):
    says = "`{name}` is both set and added to in phase `{phase}`"
    hints = ("write two phases, or let one of the two happen with `otherwise`",)
    phase: str


class TwoDestinations(Diagnostic, code="SJ403", title="Two destinations"):
    says = "{who} can be sent to two places in phase `{phase}`"
    hints = ("let one of the two happen with `otherwise`, or send to one place",)
    phase: str
    who: str = "an agent"


class NoWayFree(Diagnostic, code="SJ404", title="There may be no free cell"):
    says = "the way can be blocked, taken, or leave the map"
    hints = ("write `otherwise stay` after it: who cannot go there stays",)


class PerhapsTaken(NoWayFree):
    says = "somebody may already stand on `{place}`, the cell bound by an outer statement"
    place: str


class TakenOrNowhere(NoWayFree):
    says = "somebody may stand on `{place}`, or it may be nowhere"
    place: str


class NoFreeCell(NoWayFree):
    says = "perhaps no cell of `{place}` is free: which cells fit changes in play"
    hints = ("write `otherwise stay` after it: who then finds no cell stays",)
    place: str


class TooFewFreeCells(NoFreeCell):
    says = "`{place}` has {cells:cell}, and up to {agents:agent}{movers} may be there or come"
    hints = (
        "write `otherwise stay` after it, or take a map with more such cells, or fewer agents",
    )
    cells: int
    agents: int
    movers: str = ""


class TooFewToStart(TooFewFreeCells):
    says = "{cells:cell} of the map fit `{place}`, and {agents:agent}{movers} begin there"
    hints = ("take a map with more such cells, or fewer agents",)


class TooFewForOne(TooFewFreeCells):
    says = (
        "{cells:cell} of the map certainly fit `{place}` for {who}, "
        "and {agents:agent}{movers} with lower numbers may take them first"
    )
    hints = (
        "take a map with more such cells, or a condition that leaves each agent cells of its own",
    )
    who: str


class MoveAlone(Diagnostic, code="SJ405", title="Movement shares its phase"):
    says = "`move` stands alone in its phase"
    hints = ("put the other statements into a phase of their own",)


class NoStart(Diagnostic, code="SJ501", title="Agents without a place"):
    says = "the game has no `phase start`"
    hints = ("write `phase start {{ each agent {{ send agent to KIND }} }}`",)


class NotSentAtStart(NoStart):
    """`sort`: `agent`, or the sort of the movers."""

    says = "`phase start` does not always send {who} to a place"
    hints = ("write `phase start {{ each {sort} {{ send {sort} to KIND }} }}`",)
    who: str
    sort: str


class TickTwice(Diagnostic, code="SJ502", title="The schedule and its timers"):
    says = "`tick` stands twice in the schedule"
    hints = ("keep one",)


class NoTick(TickTwice):
    says = "{need}, but no `tick` in the schedule"
    hints = ("write `tick` among the phases, where their time runs: `schedule tick -> …`",)
    need: str


class TimerBothSides(
    AboutName, code="SJ503", title="A timer set on both sides of `tick`", severity="warning"
):
    says = "timer `{name}` is set before and after `tick`"
    hints = ("set it on one side, or it lasts one step less on the other",)


class NeverHappens(Diagnostic, code="SJ504", title="This can never happen", severity="warning"):
    says = "this can never happen: {problem}"
    problem: str


class Unused(AboutName, code="SJ505", title="Never used", severity="warning"):
    says = "{entity} `{name}` is never used"
    entity: str


class IdleAction(AboutName, code="SJ506", title="An action without effect", severity="warning"):
    says = "no rule reads the action `{name}`, so choosing it is the same as `stay`"
    hints = (
        "ask for it where it matters, `each agent where agent chose {name}`, "
        "or take it out of `acts`",
    )


class IdleSteps(Diagnostic, code="SJ506", title="An action without effect", severity="warning"):
    says = "no phase of the schedule has `move`, so nobody moves by {names}"
    hints = (
        "write `phase walk {{ move each agent }}` and schedule it, or take them out of `acts`",
    )
    names: str


class ForbidReads(Diagnostic, code="SJ507", title="What `forbid` may read"):
    says = "`forbid` reads {reads}"
    hints = ("it may read the acting agent's own fields and the world's",)
    reads: str


class NoPlaceYet(Diagnostic, code="SJ508", title="No place yet"):
    says = "in `phase start` no agent has a place yet, so `{expression}` means nothing"
    hints = ("do it in a phase that follows it: `phase NAME at start {{ … }}`",)
    expression: str


class NotBeforeSteps(Diagnostic, code="SJ518", title="Nothing before the first step"):
    says = "{what} in `phase {name}`, with which an episode begins: there is no step yet"
    hints = ("do it in a phase of the schedule, at `step == 0`",)
    what: str
    name: str


class NoPlaceWhenBack(NoPlaceYet):
    says = (
        "`{name}` finds its cell when it comes back; "
        "until then it has no place and chooses nothing, so `{expression}` means nothing"
    )
    hints = ("keep what it needs in a field of its own, set before it is sent away",)
    name: str


class NoPlaceBefore(NoPlaceYet):
    says = "`{name}` may have been away when the step began, and then `{expression}` means nothing"
    hints = (
        "name the agents inside `before`, where they are those of that time: "
        "`before(count(agent as x where x.row > 2))`",
    )
    name: str


class NeverCounted(
    AboutName, code="SJ509", title="An event that is never counted", severity="warning"
):
    says = "the event `{name}` is listed in `metrics`, but no rule counts it: it is always 0"
    hints = ("count it where it happens, `tally {path}`, or take it out of `metrics`",)
    path: str


class LookReads(Diagnostic, code="SJ510", title="What `look` may read"):
    says = "`look` reads {reads}"
    hints = ("it may compare the fields of the cell, or of the agent, with words and numbers",)
    reads: str


class SlotsUnfilled(AboutName, code="SJ511", title="A scenario that does not fill its slots"):
    says = "the slots of the scenario `{name}` add up to {slots}, and the game has {agents} agents"
    hints = (
        "count from the number of agents: `slots players - 2 policy defector`, "
        "where `size players` is that number",
    )
    slots: int
    agents: int


class NoFocalSlot(AboutName, code="SJ512", title="A scenario without a focal agent"):
    says = "nobody is evaluated in the scenario `{name}`"
    hints = ("write `slots 1 focal` for those whose policy is evaluated",)


class SoughtBlocks(
    Diagnostic, code="SJ513", title="A policy that cannot get there", severity="warning"
):
    """`when`: the condition under which it blocks, empty for always."""

    says = "agents cannot enter `{kind}`, which blocks them{when}, so no path leads there"
    hints = ("`aim diamond(1) at {kind} choose ACTION` walks until one is beside the agent",)
    kind: str
    when: str = ""


class SeeksItself(
    AboutName, code="SJ513", title="A policy that cannot get there", severity="warning"
):
    says = "the agent is a member of this domain itself, and stays where it is"
    hints = ("write `where {name} is not agent`",)


class BlindPath(
    Diagnostic, code="SJ513", title="A policy that cannot get there", severity="warning"
):
    says = (
        "paths don't take into account that `{kind}` blocks agents when {when}, "
        "so an agent may push against such a cell for ever"
    )
    hints = ("let it avoid those cells: `avoiding {avoided}`",)
    kind: str
    when: str
    avoided: str


class HiddenField(AboutName, code="SJ514", title="A field that a label hides", severity="warning"):
    says = "agents don't see `{kind}.{name}` any more: no label of `{kind}` reads it"
    hints = (
        "read it in the condition of a label, "
        "or write `hide {kind}.{name}` if nobody should see it",
    )
    kind: str


class TrialIsCounted(Diagnostic, code="SJ515", title="Trials"):
    says = "no rule can change `trial`: it counts the trials of the episode, from 0"
    hints = ("to count something else, declare a field, and `keep` it",)


class NotKept(TrialIsCounted):
    says = "`{name}` cannot be kept from one trial to the next: only fields and timers can"
    hints = (
        "keep fields as `agent.bag`, `tree.hue`, or by name if they are of the world; "
        "where agents and movers are begins anew with each trial",
    )
    name: str


class KeptAnyway(AboutName, code="SJ516", title="Tasks"):
    says = "`{name}` is part of the task, which stays as it is in all trials of an episode"
    hints = ("take it out of `keep`",)


class TaskWritten(AboutName, code="SJ516", title="Tasks"):
    says = "no rule can change `{name}`: it is part of the task, which is drawn for an episode"
    hints = ("for what changes in an episode, declare a field of the world",)


class TaskTold(AboutName, code="SJ516", title="Tasks"):
    says = "a `forbid` would tell agents `{name}`, which is part of the task and not shown"
    hints = ("add `show {name}` to `observe`, or let the action have no effect instead",)


class SecondTask(AboutName, code="SJ516", title="Tasks"):
    says = "a game has one task, and this is a second, `{name}`"
    hints = ("put its fields into the first",)


class SplitOfNothing(AboutName, code="SJ517", title="Splits of tasks"):
    says = "the game has no task `{name}` to split"
    hints = ("declare it: `task {name} {{ field hue : {{ red, green }} }}`",)


class SplitReads(AboutName, code="SJ517", title="Splits of tasks"):
    says = "`hold out {name}` reads more than the task"
    hints = (
        "the condition may read fields of the task, numbers and `size`s: "
        "what is held out is known before an episode begins",
    )


class NothingHeldOut(AboutName, code="SJ517", title="Splits of tasks"):
    says = "`hold out {name}` holds out no task: its condition never holds"
    hints = ("write a condition that holds for some tasks",)


class NothingToTrainOn(Diagnostic, code="SJ517", title="Splits of tasks"):
    says = "every task is held out, and none is left to train on"
    hints = ("write conditions that are all false for some tasks",)


class TooManyToTrainOn(Diagnostic, code="SJ517", title="Splits of tasks"):
    """tasks: that can be trained on. most: of them, so that half are left."""

    says = "{number} training tasks, out of {tasks}, leave less than half of them held out"
    hints = (
        "write {most} at most, or `hold out` those that must not be learned from",
        "give the task more fields, or fields more values",
    )
    number: int
    tasks: int
    most: int


class Unsupported(Diagnostic, code="SJ601", title="Not supported yet"):
    says = "not supported yet: {feature}"
    feature: str
