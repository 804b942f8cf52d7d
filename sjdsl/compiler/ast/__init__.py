"""The abstract syntax tree of one file as written: a frozen dataclass for each grammar rule, `span` first, no meaning yet."""

from sjdsl.compiler.ast.declarations import *
from sjdsl.compiler.ast.expressions import *
from sjdsl.compiler.ast.statements import *
