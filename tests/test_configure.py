"""Whatever is wrong with the OpenMM, the Python or the SWIG that CMake finds, it says so in one sentence."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MODULES = Path(__file__).parents[1] / "cmake"
HEADER = """
#include <string>
namespace OpenMM {
struct Platform {
    static void loadPluginLibrary(const std::string& file);
    static const std::string& getOpenMMVersion();
};
}
"""
SOURCE = """
#include "openmm/Platform.h"
void OpenMM::Platform::loadPluginLibrary(const std::string& file) {}
const std::string& OpenMM::Platform::getOpenMMVersion() { static std::string version = "%s"; return version; }
"""
PROJECT = """
cmake_minimum_required(VERSION 3.22)
project(finding CXX)
find_package(OpenMM 8.4 REQUIRED)
"""

pytestmark = pytest.mark.skipif(shutil.which("cmake") is None, reason="CMake is not on the path")


def cmakeError(*arguments):
    """What CMake says when it stops, on one line."""
    result = subprocess.run(["cmake", *map(str, arguments)], capture_output=True, text=True)
    assert result.returncode != 0
    message = re.search(r"CMake Error at .*? \(message\):(.*?)(\nCall Stack|$)", result.stderr.strip(), re.DOTALL)[1]
    message = " ".join(message.split())
    print(message)
    return message


# ---- OpenMM itself ----


def makeOpenMM(folder, version, *options):
    """A library that has of OpenMM what finding it needs."""
    compiler = shutil.which("c++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    (folder / "include" / "openmm").mkdir(parents=True)
    (folder / "lib").mkdir()
    (folder / "include" / "OpenMM.h").touch()
    (folder / "include" / "openmm" / "Platform.h").write_text(HEADER)
    (folder / "platform.cpp").write_text(SOURCE % version)
    include, library = f"-I{folder / 'include'}", folder / "lib" / "libOpenMM.so"
    command = [compiler, "-shared", "-fPIC", include, *options, "-o", library, folder / "platform.cpp"]
    subprocess.run(command, check=True)
    return folder


def findingError(tmp_path, openmm):
    (tmp_path / "CMakeLists.txt").write_text(PROJECT)
    options = [f"-DCMAKE_MODULE_PATH={MODULES}", f"-DOPENMM_DIR={openmm}"]
    return cmakeError("-S", tmp_path, "-B", tmp_path / "build", *options)


def test_openMMIsTooOld(tmp_path):
    openmm = makeOpenMM(tmp_path / "openmm", "8.3.1")
    expected = f"OpenMM in {openmm / 'lib'} is version 8.3.1: install openmm 8.4 or later."
    assert findingError(tmp_path, openmm) == expected


def test_openMMHasTheOldStringABI(tmp_path):
    openmm = makeOpenMM(tmp_path / "openmm", "8.3", "-D_GLIBCXX_USE_CXX11_ABI=0")
    expected = (
        f"OpenMM 8.3 in {openmm / 'lib'} uses the old C++ string ABI, as its wheels before 8.4 do: "
        "install openmm 8.4 or later."
    )
    assert findingError(tmp_path, openmm) == expected


def test_openMMIsNotWhereItIsSaidToBe(tmp_path):
    (tmp_path / "openmm").mkdir()
    expected = f"OPENMM_DIR is {tmp_path / 'openmm'}, but that folder does not hold OpenMM's include and lib."
    assert findingError(tmp_path, tmp_path / "openmm") == expected


def test_openMMLacksALibraryOfItsOwn(tmp_path):
    openmm = makeOpenMM(tmp_path / "openmm", "8.6")
    missing = tmp_path / "libmissing.so"
    subprocess.run(["c++", "-shared", "-o", missing, "-Wl,-soname,libmissing.so", "-xc++", "/dev/null"], check=True)
    library = openmm / "lib" / "libOpenMM.so"
    sources = [openmm / "platform.cpp", missing]
    command = ["c++", "-shared", "-fPIC", f"-I{openmm / 'include'}", "-Wl,--no-as-needed", "-o", library, *sources]
    subprocess.run(command, check=True)
    missing.unlink()
    log = tmp_path / "build" / "OpenMMProbe.log"
    assert findingError(tmp_path, openmm) == (
        f"A program linked with OpenMM in {openmm / 'lib'} does not run (libmissing.so: cannot open shared object "
        f"file: No such file or directory; see {log}): install the library that it lacks, or OpenMM again."
    )
    assert "libmissing.so" in log.read_text()


def test_openMMEndsTheProgram(tmp_path):
    (tmp_path / "end.h").write_text("#include <cstdlib>\nstatic int end = (std::_Exit(1), 0);\n")
    openmm = makeOpenMM(tmp_path / "openmm", "8.6", f"-include{tmp_path / 'end.h'}")
    log = tmp_path / "build" / "OpenMMProbe.log"
    expected = (
        f"A program linked with OpenMM in {openmm / 'lib'} does not run (see {log}): "
        "install the library that it lacks, or OpenMM again."
    )
    assert findingError(tmp_path, openmm) == expected


def test_openMMCannotBeLinked(tmp_path):
    openmm = makeOpenMM(tmp_path / "openmm", "8.6")
    (openmm / "lib" / "libOpenMM.so").write_text("damaged")
    log = tmp_path / "build" / "OpenMMProbe.log"
    expected = (
        f"A program cannot be linked with OpenMM in {openmm / 'lib'} (see {log}): install another OpenMM or compiler."
    )
    assert findingError(tmp_path, openmm) == expected
    assert "libOpenMM.so" in log.read_text()


# ---- The Python that the module is made for ----


@pytest.fixture
def package(tmp_path):
    """An OpenMM of Python as far as it is looked at: its version and its SWIG runtime."""
    (tmp_path / "openmm").mkdir()
    (tmp_path / "openmm" / "version.py").write_text("short_version = '8.6.1'\n")
    (tmp_path / "openmm" / "_openmm.so").write_text("swig_runtime_data5")
    (tmp_path / "swigrun.swg").write_text('#define SWIG_RUNTIME_VERSION "5"\n')
    return tmp_path / "openmm"


def checkPython(package, version="8.6.1"):
    values = {
        "Python_EXECUTABLE": sys.executable,
        "OpenMM_PYTHON_PACKAGE_DIR": package or "",
        "OpenMM_VERSION": version,
        "OpenMM_LIBRARY_DIR": "/opt/openmm/lib",
        "SWIG_DIR": package.parent if package else "",
        "SWIG_VERSION": "4.1.0",
        "SWIG_EXECUTABLE": "/usr/bin/swig",
    }
    return [f"-D{name}={value}" for name, value in values.items()] + ["-P", MODULES / "CheckOpenMMPython.cmake"]


def test_sameVersionAndRuntimePass(package):
    subprocess.run(["cmake", *checkPython(package)], check=True)


def test_pythonHasNoOpenMM():
    assert cmakeError(*checkPython(None)) == (
        f"{sys.executable} has no package openmm: install it (pip install openmm==8.6.1), "
        "or build without Python by -DCHAINTREE_BUILD_PYTHON=OFF."
    )


def test_pythonHasAnotherOpenMM(package):
    assert cmakeError(*checkPython(package, "8.5.2")) == (
        f"OpenMM in /opt/openmm/lib is version 8.5.2, but the Python package in {package} is 8.6.1: "
        "install the same version of both."
    )


def test_swigWritesAnotherRuntime(package):
    (package.parent / "swigrun.swg").write_text('#define SWIG_RUNTIME_VERSION "4"\n')
    assert cmakeError(*checkPython(package)) == (
        "SWIG 4.1.0 (/usr/bin/swig) writes modules of runtime 4, but OpenMM 8.6.1 uses runtime 5: "
        'pip install "swig>=4.4".'
    )
