"""The script platforms.py runs."""

import subprocess
import sys
from pathlib import Path

BENCHMARKS = Path(__file__).parents[1]


def test_platforms():
    command = [sys.executable, str(BENCHMARKS / "platforms.py"), "200"]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    rows = {line.split()[0] for line in result.stdout.splitlines()}
    assert {"Reference", "CPU"} <= rows
