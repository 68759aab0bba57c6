"""Whatever is wrong with an installation, import and command say it in one sentence that ends with what to install."""

import subprocess
import sys
from pathlib import Path

import openmmchaintree._build
import pytest

PACKAGE = Path(openmmchaintree._build.__file__).parent  # where the extension is
VERSION = openmmchaintree._build.OPENMM_VERSION
MINOR = ".".join(VERSION.split(".")[:2])
RUNTIME = openmmchaintree._build.SWIG_RUNTIME
OPENMM_STUB = """
import sys, types
sys.modules["swig_runtime_data{runtime}"] = types.ModuleType("swig_runtime_data{runtime}")
class Platform:
    getOpenMMVersion = staticmethod(lambda: "{version}")
"""


@pytest.fixture
def site(tmp_path):
    """A folder with the package, whose files a test may replace."""
    (tmp_path / "openmmchaintree").mkdir()
    for file in PACKAGE.iterdir():
        (tmp_path / "openmmchaintree" / file.name).symlink_to(file)
    return tmp_path


def replace(file, text):
    file.unlink(missing_ok=True)
    file.parent.mkdir(exist_ok=True)
    file.write_text(text)


def run(site, program):
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, sys.argv[1]); {program}", str(site)]
    return subprocess.run(command, cwd=site, capture_output=True, text=True)


def importError(site):
    """What an import says is wrong, after which the command has said the same."""
    result = run(site, "import openmmchaintree")
    assert result.returncode != 0
    assert result.stderr.count("Traceback") == 1
    message = result.stderr.splitlines()[-1].removeprefix("ImportError: ")
    print(message)
    assert message.startswith("openmmchaintree")
    assert commandError(site) == f"openmm-chaintree: {message}\n"
    return message


def commandError(site):
    """Return the output of the shell command."""
    result = run(site, "import openmmchaintree_command; sys.exit(openmmchaintree_command.main())")
    assert (result.returncode, result.stdout) == (2, "")
    return result.stderr


@pytest.mark.parametrize("version", ["7.7", "8.3.1", "9.0"])
def test_anotherMinorVersionOfOpenMM(site, version):
    replace(site / "openmm" / "__init__.py", OPENMM_STUB.format(version=version, runtime=RUNTIME))
    message = importError(site)
    assert f"built for OpenMM {MINOR} and cannot run with OpenMM {version}" in message
    assert f'pip install "openmm=={MINOR}.*"' in message


def test_anotherSwigRuntime(site):
    replace(site / "openmm" / "__init__.py", OPENMM_STUB.format(version=VERSION, runtime=int(RUNTIME) - 1))
    message = importError(site)
    assert f"built with SWIG runtime {RUNTIME}, which the OpenMM in {site / 'openmm'} does not use" in message
    assert f'pip install "openmm=={MINOR}.*"' in message


def test_noOpenMM(site):
    replace(site / "openmm" / "__init__.py", "raise ModuleNotFoundError(\"No module named 'openmm'\")")
    message = importError(site)
    assert f"needs OpenMM {MINOR}, which cannot be imported (No module named 'openmm')" in message
    assert message.endswith(f'pip install "openmm=={MINOR}.*"')


def test_extensionThatDoesNotLoad(site):
    (extension,) = (site / "openmmchaintree").glob("_openmmchaintree.*.so")
    replace(extension, "")
    message = importError(site)
    assert f"cannot load its libraries ({extension}: file too short)" in message
    assert message.endswith(f"install openmm-chaintree again, beside OpenMM {MINOR}")


def test_noPluginLibrary(site):
    (site / "openmmchaintree" / "lib").unlink()
    message = importError(site)
    assert f"has no plugin library in {site / 'openmmchaintree' / 'lib' / 'plugins'}" in message
    assert message.endswith(f"install openmm-chaintree again, beside OpenMM {MINOR}")


def test_pluginLibraryThatDoesNotLoad(site):
    (site / "openmmchaintree" / "lib").unlink()
    (site / "openmmchaintree" / "lib").mkdir()
    for library in (PACKAGE / "lib" / "plugins").iterdir():
        replace(site / "openmmchaintree" / "lib" / "plugins" / library.name, "")
    message = importError(site)
    assert "cannot load its plugin library" in message
    assert message.endswith(f"install openmm-chaintree again, beside OpenMM {MINOR}")


def test_sourceThatWasNotBuilt(site):
    (site / "openmmchaintree" / "_build.py").unlink()
    message = importError(site)
    assert f"in {site / 'openmmchaintree'} has no compiled part" in message


def test_aPackageThatIsNeededIsMissing(site):
    replace(site / "rich" / "__init__.py", "raise ModuleNotFoundError(\"No module named 'rich'\", name='rich')")
    assert commandError(site) == (
        "openmm-chaintree: the command needs rich, which cannot be imported (No module named 'rich'): "
        "pip install 'openmm-chaintree[tools]'\n"
    )
