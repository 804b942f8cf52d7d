"""The typed IR.

A game with names resolved, sizes computed, phase uses expanded and random draws named.

Words and agents are values; numbers carry their unit and the interval they provably stay in.
Variables are named as in the text; an inner one never has the name of an outer one. All nodes are
frozen and compare by content; `origin` is the only part that two equal programs may differ in.
"""

from sjdsl.compiler.diagnostics.tree import children as children
from sjdsl.compiler.diagnostics.tree import walk as walk
from sjdsl.compiler.ir.entity_types import EntityType as EntityType
from sjdsl.compiler.ir.entity_types import Entry as Entry
from sjdsl.compiler.ir.entity_types import IndexSet as IndexSet
from sjdsl.compiler.ir.expressions import *
from sjdsl.compiler.ir.game import *
from sjdsl.compiler.ir.node import *
from sjdsl.compiler.ir.statements import *
