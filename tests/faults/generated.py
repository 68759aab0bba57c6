"""Faults that need no list: small edits of expressions and statements, drawn by a seed."""

import random
import re
from collections.abc import Iterator

from definitions import Definition, Source, Token, isPython
from layer import Edit, Layer

_COMPARISONS = {"<": "<=", "<=": "<", ">": "<", ">=": "<", "==": "!=", "!=": "=="}
_C_OPERATORS = {"&&": "||", "||": "&&", "+": "-", "-": "+"}
_PYTHON_OPERATORS = {"and": "or", "or": "and", "+": "-", "-": "+"}
_NUMBER = re.compile(r"(?=.*[1-9])(\d+\.\d*|\.\d+|\d+(\.\d*)?[eE]-?\d+)f?$")
_MARGIN = re.compile(r"[A-Z_]*(MARGIN|ROUNDING|FLOOR|SLACK|TOLERANCE|EPSILON)[A-Z_]*$")
_NO_CALLS = ("if", "for", "while", "switch", "return", "sizeof", "catch", "assert", "raise")
_CALLS_WITHOUT_EFFECT = ("print", "__builtin_prefetch")  # on results


def draw(layer: Layer, count: int, seed: int) -> list[Edit]:
    """Draws functions of a layer, and an edit in each."""
    generator = random.Random(seed)
    functions = [
        (source, definition)
        for source in layer.ownSources
        for definition in source.definitions
        if definition.isFunction
    ]
    drawn: dict[tuple, Edit] = {}
    for source, function in generator.choices(functions, k=50 * count):
        if len(drawn) == count:
            break
        edits = list(_edits(source, function))
        if edits:
            begin, end, after = generator.choice(edits)
            before = " ".join(source.text[begin:end].split())
            title = f"{source.path.name}:{source.lineAt(begin)} {function.name}: {before} -> {after}".rstrip()
            drawn[source.path, begin] = Edit(title, source, begin, end, after)
    return list(drawn.values())


def _edits(source: Source, function: Definition) -> Iterator[tuple[int, int, str]]:
    """Yields begins, ends and the texts that replace them."""
    python = isPython(source.path.name)
    tokens = source.within(function.begin, function.end)
    words = [token.text for token in tokens]
    first = words.index(":" if python else "{") + 1
    for i in range(first, len(tokens) - 1):
        after = _otherOperator(source.text, tokens, i, python) or _zero(words, i)
        last = i
        if after is None and python and words[i] == "not" and words[i + 1] != "in" and words[i - 1] != "is":
            after = ""
        elif after is None and not python and words[i] == "!":
            after = ""
        elif after is None and _beginsStatement(source, tokens, i, python):
            last = _endOfCall(words, i, python, source, tokens)
            after = None if last is None else "pass" if python else ";"
        if after is not None and last is not None:
            yield tokens[i].begin, tokens[last].end, after


def _otherOperator(text: str, tokens: list[Token], i: int, python: bool) -> str | None:
    """Blanks tell operators from brackets of templates and from signs."""
    token = tokens[i]
    if text[token.begin - 1] != " " or text[token.end] not in " \n":
        return None
    return {**_COMPARISONS, **(_PYTHON_OPERATORS if python else _C_OPERATORS)}.get(token.text)


def _zero(words: list[str], i: int) -> str | None:
    return "0" if _NUMBER.match(words[i]) or (_MARGIN.match(words[i]) and words[i + 1] != "(") else None


def _beginsStatement(source: Source, tokens: list[Token], i: int, python: bool) -> bool:
    if not re.match(r"[A-Za-z_]\w*$", tokens[i].text) or tokens[i].text in _NO_CALLS + _CALLS_WITHOUT_EFFECT:
        return False
    if python:
        isFirstOfLine = "\n" in source.text[tokens[i - 1].end : tokens[i].begin]
        return isFirstOfLine and tokens[i - 1].text not in ("(", "[", "{", ",")
    return tokens[i - 1].text in (";", "{", "}")


def _endOfCall(words: list[str], i: int, python: bool, source: Source, tokens: list[Token]) -> int | None:
    """Returns the last token of the statement name.name(...), if the one that begins here is such a call."""
    while words[i + 1] in (".", "->", "::") and i + 3 < len(words):
        i += 2
    if words[i + 1] != "(":
        return None
    depth = 0
    for j in range(i + 1, len(words) - 1):
        depth += (words[j] == "(") - (words[j] == ")")
        if depth == 0 and python:
            return j if "\n" in source.text[tokens[j].end : tokens[j + 1].begin] else None
        if depth == 0:
            return j + 1 if words[j + 1] == ";" else None
    return None
