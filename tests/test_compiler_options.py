"""The options that the C libraries are compiled with: their speed and their bits depend on them."""

import json
import os
import platform
import shlex
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
SETS = {
    "PORTABLE": set(),
    "AVX2": {"-mavx2"},
    "AVX512": {"-mavx512f", "-mavx512bw", "-mprefer-vector-width=512"},
}

pytestmark = pytest.mark.skipif(
    shutil.which("cmake") is None or shutil.which("gcc") is None, reason="there is no CMake, or no gcc"
)


@pytest.fixture(scope="module")
def compilations(tmp_path_factory):
    """The file and the options, by library and instruction set, of each file of a default build's C libraries."""
    folder = tmp_path_factory.mktemp("build")
    options = ["-DCHAINTREE_ENGINE_ONLY=ON", "-DCHAINTREE_BUILD_TESTS=OFF", "-DCHAINTREE_BUILD_BENCHMARKS=OFF"]
    plain = {name: value for name, value in os.environ.items() if name not in ("CFLAGS", "CXXFLAGS")}
    command = ["cmake", "-S", PROJECT, "-B", folder, "-DCMAKE_C_COMPILER=gcc", *options]
    subprocess.run(command, check=True, capture_output=True, env=plain)
    found = []
    for entry in json.loads((folder / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        target = Path(words[words.index("-o") + 1]).parts
        found.append((target[target.index("CMakeFiles") + 1].removesuffix(".dir"), entry["file"], set(words)))
    return found


def test_allAreOptimizedAndRoundAlike(compilations):
    for _, file, options in compilations:
        assert {"-O3", "-DNDEBUG", "-ffp-contract=off", "-fno-math-errno"} <= options, file
        assert not [option for option in options if option in ("-O0", "-O1", "-O2", "-Os", "-ffast-math")], file
    libraries = Counter(target.partition("_")[0] for target, *_ in compilations)
    assert {"chaintree", "ctenergy", "ctmoves"} == set(libraries) and min(libraries.values()) > 5


def test_theEngineIsAlignedAndInlined(compilations):
    for target, file, options in compilations:
        if target.startswith("chaintree"):
            assert {"-falign-functions=64", "-DCT_INLINES_VISITORS"} <= options, file


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="another processor")
@pytest.mark.parametrize("library", ["chaintree", "ctenergy"])
def test_eachInstructionSetHasItsOptionsAndOneUnit(compilations, library):
    for name, needed in SETS.items():
        ((_, file, options),) = [entry for entry in compilations if entry[0] == f"{library}_{name}"]
        assert "Unity" in Path(file).parts
        assert {option for option in options if option.startswith("-m")} == needed
