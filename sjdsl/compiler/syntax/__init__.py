"""From characters to the tree of a file: lexer, parser and builders of nodes."""
