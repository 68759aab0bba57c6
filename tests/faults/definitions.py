"""Finds functions, types, tables and macros of C, C++ and Python by name, and sequences of tokens within them.

A tokenizer by regular expressions and matched brackets suffice, since clang-format and ruff keep the sources uniform.
"""

import ast
import bisect
import functools
import pathlib
import re
from dataclasses import dataclass

_C_TOKEN = re.compile(
    r"""(?P<blank>\s+|\\\n|/\*.*?\*/|//[^\n]*)
      | (?:u8|[uUL])?R"(?P<raw>[^\s()\\]*)\(.*?\)(?P=raw)"
      | (?:u8|[uUL])?"(?:\\.|[^"\\\n])*" | [uUL]?'(?:\\.|[^'\\\n])+'
      | \.?\d(?:[eEpP][+-]|[\w.'])* | [A-Za-z_]\w*
      | <<=|>>=|->\*|\.\.\.|::|->|\+\+|--|&&|\|\||\#\#|[-+*/%&|^!=<>]=|<<|>>|.""",
    re.DOTALL | re.VERBOSE,
)
_PYTHON_TOKEN = re.compile(
    r"""(?P<blank>\s+|\\\n|\#[^\n]*)
      | [rbfuRBFU]{0,2}(?:\"{3}.*?\"{3}|'{3}.*?'{3}|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
      | \.?\d(?:[eE][+-]|[\w.])* | [^\W\d]\w*
      | \*\*=|//=|>>=|<<=|\.\.\.|:=|->|\*\*|//|<<|>>|[-+*/%&|^!=<>@]=|.""",
    re.DOTALL | re.VERBOSE,
)
_PAIRS = {"(": ")", "[": "]", "{": "}"}


@dataclass(frozen=True)
class Token:
    text: str
    begin: int
    end: int


@dataclass(frozen=True)
class Definition:
    name: str  # with those of the types around it, Type::function; without namespaces
    begin: int  # characters of the file
    end: int
    isFunction: bool


def isPython(name: str) -> bool:
    return name.endswith(".py")


def tokensOf(text: str, python: bool) -> list[Token]:
    """Returns all tokens but comments and white space."""
    found = (_PYTHON_TOKEN if python else _C_TOKEN).finditer(text)
    return [Token(match[0], *match.span()) for match in found if match["blank"] is None]


class Source:
    """A file, its tokens and its definitions."""

    def __init__(self, path: pathlib.Path):
        self.path = path
        self.text = path.read_text()
        self.tokens = tokensOf(self.text, isPython(path.name))
        self._texts = [token.text for token in self.tokens]
        self._begins = [token.begin for token in self.tokens]

    @functools.cached_property
    def definitions(self) -> list[Definition]:
        return _definitionsOfPython(self.text) if isPython(self.path.name) else _definitionsOfC(self.text, self.tokens)

    def lineAt(self, position: int) -> int:
        return self.text.count("\n", 0, position) + 1

    def within(self, begin: int, end: int) -> list[Token]:
        return self.tokens[bisect.bisect_left(self._begins, begin) : bisect.bisect_left(self._begins, end)]

    def find(self, wanted: list[str], begin: int, end: int) -> list[tuple[int, int]]:
        """Returns begins and ends of the places in this range that have these tokens."""
        first, last = bisect.bisect_left(self._begins, begin), bisect.bisect_left(self._begins, end)
        return [
            (self.tokens[i].begin, self.tokens[i + len(wanted) - 1].end)
            for i in range(first, last - len(wanted) + 1)
            if self._texts[i] == wanted[0] and self._texts[i : i + len(wanted)] == wanted
        ]


# ---- Python ----


def _definitionsOfPython(text: str) -> list[Definition]:
    lines = [0]
    for line in text.split("\n"):
        lines.append(lines[-1] + len(line) + 1)
    found = []

    def visit(node: ast.AST, prefix: str) -> None:
        for child in ast.iter_child_nodes(node):
            isFunction = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef)
            if isFunction or isinstance(child, ast.ClassDef):
                name = prefix + child.name
                first = min([child.lineno, *(decorator.lineno for decorator in child.decorator_list)])
                found.append(Definition(name, lines[first - 1], lines[child.end_lineno], isFunction))
                visit(child, name + ".")
            elif isinstance(child, ast.Assign | ast.AnnAssign) and not prefix:
                target = child.targets[0] if isinstance(child, ast.Assign) else child.target
                found.append(Definition(ast.unparse(target), lines[child.lineno - 1], lines[child.end_lineno], False))

    visit(ast.parse(text), "")
    return found


# ---- C and C++ ----


def _definitionsOfC(text: str, tokens: list[Token]) -> list[Definition]:
    code, macros = _withoutDirectives(text, tokens)
    return [*macros, *_Reader(code).definitions]


def _withoutDirectives(text: str, tokens: list[Token]) -> tuple[list[Token], list[Definition]]:
    """Returns the tokens that are no part of directives, and the macros."""
    code, macros = [], []
    end = -1
    for i, token in enumerate(tokens):
        if token.begin < end:
            continue
        if token.text != "#" or text[text.rfind("\n", 0, token.begin) + 1 : token.begin].strip():
            code.append(token)
            continue
        end = re.compile(r"(?:[^\\\n]|\\.)*", re.DOTALL).match(text, token.begin).end()
        if tokens[i + 1].text == "define":
            macros.append(Definition(tokens[i + 2].text, token.begin, end, False))
    return code, macros


