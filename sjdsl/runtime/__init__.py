"""The runtime: kernels that generated code calls, and the environment interface.

It imports no other package of sjdsl: a generated module and this package are all that playing
needs. The compiler uses the parts without JAX: `actions`, `geometry` (it computes the same tables),
`planes` and `fields` (it writes such descriptions).
"""
