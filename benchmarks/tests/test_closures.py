"""The script closures.py, as a user runs it. No test looks at how long anything takes."""

import closures
from racing.report import readCSV


def test_everythingQuickly(runScriptHere, tmp_path):
    result = runScriptHere(closures.main, "--quick", "--csv", "a.csv", "--markdown", "a.md")
    assert result.returncode == 0, result.stdout + result.stderr
    _, entries = readCSV(tmp_path / "a.csv")
    assert {entry["contestant"] for entry in entries} == {"all", "near"}
    for entry in entries:
        assert 0 < entry["microseconds"] <= entry["percentile99"] <= entry["worst"]
        assert entry["windows"] == 50 and 0 < entry["closed"] <= entry["closable"] <= 25 < entry["closures"]
    table = (tmp_path / "a.md").read_text(encoding="utf-8")
    assert "| all closures | villin |" in table


def test_programIsMissing(runScriptHere):
    result = runScriptHere(closures.main, "--quick", "--closures", "nowhere")
    assert result.returncode == 2 and "nowhere" in result.stderr
