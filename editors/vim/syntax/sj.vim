" Syntax file of the language sj for Vim and Neovim; written by editors/generate.py.
" Of several matches at one place Vim takes the one that is defined last.
if exists("b:current_syntax")
  finish
endif
syntax case match
syntax match sjKeywordOperator '->\|\.\.\|<=\|>=\|==\|!=\|[-+*/%<>=]'
syntax match sjKeywordOperatorWord '\<\(after\|ahead\|aim\|all\|along\|and\|any\|as\|at\|avoiding\|away\|but\|by\|capped\|choose\|chose\|count\|different\|episodes\|facing\|focal\|for\|from\|in\|is\|keep\|not\|of\|on\|or\|out\|over\|random\|seed\|seek\|slots\|sum\|to\|toward\|trials\|with\|wraps\)\>'
syntax match sjKeywordOtherStatement '\<\(add\|draw\|end\|give\|let\|mark\|move\|remove\|send\|set\|tally\)\>'
syntax match sjStorageType '\<\(about\|acts\|agents\|always\|blocks\|checks\|cite\|conserved\|define\|drop\|episode\|event\|expect\|extends\|field\|final\|forbid\|game\|glyph\|group\|hide\|hold\|kind\|look\|map\|mean\|metrics\|monotone\|movers\|moves\|observe\|once\|param\|phase\|policy\|require\|scenario\|schedule\|shape\|show\|size\|sj\|symmetric\|task\|timer\|train\|variant\|where\|window\)\>'
syntax match sjKeywordControl '\<\(case\|chance\|each\|first\|match\|otherwise\|pick\|when\)\>'
syntax match sjSupportFunction '\<\(abs\|before\|chicken\|count\|distance\|exp\|highest\|log\|lowest\|max\|min\|mix\|prisoners_dilemma\|quotient\|ramp\|round\|shift\|sqrt\|stag_hunt\|steps_ahead\|steps_right\|sum\)\ze\s*('
syntax match sjVariableLanguage '\<\(agent\|step\)\>'
syntax match sjConstantLanguage '\<\(east\|no\|nobody\|north\|nowhere\|same\|south\|west\|yes\)\>'
syntax match sjPunctuationSeparator '\(:\)\ze\(\s*\)\(cells\|count\|fraction\|number\|probability\|reward\|steps\|word\)\>' nextgroup=sjSupportType skipwhite
syntax match sjSupportType '\(cells\|count\|fraction\|number\|probability\|reward\|steps\|word\)\>' contained
syntax match sjPunctuationAccessor '\(\.\)\ze\(\s*\)\([a-z][a-z0-9_]*\)' nextgroup=sjVariableOtherProperty skipwhite
syntax match sjVariableOtherProperty '\([a-z][a-z0-9_]*\)' contained
syntax match sjKeywordOperatorWord '\<\(as\|let\|draw\)\ze\(\s\+\)\([a-z][a-z0-9_]*\)' nextgroup=sjVariableOtherLocal skipwhite
syntax match sjVariableOtherLocal '\([a-z][a-z0-9_]*\)' contained
syntax match sjStorageType '\<\(field\|timer\)\ze\(\s\+\)\([a-z][a-z0-9_]*\)' nextgroup=sjVariableOtherProperty skipwhite
syntax match sjVariableOtherProperty '\([a-z][a-z0-9_]*\)' contained
syntax match sjStorageType '\<\(define\|event\|final\|game\|group\|kind\|mean\|movers\|param\|phase\|policy\|scenario\|shape\|size\|task\|variant\)\ze\(\s\+\)\([a-z][a-z0-9_]*\)' nextgroup=sjEntityNameType skipwhite
syntax match sjEntityNameType '\([a-z][a-z0-9_]*\)' contained
syntax match sjConstantNumeric '\<[0-9]\+\(\.[0-9]\+\)\?\>'
syntax match sjConstantCharacterEscape '\\.' contained
syntax region sjStringQuotedDouble start='"' end='"\|$' contains=sjConstantCharacterEscape
syntax match sjCommentLineNumberSign '#.*$'
highlight default link sjCommentLineNumberSign Comment
highlight default link sjStringQuotedDouble String
highlight default link sjConstantCharacterEscape SpecialChar
highlight default link sjConstantNumeric Number
highlight default link sjConstantLanguage Constant
highlight default link sjStorageType Structure
highlight default link sjEntityNameType Type
highlight default link sjVariableOtherProperty Identifier
highlight default link sjVariableOtherLocal Identifier
highlight default link sjVariableLanguage Special
highlight default link sjSupportType Type
highlight default link sjSupportFunction Function
highlight default link sjKeywordControl Conditional
highlight default link sjKeywordOtherStatement Statement
highlight default link sjKeywordOperatorWord Keyword
highlight default link sjKeywordOperator Operator
highlight default link sjPunctuationAccessor Delimiter
highlight default link sjPunctuationSeparator Delimiter
let b:current_syntax = "sj"
