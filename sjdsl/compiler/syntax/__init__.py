"""From characters to the tree of a file: lexer, parser, precedence, and the builders of nodes."""
