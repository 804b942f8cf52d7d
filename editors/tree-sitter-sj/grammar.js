/**
 * @file The language `sj` for tree-sitter: what sjdsl/grammar/sj.lark reads, as a tree that editors can use while a text is being written.
 * @license Apache-2.0
 */

/// <reference types="tree-sitter-cli/dsl" />
// @ts-check

// Words that are never names. All others are words only where the grammar has them.
const RESERVED = [
  'about', 'acts', 'add', 'after', 'agents', 'all', 'always', 'and', 'as', 'blocks', 'but', 'by', 'capped', 'case', 'chance', 'checks',
  'chose', 'cite', 'conserved', 'count', 'define', 'draw', 'drop', 'each', 'end', 'episode', 'episodes', 'event', 'expect', 'extends',
  'facing', 'field', 'final', 'first', 'for', 'forbid', 'from', 'game', 'give', 'glyph', 'group', 'hide', 'in', 'is', 'kind', 'let', 'look',
  'map', 'mark', 'match', 'mean', 'metrics', 'monotone', 'move', 'moves', 'nobody', 'not', 'observe', 'of', 'on', 'once', 'or', 'otherwise',
  'over', 'param', 'phase', 'pick', 'remove', 'require', 'schedule', 'seek', 'send', 'set', 'shape', 'show', 'size', 'sj', 'sum',
  'symmetric', 'tally', 'timer', 'to', 'variant', 'when', 'where', 'window', 'with',
];

// From the loosest to the tightest.
const LEVEL = { or: 1, and: 2, not: 3, compare: 4, add: 5, multiply: 6, sign: 7 };

/** One or more, with commas between them. @param {RuleOrLiteral} rule */
const list = (rule) => seq(rule, repeat(seq(',', rule)));

/** A block in braces. @param {RuleOrLiteral} content */
const braces = (content) => seq('{', content, '}');

