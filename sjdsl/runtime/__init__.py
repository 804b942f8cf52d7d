"""The runtime: kernels that generated code calls, and the environment interface; it imports no compiler.

Nothing here imports another package of sjdsl: a generated module and this package are all that playing needs. The compiler stands
above and uses what needs no JAX: `actions`, `geometry` (it computes the same tables), `planes` and `fields` (it writes such descriptions).
"""
