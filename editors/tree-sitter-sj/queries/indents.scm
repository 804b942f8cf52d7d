; Neovim: what stands in braces is further in than the line that opens them.

[
  (declarations) (block) (rows) (words) (table) (case)
  (kind) (agents) (movers) (observe) (show) (metrics) (checks) (policy) (scenario)
] @indent.begin
"}" @indent.branch @indent.end
