"""Running the command as a user does."""

import os
import pty
import re
import signal
import subprocess
import sys
import tempfile

COMMAND = [sys.executable, "-m", "openmmchaintree"]

# Output files of the command for the villin headpiece.
VILLIN_FILES = [f"villin{end}" for end in ("-settings.toml", "-topology.pdb", ".checkpoint", ".csv", ".dcd", ".png")]


def run(*arguments, folder, command=COMMAND):
    """Run the command in a folder, and return what became of it."""
    return subprocess.run([*command, *map(str, arguments)], cwd=folder, capture_output=True, text=True)


def callMain(main, arguments, capsys):
    """Call a command's `main` within this process, and return what became of it: quicker where it stops early."""
    try:
        status = main([*map(str, arguments)])
    except SystemExit as exit:
        status = exit.code
    output, errors = capsys.readouterr()
    return subprocess.CompletedProcess(arguments, status, output, errors)


def readTerminal(controller):
    """Yield what is shown on a terminal until nobody has it open for writing: who does not read blocks who writes."""
    while True:
        try:
            shown = os.read(controller, 65536)
        except OSError:  # Linux reports the end so.
            return
        if not shown:
            return
        yield shown


def runOnATerminal(*arguments, folder, command=COMMAND, interruptAt=None, number=signal.SIGINT):
    """Run the command with its error output on a terminal. Return its exit status, its output, and what was shown.

    It is interrupted (Ctrl-C, or another signal) as soon as the regular expression interruptAt matches what was shown.
    """
    controller, terminal = pty.openpty()
    with tempfile.TemporaryFile("w+") as output:
        process = subprocess.Popen(
            [*command, *map(str, arguments)],
            cwd=folder,
            env={**os.environ, "TERM": "xterm"},
            stdout=output,
            stderr=terminal,
        )
        os.close(terminal)
        shown = b""
        for part in readTerminal(controller):
            shown += part
            if interruptAt is not None and re.search(interruptAt, shown.decode(errors="replace")):
                process.send_signal(number)
                interruptAt = None
        os.close(controller)
        process.wait()
        assert interruptAt is None, "it ended before the output at which it was to be interrupted"
        output.seek(0)
        return process.returncode, output.read(), shown.decode(errors="replace")


def filesIn(folder):
    return sorted(path.name for path in folder.iterdir())


def assertRefused(result, folder, filesBefore, *words):
    """One line, no longer than five on a terminal, that names the culprit; status 2, nothing written."""
    assert result.returncode == 2, result.stdout + result.stderr
    assert result.stdout == ""
    assert len(result.stderr.strip().splitlines()) == 1 and len(result.stderr) < 700
    for word in words:
        assert word in result.stderr
    assert filesIn(folder) == filesBefore