class _Reader:
    """Reads declarations outside of functions."""

    def __init__(self, code: list[Token]):
        self.code = code
        self.closing: dict[int, int] = {}
        opened: list[int] = []
        for i, token in enumerate(code):
            if token.text in _PAIRS:
                opened.append(i)
            elif token.text in _PAIRS.values():
                while opened and _PAIRS[code[opened[-1]].text] != token.text:
                    opened.pop()  # #if and #else have one bracket each
                if opened:
                    self.closing[opened.pop()] = i
        self.definitions: list[Definition] = []
        self._read(0, len(code), "")

    def _read(self, i: int, end: int, prefix: str) -> None:
        while i < end:
            i = self._declaration(i, end, prefix)

    def _add(self, begin: int, last: int, name: str, isFunction: bool) -> None:
        if name:
            self.definitions.append(Definition(name, self.code[begin].begin, self.code[last].end, isFunction))

    def _declaration(self, begin: int, end: int, prefix: str) -> int:
        """Reads one, and returns what follows."""
        i = begin
        name = ""
        isAnonymous = False
        while i < end:
            text = self.code[i].text
            if text == ";":
                if not isAnonymous:
                    self._add(begin, i, name or prefix + self._name(begin, i), False)
                return i + 1
            if text == ":" and self.code[i - 1].text in ("public", "private", "protected"):
                return i + 1
            if text == "{":
                close = self.closing.get(i, end - 1)
                header = [token.text for token in self.code[begin:i]]
                if header[:1] in (["namespace"], ["extern"]) and "(" not in header and "=" not in header:
                    self._read(i + 1, close, prefix)
                    return close + 1
                if _isType(header):
                    name = _typeName(header) or self._name(close, end)
                    isAnonymous = not name
                    name = prefix + name if name else ""
                    if "enum" in header:
                        self._readEnumerators(i + 1, close, prefix)
                    else:
                        self._read(i + 1, close, name + "::" if name else prefix)
                elif _isFunction(header):
                    self._add(begin, close, prefix + self._name(begin, i), True)
                    return close + 1
                i = close
            elif text in _PAIRS:
                i = self.closing.get(i, i)
            i += 1
        return end

    def _readEnumerators(self, begin: int, end: int, prefix: str) -> None:
        for i in range(begin, end):
            if i == begin or self.code[i - 1].text == ",":
                last = next((j for j in range(i, end) if self.code[j].text == ","), end - 1)
                self._add(i, last, prefix + self.code[i].text, False)

    def _name(self, begin: int, end: int) -> str:
        """Returns the name that a declaration declares."""
        angles = 0
        i = begin
        while i < end:
            text = self.code[i].text
            if text == "operator":
                last = next((j for j in range(i + 2, end) if self.code[j].text == "("), end)
                isOfType = i > begin and self.code[i - 1].text == "::"
                type = self._qualified(begin, i) if isOfType else ""
                return type + "".join(token.text for token in self.code[i:last])
            if text == "<" and i > begin:
                angles += 1
            elif text in (">", ">>") and angles > 0:
                angles -= len(text)
            elif angles > 0:
                i = self.closing.get(i, i)
            elif text == "(":
                after = self.closing.get(i, end) + 1
                if self.code[i - 1].text in ("__attribute__", "alignas", "__declspec"):
                    i = after - 1
                elif after < end and self.code[after].text == "(":
                    return "".join(token.text for token in self.code[i + 1 : after - 1])  # MACRO(name)(...)
                else:
                    break
            elif text in ("=", "{", "[", ";"):
                break
            i += 1
        return self._qualified(begin, i)

    def _qualified(self, begin: int, end: int) -> str:
        i = end
        while i > begin and re.match(r"(::|~|\w+)$", self.code[i - 1].text):
            if i < end and self.code[i - 1].text not in ("::", "~") and self.code[i].text not in ("::", "~"):
                break
            i -= 1
        return "".join(token.text for token in self.code[i:end])


def _isType(header: list[str]) -> bool:
    isNamed = any(word in header for word in ("class", "struct", "union", "enum"))
    return isNamed and "=" not in header and "(" not in _withoutBrackets(header)


def _withoutBrackets(header: list[str]) -> list[str]:
    """Returns a header without template <...>, alignas(...) and __attribute__((...))."""
    text = " ".join(header)
    text = re.sub(r"\b(alignas|__attribute__) \( (\( )?[^()]*(\([^()]*\)[^()]*)*\)( \))?", "", text)
    return re.sub(r"\btemplate <[^<>]*>", "", text).split()


def _typeName(header: list[str]) -> str:
    words = _withoutBrackets(header)
    words = words[: words.index(":")] if ":" in words else words
    names = [word for word in words if re.match(r"[A-Za-z_]\w*$", word) and word != "final"]
    return "" if names[-1] in ("class", "struct", "union", "enum") else names[-1]


def _isFunction(header: list[str]) -> bool:
    if "(" not in header:
        return False
    beforeParameters = header[: header.index("(")]
    if "=" in beforeParameters and "operator" not in beforeParameters:
        return False
    # In a list of initializers a member may have braces: ": a{1}, b{2} {".
    return not (":" in header and re.match(r"[A-Za-z_]\w*$", header[-1]) and header[-1] not in ("const", "override"))
