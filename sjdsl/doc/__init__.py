"""All the rules of a game on a page, and the differences between two games."""

from sjdsl.doc.differences import differences, report
from sjdsl.doc.sheet import rule_sheet
from sjdsl.doc.written import Written, WrittenNumber, read_written

__all__ = ["Written", "WrittenNumber", "differences", "read_written", "report", "rule_sheet"]
