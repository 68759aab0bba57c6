"""A filter for doxygen: writes the public part of a header, with comments in doxygen's form.

python publicheader.py HEADER

Comments of C headers are plain; those of C++ headers are doxygen's already.
"""

import re
import sys
from pathlib import Path

_SECTION = re.compile(r"/\* ---- (.*?) ---- \*/\n")
_TRAILING = re.compile(r"^(.*[^\s/].*?)[ \t]*/\*(?!\*) ", re.MULTILINE)
_LEADING = re.compile(r"^( *)/\*(?!\*) ", re.MULTILINE)
_FORMAT = re.compile(r"^/\* clang-format \w+ \*/\n", re.MULTILINE)
_FILE = re.compile(r"\A/\* (\S+): (.*?)\*/\n", re.DOTALL)
_PARAGRAPH = re.compile(r"(^ \*\n \* )((?:\w+ ?){1,4}\.) ", re.MULTILINE)
# Sphinx would list the type and its alias as two declarations.
_TYPEDEF = re.compile(r"^typedef (struct|enum) (\w+) \{(.*?)^\} \2;", re.MULTILINE | re.DOTALL)
# Doxygen lists macros first, and would move their section to the front.
_MACRO = re.compile(r"^/\*(?:(?!\*/).)*\*/\n#define .*\n\n?", re.MULTILINE | re.DOTALL)
# A comment can belong to several declarations.
_FOLLOWING = re.compile(r"(?<=;\n)(?=[a-z]\w* [^\n]*\()", re.MULTILINE)
# Doxygen would link this to a page of the file.
_HEADER_NAME = re.compile(r'(?<!["\w])chaintree\.h')
_NOT_PUBLIC = re.compile(r"^(?:protected|private):\n.*?^\};", re.MULTILINE | re.DOTALL)


def ofC(text):
    """Return a C header with sections as named groups, and comments behind members as their texts."""
    text = _FILE.sub(_fileComment, _FORMAT.sub("", text))
    text = _TYPEDEF.sub(r"\1 \2 {\3};", text)
    first, *sections = _SECTION.split(text)
    macros = "".join(match[0] for section in sections[1::2] for match in _MACRO.finditer(section))
    parts = [_comments(first + macros)]
    for name, section in zip(sections[::2], sections[1::2], strict=True):
        declarations, guard, rest = _MACRO.sub("", section).partition("#ifdef __cplusplus\n}")
        declarations = _comments(declarations)
        parts.append(f"/** @name {name}\n * @{{ */\n{declarations}/** @}} */\n{guard}{rest}")
    return "".join(parts)


def ofCpp(text):
    """Return a C++ header without its protected and private members."""
    return _NOT_PUBLIC.sub("};", text)


def _fileComment(match):
    """Return the comment at the top of a header in doxygen's form, with the first words of paragraphs in bold."""
    name, text = match.groups()
    text = _PARAGRAPH.sub(r"\1**\2** ", re.sub(r'"([^"]*)"', "“\\1”", text))  # doxygen splits paragraphs at quotes
    return f"/** @file {name}\n * {text[0].upper()}{text[1:]}*/\n"


def _comments(text):
    text = _LEADING.sub(r"\1/** ", _TRAILING.sub(r"\1 /**< ", text))
    text = _FOLLOWING.sub("/** See above. */\n", text)
    return _HEADER_NAME.sub("%chaintree.h", text)


if __name__ == "__main__":
    header = Path(sys.argv[1]).read_text(encoding="utf-8")
    sys.stdout.write(ofCpp(header) if "\nclass " in header else ofC(header))
