"""Running the command as a user does."""

import os
import pty
import subprocess
import sys

COMMAND = [sys.executable, "-m", "openmmchaintree"]


def run(*arguments, folder):
    """Run the command in a folder, and return what became of it."""
    return subprocess.run([*COMMAND, *map(str, arguments)], cwd=folder, capture_output=True, text=True, timeout=300)


def runOnATerminal(*arguments, folder):
    """Run the command with its error output on a terminal; return its exit status and what is seen there."""
    controller, terminal = pty.openpty()
    process = subprocess.Popen(
        [*COMMAND, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, "TERM": "xterm"},
        stdout=subprocess.PIPE,
        stderr=terminal,
    )
    process.communicate(timeout=60)
    os.close(terminal)
    shown = os.read(controller, 10**6).decode(errors="replace")
    os.close(controller)
    return process.returncode, shown


def filesIn(folder):
    return sorted(path.name for path in folder.iterdir())


def assertRefused(result, folder, filesBefore, *words):
    """One line that names the culprit, status 2, nothing written."""
    assert result.returncode == 2, result.stdout + result.stderr
    assert result.stdout == ""
    assert len(result.stderr.strip().splitlines()) == 1
    for word in words:
        assert word in result.stderr
    assert filesIn(folder) == filesBefore
