"""What pip makes of the project: a package that finds its libraries wherever it is installed beside OpenMM."""

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import openmm
import pytest

PROJECT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with the installed package, and beside it the wheel's OpenMM as in any environment."""
    pytest.importorskip("scikit_build_core", reason="the build backend is not installed")
    if shutil.which("swig") is None:
        pytest.skip("SWIG is not installed")
    openmmFolder = Path(openmm.__file__).parent
    libraries = openmmFolder.parent / "OpenMM.libs"
    if not libraries.is_dir():
        pytest.skip("OpenMM is not from a wheel")
    folder = tmp_path_factory.mktemp("site")
    options = ["--quiet", "--no-deps", "--no-index", "--no-build-isolation", "--target", str(folder)]
    # Results are tested elsewhere. Without optimization, compiling takes half of the time.
    for language in ("C", "CXX"):
        options += ["-C", f"cmake.define.CMAKE_{language}_FLAGS_RELEASE=-O0"]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, str(PROJECT)], check=True, env=environment())
    (folder / "OpenMM.libs").symlink_to(libraries)
    (folder / "openmm").symlink_to(openmmFolder)
    return folder


def environment(**changes):
    """The environment without the build tree's package, which would hide the installed one."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONPATH"} | changes


@pytest.mark.parametrize("pattern", ["*.so", "lib/*.so", "lib/plugins/*.so"])
def test_everyLibraryFindsTheOthersByItself(site, pattern):
    libraries = list((site / "openmmchaintree").glob(pattern))
    assert len(libraries) == 1
    # That process has not loaded OpenMM, so the library's paths must lead to it.
    subprocess.run([sys.executable, "-c", f"import ctypes; ctypes.CDLL({str(libraries[0])!r})"], check=True, cwd=site)


def test_theOpenMMThatItWasBuiltOnIsADependency(site):
    (distribution,) = importlib.metadata.distributions(name="openmm-chaintree", path=[str(site)])
    major, minor = map(int, openmm.Platform.getOpenMMVersion().split(".")[:2])
    found = [re.fullmatch(r"openmm([<>=][^;]*)", text.replace(" ", "")) for text in distribution.requires]
    (specifiers,) = [match[1] for match in found if match]
    assert set(specifiers.split(",")) == {f">={major}.{minor}", f"<{major}.{minor + 1}"}


def test_theCommandRuns(site, tmp_path):
    command = [str(site / "bin" / "openmm-chaintree"), "sample", "--trials", "1000", "--seed", "1"]
    variables = environment(PYTHONPATH=str(site))
    result = subprocess.run(command, cwd=tmp_path, env=variables, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert (tmp_path / "villin.dcd").stat().st_size > 0


def test_theCommandSaysWhatToInstall(site, tmp_path):
    (tmp_path / "openmm").mkdir()
    (tmp_path / "openmm" / "__init__.py").write_text("raise ImportError('libOpenMM.so is missing')\n")
    command = [str(site / "bin" / "openmm-chaintree"), "sample"]
    variables = environment(PYTHONPATH=f"{tmp_path}{os.pathsep}{site}")
    result = subprocess.run(command, cwd=tmp_path, env=variables, capture_output=True, text=True)
    assert (result.returncode, result.stdout) == (2, "")
    (message,) = result.stderr.splitlines()
    assert message.startswith("openmm-chaintree: openmmchaintree needs OpenMM ")
    assert "(libOpenMM.so is missing): pip install" in message


def test_publicHeadersAndNothingInternalAreThere(site):
    package = site / "openmmchaintree"
    headers = {str(path.relative_to(package / "include")) for path in package.glob("include/**/*.h")}
    classes = {
        "LoopGrowth",
        "StericExclusionForce",
        "TorsionDensity",
        "TorsionMonteCarloIntegrator",
        "internal/windowsExportChainTree",
    }
    assert headers == {"OpenMMChainTree.h", *(f"openmmchaintree/{name}.h" for name in classes)}
    assert not list(package.glob("**/*.a"))


def test_typesAndTablesAreThere(site):
    for name in ["py.typed", "openmmchaintree.pyi", "tables/loops.csv", "tables/rotamers.csv"]:
        assert (site / "openmmchaintree" / name).is_file()


def test_forceFieldFindsTheFile(site):
    program = """
import openmm.app as app
app.ForceField("amber14-all.xml", "openmmchaintree/steric-exclusion.xml")
import sys
assert "openmmchaintree._openmmchaintree" in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True, cwd=site, env=environment(PYTHONPATH=str(site)))
