"""From text to a tree: lexer, parser, nodes; operator precedence is in `sj.lark`."""
