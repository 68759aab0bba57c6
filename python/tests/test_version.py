"""The version is told, and it is the project's."""

import re
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import openmm
import openmmchaintree
import pytest


def test_theCommandTellsIt(runCommandHere):
    result = runCommandHere("--version")
    assert result.returncode == 0
    expected = f"openmm-chaintree {openmmchaintree.__version__}, OpenMM {openmm.Platform.getOpenMMVersion()}\n"
    assert result.stdout == expected


def test_itIsThatOfTheProject():
    text = (Path(__file__).parents[2] / "CMakeLists.txt").read_text(encoding="utf-8")
    assert re.search(r"project\(openmm-chaintree\s+VERSION ([0-9.]+)", text)[1] == openmmchaintree.__version__


def test_itIsThatOfAnInstalledPackage():
    try:
        installed = version("openmm-chaintree")
    except PackageNotFoundError:
        pytest.skip("the package is not installed")
    assert installed.split("+")[0] == openmmchaintree.__version__
