"""The messages that docs/troubleshooting.md explains are those of the code."""

import ast
import re

from pages import DOCS, PROJECT

_LITERAL = re.compile(r'"((?:[^"\\\n]|\\.)*)"')


def test_theMessagesAreThoseOfTheCode():
    rows = re.findall(r"^\| (`.*?) \|", (DOCS / "troubleshooting.md").read_text(encoding="utf-8"), re.MULTILINE)
    messages = [message for row in rows for message in re.findall(r"`([^`]+)`", row)]
    assert len(messages) > 80
    texts = "\n".join(_textsOfPython()) + "\n".join(_textsOfCpp())
    parts = [part.strip() for message in messages for part in message.split("…") if part.strip()]
    assert not [part for part in parts if part not in texts]


def _textsOfPython():
    """Yield the constant parts of all texts."""
    for path in (PROJECT / "python").rglob("*.py"):
        if "tests" not in path.parts:
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str):
                    yield node.value


def _textsOfCpp():
    """Yield the string literals, adjacent ones as one."""
    for path in (PROJECT / "openmmapi").rglob("*.cpp"):
        text = re.sub(r'"\s*\n\s*"', "", path.read_text(encoding="utf-8"))
        yield from _LITERAL.findall(text)
