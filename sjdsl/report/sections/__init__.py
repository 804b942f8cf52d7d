"""The sections of a report, in their order: each makes its tables and pictures of the evidence."""

from collections.abc import Callable

from sjdsl.report.contents import Contents
from sjdsl.report.page import Section
from sjdsl.report.sections.diagrams import diagrams
from sjdsl.report.sections.exchange import exchange
from sjdsl.report.sections.hours import hours
from sjdsl.report.sections.learning_curves import learning_curves
from sjdsl.report.sections.meetings import meetings
from sjdsl.report.sections.metrics import metrics
from sjdsl.report.sections.over_games import over_games
from sjdsl.report.sections.own_and_common import own_and_common
from sjdsl.report.sections.sharing import sharing
from sjdsl.report.sections.speed import speed
from sjdsl.report.sections.svo import svo

SECTIONS: tuple[Callable[[Contents], Section], ...] = (
    own_and_common,
    learning_curves,
    sharing,
    exchange,
    svo,
    metrics,
    over_games,
    diagrams,
    meetings,
    speed,
    hours,
)
