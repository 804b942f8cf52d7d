"""Every mistake an author can make, one class each, in files by the hundreds of their codes."""

from sjdsl.compiler.diagnostics.errors.maps import *
from sjdsl.compiler.diagnostics.errors.names import *
from sjdsl.compiler.diagnostics.errors.rules import *
from sjdsl.compiler.diagnostics.errors.syntax import *
from sjdsl.compiler.diagnostics.errors.values import *
