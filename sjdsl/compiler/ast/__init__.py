"""The abstract syntax tree (AST) of one file.

A frozen dataclass for each grammar rule, without any meaning yet.
"""

from sjdsl.compiler.ast.declarations import *
from sjdsl.compiler.ast.expressions import *
from sjdsl.compiler.ast.statements import *
