"""The program in C that runs the contestants: where it is, whom it knows, and what it measures."""

import json
import os
import signal
import subprocess
from typing import NamedTuple

from ...errors import InputError
from ...loading import compiledFolder

_NAME = "openmm-chaintree-contestants"


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

    def __init__(self):
        """Look for the program, and ask it for its contestants.

        Raises
        ------
        InputError
            if it is not there or does not run
        """
        self._path = compiledFolder() / "bin" / _NAME
        if not self._path.exists():
            raise InputError(
                f"the program {_NAME} is not in {self._path.parent}: install openmm-chaintree again, without "
                "CHAINTREE_BUILD_BENCHMARKS=OFF"
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
        return [json.loads(line) for line in done.stdout.splitlines()]
