; Names that hold inside one declaration or block, and where they are used.

[(phase) (block) (define) (each) (pick) (first) (match) (count) (some) (every) (sum) (extreme) (seek) (aim) (move) (send) (relabel) (look)] @local.scope

(parameters (identifier) @local.definition)
(let name: (identifier) @local.definition)
(draw name: (identifier) @local.definition)
(bind name: (identifier) @local.definition)

(path name: (identifier) @local.reference)
(held_cell name: (identifier) @local.reference)
(all_but (identifier) @local.reference)
(_ of: (identifier) @local.reference)
