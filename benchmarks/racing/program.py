"""The program in C that runs the contestants: where it is, whom it knows, and what it measures."""

import json
import os
import signal
import subprocess
from pathlib import Path
from typing import NamedTuple

from openmmchaintree.errors import InputError
from openmmchaintree.loading import compiledFolder

_NAME = "openmm-chaintree-contestants"
_VARIABLE = "CHAINTREE_CONTESTANTS"

_PARTS = {"quartiles": ("quartile1", "quartile3"), "rg": ("rgStart", "rgEnd")}


class ProgramError(RuntimeError):
    """What the program says is wrong with a race: contestants that disagree, or memory that does not suffice."""


class Interrupted(Exception):
    """The user's interrupt reached the program, too."""


class Contestant(NamedTuple):
    """A contestant of the program: what it takes part in, its name, and whether it also tests whole chains."""

    measure: str
    name: str
    testsWholeChains: bool


class Program:
    """The program.

    contestants : list of Contestant
    """

    def __init__(self, path=None):
        """Ask the program for its contestants; without a path, look for it.

        Raises
        ------
        InputError
            if it is not there or does not run
        """
        self._path = findProgram() if path is None else Path(path)
        if not self._path.exists():
            raise InputError(
                f"there is no program {self._path}: import openmmchaintree from a build of this clone with "
                f"CHAINTREE_BUILD_BENCHMARKS=ON, or name the program by --program or {_VARIABLE}"
            )
        self.contestants = [
            Contestant(line["measure"], line["contestant"], line.get("whole", False))
            for line in self._run({"--list": None}, {})
        ]

    def race(self, options, variables=None):
        """Run a race.

        Parameters
        ----------
        options : dict
            the program's options with their values; None are left out
        variables : dict, optional
            of the environment, beside those of this process

        Returns
        -------
        list of dict
            the program's lines: one for each contestant

        Raises
        ------
        ProgramError
            if the race fails
        Interrupted
            if the user ended it
        """
        given = {name: value for name, value in options.items() if value is not None}
        return self._run(given, variables or {})

    def describeBuild(self):
        """Return the compiler of the program and of the engine within it, and the flags."""
        (build,) = self._run({"--about": None}, {})
        return f"{build['compiler']} {build['flags']}"

    def _run(self, options, variables):
        words = [str(word) for option in options.items() for word in option if word is not None]
        try:
            done = subprocess.run([self._path, *words], env={**os.environ, **variables}, capture_output=True, text=True)
        except OSError as error:
            raise InputError(f"the program {self._path} does not run ({error.strerror})") from error
        if done.returncode == -signal.SIGINT:
            raise Interrupted
        if done.returncode < 0:
            raise ProgramError(f"{_NAME} was ended by signal {-done.returncode}")
        if done.returncode != 0:
            raise ProgramError(done.stderr.strip().removeprefix(f"{_NAME}: "))
        return [_flatten(json.loads(line)) for line in done.stdout.splitlines()]


def _flatten(line):
    """Give the numbers of a list names of their own."""
    flat = {}
    for key, value in line.items():
        names = _PARTS.get(key)
        flat.update({key: value} if names is None else zip(names, value, strict=True))
    return flat


def findProgram():
    """Return the path that the variable names, or where the program lies in the build of the imported package."""
    named = os.environ.get(_VARIABLE)
    return Path(named) if named else compiledFolder().parents[1] / "benchmarks" / _NAME
