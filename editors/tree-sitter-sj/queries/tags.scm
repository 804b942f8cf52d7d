; Declarations of a game, for lists of symbols and for jumps.

(game name: (identifier) @name) @definition.module
(kind name: (identifier) @name) @definition.class
(group name: (identifier) @name) @definition.class
(movers name: (identifier) @name) @definition.class
(shape name: (identifier) @name) @definition.class
(size name: (identifier) @name) @definition.constant
(param name: (identifier) @name) @definition.constant
(field name: (identifier) @name) @definition.field
(timer name: (identifier) @name) @definition.field
(define name: (identifier) @name) @definition.function
(phase name: (identifier) @name) @definition.function
(policy name: (identifier) @name) @definition.function
(scenario name: (identifier) @name) @definition.module
(variant name: (identifier) @name) @definition.module

(turn phase: (identifier) @name) @reference.call
(call function: (identifier) @name) @reference.call
(slots policy: (identifier) @name) @reference.call
(player policy: (identifier) @name) @reference.call
