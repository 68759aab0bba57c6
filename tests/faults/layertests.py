"""Copies of the repository, and the tests of a layer on them."""

import importlib.util
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

from layer import REPOSITORY, Layer


def run(command, **arguments):
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **arguments)


def runLimited(command, seconds: float, **arguments) -> tuple[int, str] | None:
    """Returns the exit status and the output; None if it took longer and was killed with the processes it started."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(command, start_new_session=True, **pipes, **arguments) as process:
        try:
            output, _ = process.communicate(timeout=seconds)
            return process.returncode, output
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return None


class Copy:
    """A copy of the repository's tracked files."""

    def __init__(self, folder: pathlib.Path, all: bool):
        self.all = all  # whether all tests run after one has failed
        self.source = folder / "source"
        self.build = folder / "build"
        self.source.mkdir(parents=True, exist_ok=True)
        tracked = run(["git", "ls-files"], cwd=REPOSITORY, check=True).stdout.splitlines()
        for name in tracked:
            self.write(name, (REPOSITORY / name).read_bytes())
        for path in self.source.rglob("*"):
            if path.is_file() and str(path.relative_to(self.source)) not in tracked:
                path.unlink()

    def write(self, name: str, content: bytes) -> None:
        """Writes a file unless it has this content: its time decides what is built."""
        path = self.source / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_bytes() != content:
            path.write_bytes(content)


class CompiledTests:
    """The tests of a layer in C or C++, built without Python and with little optimization."""

    def __init__(self, copy: Copy, layer: Layer):
        self.copy = copy
        self.layer = layer
        isApi = layer.name == "api"
        self.build = copy.build / ("api" if isApi else "c")
        self.limit = 7200.0  # seconds for all tests
        options = {
            "Python_EXECUTABLE": sys.executable,
            "CHAINTREE_ENGINE_ONLY": "OFF" if isApi else "ON",
            "CHAINTREE_BUILD_PYTHON": "OFF",
            "CHAINTREE_BUILD_BENCHMARKS": "OFF",
            "CHAINTREE_SANITIZE": "",
            "CMAKE_C_FLAGS_RELEASE": "-O1",
            "CMAKE_CXX_FLAGS_RELEASE": "-O1",
        }
        command = ["cmake", "-S", copy.source, "-B", self.build, "-G", "Ninja"]
        configured = run(command + [f"-D{name}={value}" for name, value in options.items()])
        if configured.returncode != 0:
            sys.exit(configured.stdout)
        listed = run(["ctest", "--test-dir", self.build, "-L", layer.name, "-E", layer.never, "-N"]).stdout
        self.names = re.findall(r"Test +#\d+: (\S+)", listed)

    def make(self) -> str:
        """Returns the compiler's message if it failed."""
        made = run(["cmake", "--build", self.build])
        return "" if made.returncode == 0 else made.stdout

    def catchers(self) -> list[str]:
        """Returns the tests that fail."""
        start = time.monotonic()
        found = self._failing("^(" + "|".join(self.names) + ")$", self.layer.slow)
        for name in self.names:
            if not found and re.match(self.layer.slow, name):
                found = self._failing(f"^{name}$", "^$")
        if not found:  # all have run, so later runs that take much longer hang
            self.limit = max(60.0, 2 * (time.monotonic() - start))
        return found

    def _failing(self, pattern: str, without: str) -> list[str]:
        command = ["ctest", "--test-dir", self.build, "-R", pattern, "-E", without]
        ran = runLimited(command + ([] if self.copy.all else ["--stop-on-failure"]), self.limit)
        if ran is None:
            return ["a test that hangs"]
        if "No tests were found" in ran[1]:
            sys.exit(f"no test matches {pattern}")
        return re.findall(r"^\t *\d+ - (\S+)", ran[1], re.MULTILINE)


class PythonTests:
    """The tests of the Python layer, with the copy's modules and the compiled part of the package that is imported."""

    def __init__(self, copy: Copy, layer: Layer):
        self.copy = copy
        self.layer = layer
        self.tests = copy.source / "python" / "tests"
        self.package = copy.build / layer.name
        found = importlib.util.find_spec("openmmchaintree")
        if found is None or found.origin is None:
            sys.exit("openmmchaintree cannot be imported, whose compiled part these tests need: set PYTHONPATH")
        built = pathlib.Path(found.origin).parent
        for folder in built.parent.glob("openmmchaintree*"):
            shutil.copytree(folder, self.package / folder.name, dirs_exist_ok=True)
        names = [path.stem for path in self.tests.glob("test_*.py")]
        # Tests of replicas run first, since most faults are in replicas.
        names = sorted((name for name in names if not re.match(layer.never, name)), reverse=True)
        self.names = sorted(names, key=self._isSlow)

    def _isSlow(self, name: str) -> bool:
        return re.match(self.layer.slow, name) is not None

    def make(self) -> str:
        """Returns Python's message if a module has a syntax error."""
        root = self.copy.source / "python"
        for path in root.glob("openmmchaintree*/**/*.py"):
            text = path.read_text()
            try:
                compile(text, str(path), "exec")
            except SyntaxError as error:
                return str(error)
            (self.package / path.relative_to(root)).write_text(text)
        return ""

    def catchers(self) -> list[str]:
        """Returns the tests that fail."""
        quick = [name for name in self.names if not self._isSlow(name)]
        found = self._failing(quick)
        for name in self.names[len(quick) :]:
            found = found or self._failing([name])
        return found

    def _failing(self, names: list[str]) -> list[str]:
        files = [self.tests / f"{name}.py" for name in names]
        stop = [] if self.copy.all else ["-x"]
        ran = runLimited(
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *stop, *files],
            1800,
            cwd=self.copy.build,  # not the package's folder: some tests start Python with another package
            env={**os.environ, "PYTHONPATH": str(self.package), "PYTHONDONTWRITEBYTECODE": "1"},
        )
        if ran is None:
            return ["a test that hangs"]
        status, output = ran
        failed = re.findall(r"^(?:FAILED|ERROR) .*?(test_\w+\.py\S*)", output, re.MULTILINE)
        return failed if failed or status == 0 else [f"exit status {status}"]