module.exports = grammar({
  name: 'sj',

  word: ($) => $.identifier,
  extras: ($) => [/[ \t\f\r\n]/, $.comment],
  reserved: { global: () => RESERVED },
  supertypes: ($) => [$.declaration, $.statement, $.expression, $.arithmetic, $.type, $.check, $.metric, $.observable, $.policy_rule],

  rules: {
    // A whole file, or declarations alone, as manuals and other pages quote them.
    source_file: ($) => seq(optional($.version), optional(choice($.game, repeat1($.declaration)))),
    version: ($) => seq('sj', field('number', choice($.integer, $.decimal))),
    game: ($) => seq('game', field('name', $.identifier), optional($._title), optional($.extends), field('body', $.declarations)),
    _title: ($) => field('title', $.string),
    extends: ($) => seq('extends', field('file', $.string)),
    declarations: ($) => braces(repeat($.declaration)),

    declaration: ($) => choice(
      $.cite, $.about, $.size, $.param, $.episode, $.kind, $.group, $.field, $.timer, $.map, $.agents, $.movers, $.shape, $.define, $.schedule,
      $.phase, $.observe, $.look, $.metrics, $.checks, $.policy, $.scenario, $.variant, $.override, $.drop,
    ),
    cite: ($) => seq('cite', field('source', $.string)),
    about: ($) => seq('about', field('name', $.identifier), repeat1(field('text', $.string))),
    variant: ($) => seq('variant', field('name', $.identifier), optional($._title), field('body', $.declarations)),
    override: ($) => seq('set', field('target', $.path), '=', field('value', $._value)),
    drop: ($) => seq('drop', field('name', $.identifier)),

    // ---- numbers

    size: ($) => seq('size', $._constant),
    param: ($) => seq('param', $._constant),
    _constant: ($) => seq(
      field('name', $.identifier), optional($.by), ':', field('unit', $.unit), '=', field('value', $._value), optional($.limits),
    ),
    limits: ($) => seq('in', $._bounds),
    _bounds: ($) => seq(field('low', $.arithmetic), '..', field('high', $.arithmetic)),
    unit: ($) => choice($.identifier, 'count'),
    _value: ($) => choice($.arithmetic, $.table),
    table: ($) => braces(list($.entry)),
    entry: ($) => seq($._key, ':', field('value', $._value)),
    episode: ($) => seq('episode', field('steps', $.expression)),

    // ---- world

    kind: ($) => seq(
      'kind', field('name', $.identifier), field('glyph', $.string), optional(braces(repeat(choice($.field, $.timer, $.blocks, $.glyph)))),
    ),
    glyph: ($) => seq('glyph', field('glyph', $.string), repeat1(seq('with', field('field', $.identifier), '=', field('value', $.expression)))),
    blocks: ($) => seq('blocks', list(field('blocked', $.blocked)), optional($._when)),
    blocked: ($) => choice($.identifier, 'agents'),
    field: ($) => seq('field', field('name', $.identifier), optional($.by), ':', field('type', $.type), optional(seq('=', field('value', $.expression)))),
    by: ($) => seq('by', choice($.words, $.range_of_numbers, field('name', $.identifier))),
    range_of_numbers: ($) => $._bounds,
    timer: ($) => seq('timer', field('name', $.identifier)),
    type: ($) => choice($.words, $.range, $.agent_type, $.cell_type),
    range: ($) => seq($._bounds, optional('capped')),
    agent_type: ($) => seq(optional(seq('set', 'of')), field('name', $.identifier)),
    cell_type: ($) => seq(field('member', $.identifier), 'of', field('kind', $.identifier)),
    words: ($) => braces(list($.identifier)),
    group: ($) => seq('group', field('name', $.identifier), '=', list(field('kind', $.identifier))),
    map: ($) => seq('map', optional('wraps'), choice(field('file', $.string), $.rows)),
    rows: ($) => braces(repeat1($.string)),
    agents: ($) => seq(
      'agents', optional(field('number', $.expression)), braces(repeat(choice($.acts, $.moves, $.field, $.timer, $.forbid, $.blocks))),
    ),
    acts: ($) => seq('acts', list($.action)),
    action: ($) => seq(field('name', $.identifier), optional(seq('(', list($.argument), ')'))),
    argument: ($) => seq(optional(seq(field('name', $.identifier), ':')), field('type', $.type)),
    moves: ($) => seq('moves', field('name', $.identifier)),
    forbid: ($) => seq('forbid', choice($.all, list($._chosen)), $._when),
    _chosen: ($) => field('action', choice($.identifier, $.call)),
    all: () => 'all',
    movers: ($) => seq(
      'movers', field('name', $.identifier), field('number', $.expression), field('glyph', $.string),
      optional(braces(repeat(choice($.field, $.timer)))),
    ),
    shape: ($) => seq('shape', field('name', $.identifier), choice($.rows, seq('=', field('value', $.call)))),
    define: ($) => seq('define', field('name', $.identifier), optional($.parameters), '=', field('value', $.expression)),
    parameters: ($) => seq('(', list($.identifier), ')'),

    // ---- time

    schedule: ($) => seq('schedule', $.turn, repeat(seq('->', $.turn))),
    turn: ($) => seq(field('phase', $.identifier), optional(seq('(', list($.expression), ')'))),
    phase: ($) => seq('phase', field('name', $.identifier), optional($.parameters), $._body),
    _body: ($) => field('body', $.block),
    block: ($) => braces(repeat($.statement)),

    statement: ($) => choice(
      $.let, $.draw, $.each, $.pick, $.first, $.match, $.when, $.chance, $.set, $.add, $.give, $.tally, $.send, $.shift, $.remove, $.move,
      $.mark, $.end,
    ),
    let: ($) => seq('let', field('name', $.identifier), '=', field('value', $.expression)),
    draw: ($) => seq('draw', field('name', $.identifier), 'from', choice($.range_of_numbers, $.words, $.table)),
    each: ($) => seq('each', $.domain, $._body),
    pick: ($) => seq('pick', field('number', $.arithmetic), $.domain, $._body, optional($.otherwise)),
    first: ($) => seq('first', $.domain, $._body, optional($.otherwise)),
    match: ($) => seq('match', $.domain, 'with', optional('first'), $.domain, $._body),
    when: ($) => seq('when', field('condition', $.expression), $._body, optional($.otherwise)),
    chance: ($) => seq('chance', field('probability', $.expression), $._body, optional($.otherwise)),
    otherwise: ($) => seq('otherwise', choice($._body, $.when, $.chance)),
    set: ($) => seq('set', field('target', $.path), '=', field('value', $.expression), optional($.by_lot)),
    by_lot: ($) => seq('by', $.identifier),
    add: ($) => seq('add', field('value', $.expression), 'to', field('target', $.path)),
    give: ($) => seq('give', field('value', $.expression), 'to', field('receiver', choice($.path, $.all, $.all_but))),
    all_but: ($) => seq('all', 'but', $.identifier),
    tally: ($) => seq(
      'tally', field('event', $.path), optional(seq('by', field('amount', $.expression))), optional(seq('for', field('gainer', $.path))),
    ),
    send: ($) => seq(
      'send', field('target', $.path), 'to', choice($.domain, $.held_cell),
      optional(seq('after', field('delay', $.expression))), optional($.facing), optional($.stay),
    ),
    held_cell: ($) => seq(field('name', $.identifier), $._members),
    shift: ($) => seq(
      'send', field('target', $.path), 'by', field('number', $.arithmetic), $._direction, optional($.facing), optional($.stay),
    ),
    _direction: ($) => choice(field('direction', $.path), seq('away', 'from', field('from', $.path)), seq('toward', field('toward', $.path))),
    facing: ($) => seq('facing', field('heading', $.identifier)),
    stay: ($) => seq('otherwise', $.identifier),
    remove: ($) => seq('remove', field('target', $.path)),
    move: ($) => seq('move', 'each', $.domain, optional(field('course', choice($.nearer, $.farther, $.at_random, $.ahead, $.along)))),
    nearer: ($) => seq('toward', $.domain, optional($.avoiding)),
    farther: ($) => seq('away', 'from', $.domain, optional($.avoiding)),
    at_random: ($) => seq('at', 'random', optional($.avoiding)),
    ahead: () => 'ahead',
    along: ($) => seq('along', field('heading', $.expression)),
    mark: ($) => seq('mark', $._near),
    end: () => 'end',

    // ---- who

    domain: ($) => seq(field('kind', $.identifier), optional($.bind), optional($.on), optional($.inside), optional($.where)),
    bind: ($) => seq('as', field('name', $.identifier)),
    on: ($) => seq('on', field('kind', $.identifier), optional($.bind)),
    inside: ($) => seq('in', choice($._near, $.path, $.words)),
    _near: ($) => seq($._shape, 'of', field('of', $.identifier)),
    _shape: ($) => field('shape', choice($.identifier, $.call)),
    where: ($) => seq('where', field('condition', $.expression)),
    _when: ($) => seq('when', field('condition', $.expression)),

    // ---- what is seen, measured, checked

    observe: ($) => seq('observe', braces(repeat($.observable))),
    observable: ($) => choice($.window, $.show, $.hide),
    window: ($) => seq('window', list(seq(field('side', $.identifier), field('cells', $.expression))), optional($._when)),
    show: ($) => seq('show', field('shown', $.path), optional(seq('as', braces(list($.relabel)))), optional($._when)),
    relabel: ($) => seq(field('name', $.identifier), optional($.where)),
    hide: ($) => seq('hide', field('hidden', $.path), optional(seq('on', field('on', $.blocked))), optional($._when)),
    look: ($) => seq('look', field('kind', $.identifier), optional($.where), choice($.paint, $.badge, seq($.paint, $.badge))),
    paint: ($) => seq('as', repeat1(choice($.identifier, $.string))),
    badge: ($) => seq('with', repeat1(choice($.identifier, $.string))),
    metrics: ($) => seq('metrics', braces(repeat($.metric))),
    metric: ($) => choice($.event, $.mean, $.final),
    event: ($) => seq('event', field('name', $.identifier), optional($.by)),
    mean: ($) => seq('mean', field('name', $.identifier), '=', field('value', $.expression)),
    final: ($) => seq('final', field('name', $.identifier), '=', field('value', $.expression)),
    checks: ($) => seq('checks', optional(field('name', $.identifier)), braces(repeat($.check))),
    check: ($) => choice($.require, $.always, $.once, $.conserved, $.monotone, $.symmetric, $.expect),
    require: ($) => seq('require', field('condition', $.expression)),
    always: ($) => seq('always', field('condition', $.expression)),
    once: ($) => seq('once', field('begin', $.expression), 'always', field('condition', $.expression)),
    conserved: ($) => seq('conserved', field('value', $.expression)),
    monotone: ($) => seq('monotone', field('value', $.identifier), field('direction', $.identifier), 'in', field('argument', $.identifier)),
    symmetric: ($) => seq('symmetric', choice($.identifier, 'agents')),
    expect: ($) => seq(
      'expect', field('condition', $.expression), 'with', list(choice($.player, $.seek)), 'over', field('number', $.integer), 'episodes',
    ),
    player: ($) => seq(field('policy', $.identifier), optional($.parameters)),

    // ---- who plays

    policy: ($) => seq('policy', field('name', $.identifier), optional($._title), braces(repeat($.policy_rule))),
    policy_rule: ($) => choice($.act, $.seek, $.aim),
    act: ($) => seq($._when, 'choose', $._chosen),
    seek: ($) => seq('seek', $.domain, optional($.avoiding)),
    aim: ($) => seq('aim', $._shape, 'at', $.domain, optional($.avoiding), 'choose', $._chosen),
    avoiding: ($) => seq('avoiding', $.domain),
    scenario: ($) => seq('scenario', field('name', $.identifier), optional($._title), braces(repeat($.slots))),
    slots: ($) => seq('slots', field('number', $.expression), choice('focal', seq('policy', field('policy', $.identifier)))),

    // ---- expressions

    expression: ($) => choice(
      $.logical_expression, $.not_expression, $.comparison, $.is_expression, $.chose_expression, $.in_expression, $.on_expression, $.arithmetic,
    ),
    logical_expression: ($) => choice(
      prec.left(LEVEL.or, seq(field('left', $.expression), field('operator', 'or'), field('right', $.expression))),
      prec.left(LEVEL.and, seq(field('left', $.expression), field('operator', 'and'), field('right', $.expression))),
    ),
    not_expression: ($) => prec(LEVEL.not, seq('not', field('value', $.expression))),
    comparison: ($) => prec(LEVEL.compare, seq(
      field('left', $.arithmetic), field('operator', choice('<=', '>=', '==', '!=', '<', '>')), field('right', $.arithmetic),
    )),
    is_expression: ($) => prec(LEVEL.compare, seq(field('left', $.arithmetic), 'is', optional(field('negation', 'not')), field('right', $.arithmetic))),
    chose_expression: ($) => prec(LEVEL.compare, seq(field('left', $.arithmetic), 'chose', $._chosen)),
    in_expression: ($) => prec(LEVEL.compare, seq(
      field('left', $.arithmetic), 'in', choice(field('right', $.arithmetic), $.range_of_numbers, $.words),
    )),
    on_expression: ($) => prec(LEVEL.compare, seq(field('left', $.arithmetic), 'on', field('kind', $.identifier))),

    arithmetic: ($) => choice(
      $.binary_expression, $.unary_expression, $.parenthesized_expression, $.integer, $.decimal, $.count, $.some, $.every, $.sum, $.extreme, $.case, $.call, $.path,
      $.nobody,
    ),
    binary_expression: ($) => choice(
      prec.left(LEVEL.add, seq(field('left', $.arithmetic), field('operator', choice('+', '-')), field('right', $.arithmetic))),
      prec.left(LEVEL.multiply, seq(field('left', $.arithmetic), field('operator', choice('*', '/', '%')), field('right', $.arithmetic))),
    ),
    unary_expression: ($) => prec(LEVEL.sign, seq(field('operator', choice('+', '-')), field('value', $.arithmetic))),
    parenthesized_expression: ($) => seq('(', $.expression, ')'),
    nobody: () => 'nobody',
    count: ($) => seq('count', '(', $.domain, ')'),
    some: ($) => seq('any', '(', $.domain, ')'),
    every: ($) => seq('all', '(', $.domain, ')'),
    sum: ($) => seq('sum', '(', field('value', $.expression), optional(seq('over', $.domain)), ')'),
    extreme: ($) => seq(
      field('function', $.identifier), '(', field('value', $.expression), 'over', $.domain,
      optional(seq('otherwise', field('otherwise', $.expression))), ')',
    ),
    case: ($) => seq('case', field('value', $.expression), braces(list($.arm))),
    arm: ($) => seq($._key, ':', field('value', $.expression)),
    _key: ($) => field('key', choice($.integer, $.integer_range, $.identifier, 'otherwise')),
    integer_range: ($) => seq($.integer, '..', optional($.integer)),
    call: ($) => seq(field('function', $.identifier), '(', optional(list($.expression)), ')'),
    path: ($) => seq(field('name', $.identifier), optional($._members)),
    _members: ($) => repeat1(choice($.member, $.index)),
    member: ($) => seq('.', field('name', $.identifier)),
    index: ($) => seq('[', $.expression, ']'),

    // ---- words and signs

    identifier: () => /[a-z][a-z0-9_]*/,
    integer: () => /[0-9]+/,
    decimal: () => /[0-9]+\.[0-9]+/,
    string: ($) => seq('"', repeat(choice($.string_content, $.escape_sequence)), token.immediate('"')),
    string_content: () => token.immediate(prec(1, /[^"\\\n]+/)),
    escape_sequence: () => token.immediate(prec(1, /\\./)),
    comment: () => token(/#[^\n]*/),
  },
});
