; What can be folded: what stands in braces.

[
  (declarations) (block) (rows) (words) (table) (case)
  (kind) (agents) (movers) (observe) (metrics) (checks) (policy) (scenario)
] @fold
