"""A filter for doxygen: write what is public of a header, with comments that doxygen reads.

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
# Sphinx would have the type and its other name as two declarations.
_TYPEDEF = re.compile(r"^typedef (struct|enum) (\w+) \{(.*?)^\} \2;", re.MULTILINE | re.DOTALL)
# Doxygen takes macros first, and then would take their section before the others.
_MACRO = re.compile(r"^/\*(?:(?!\*/).)*\*/\n#define .*\n\n?", re.MULTILINE | re.DOTALL)
# One comment may stand above several declarations.
_FOLLOWING = re.compile(r"(?<=;\n)(?=[a-z]\w* [^\n]*\()", re.MULTILINE)
# Doxygen would link it to a page of the file.
_HEADER_NAME = re.compile(r'(?<!["\w])chaintree\.h')
_NOT_PUBLIC = re.compile(r"^(?:protected|private):\n.*?^\};", re.MULTILINE | re.DOTALL)


def ofC(text):
    """Return a C header: sections as groups with a name, and what stands behind a member as its text."""
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
    """Return a C++ header without what only friends and heirs can use."""
    return _NOT_PUBLIC.sub("};", text)


def _fileComment(match):
    """The comment that a header begins with: its first sentence, and paragraphs with a word of what they are about."""
    name, text = match.groups()
    text = _PARAGRAPH.sub(r"\1**\2** ", re.sub(r'"([^"]*)"', "“\\1”", text))  # doxygen parts paragraphs at quotes
    return f"/** @file {name}\n * {text[0].upper()}{text[1:]}*/\n"


def _comments(text):
    text = _LEADING.sub(r"\1/** ", _TRAILING.sub(r"\1 /**< ", text))
    text = _FOLLOWING.sub("/** See above. */\n", text)
    return _HEADER_NAME.sub("%chaintree.h", text)


if __name__ == "__main__":
    header = Path(sys.argv[1]).read_text(encoding="utf-8")
    sys.stdout.write(ofCpp(header) if "\nclass " in header else ofC(header))
