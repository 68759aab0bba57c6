"""The program in C that runs the contestants."""

import json
import os
import signal
import subprocess
from pathlib import Path

from openmmchaintree.errors import InputError
from openmmchaintree.loading import compiledFolder

NAME = "openmm-chaintree-contestants"
VARIABLE = "CHAINTREE_CONTESTANTS"


class ProgramError(RuntimeError):
    """A race failed: contestants disagree, or there is not enough memory."""


class Program:
    """The program, by default that of the build from which the package is imported."""

    def __init__(self, path=None):
        """Find the program; an InputError tells that it is not there."""
        named = path or os.environ.get(VARIABLE)
        self._path = Path(named) if named else compiledFolder().parents[1] / "benchmarks" / NAME
        self._path = self._path.absolute()
        if not self._path.exists():
            raise InputError(
                f"there is no program {named or self._path}: import openmmchaintree from a build of this clone with "
                f"CHAINTREE_BUILD_BENCHMARKS=ON, or name the program by --program or {VARIABLE}"
            )

    def run(self, options):
        """Return the lines that the program prints, as dictionaries; options with the value None are left out."""
        words = [str(word) for name, value in options.items() if value is not None for word in (name, value)]
        return self._call(words)

    def describeBuild(self):
        """Return the compiler of the program and of the engine within it, and the flags."""
        (build,) = self._call(["--about"])
        return f"{build['compiler']} {build['flags']}"

    def _call(self, words):
        try:
            done = subprocess.run([self._path, *words], capture_output=True, text=True)
        except OSError as error:
            raise InputError(f"the program {self._path} does not run ({error.strerror})") from error
        if done.returncode == -signal.SIGINT:
            raise KeyboardInterrupt
        if done.returncode < 0:
            raise ProgramError(f"{NAME} was ended by signal {-done.returncode}")
        if done.returncode != 0:
            raise ProgramError(done.stderr.strip().removeprefix(f"{NAME}: "))
        return [json.loads(line) for line in done.stdout.splitlines()]
