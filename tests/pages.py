"""Code blocks of pages: what they hold, and how to run their commands."""

import re
import shlex
from pathlib import Path

from openmmchaintree.command.cli import main

PROJECT = Path(__file__).parents[1]
DOCS = PROJECT / "docs"
_BLOCK = re.compile(r"^```(?:\{literalinclude\} (\S+)\n((?::.*\n)*)|(python|sh)\n([\s\S]*?))```$", re.MULTILINE)
_OPTION = re.compile(r'^:([a-z-]+): "?(.*?)"?$', re.MULTILINE)


def blocksOf(page):
    """Generate (file name, or language of the page's own code; text) of the code blocks of a page."""
    for path, options, language, text in _BLOCK.findall((DOCS / page).read_text(encoding="utf-8")):
        if path:
            file = DOCS / path
            yield file.name, _cut(file.read_text(encoding="utf-8"), dict(_OPTION.findall(options)))
        else:
            yield language, text


def _cut(text, options):
    """Return the part of a text for literalinclude: from the line with start-at, or behind that with start-after, to
    the next with end-before.
    """
    lines = text.splitlines(keepends=True)
    after = options.get("start-after", "")
    start, end = (options.get(name, after).replace('\\"', '"') for name in ("start-at", "end-before"))
    first = next(number for number, line in enumerate(lines) if start in line) + bool(after)
    behind = [number for number, line in enumerate(lines) if number > first and end in line] if end else [len(lines)]
    return "".join(lines[first : behind[0]])


def commandsOf(text):
    """Return the commands of a block of shell code, as lists of words; a comment is no part of a command."""
    lines = text.replace("\\\n", " ").splitlines()
    return [words for line in lines if (words := shlex.split(line, comments=True))]


def runCommand(words, capsys):
    """Run a command openmm-chaintree of a page in the working folder and this process; return its report."""
    assert words[0] == "openmm-chaintree"
    status = main(words[1:])
    output, errors = capsys.readouterr()
    assert status == 0, f"{shlex.join(words)}: {errors}"
    return output
