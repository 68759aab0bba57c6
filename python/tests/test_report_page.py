"""The page of a run: what it says, and that it needs no network. tests/long_report_page.py shows it in a browser."""

import re
import sys

import pytest
from commands import assertRefused
from openmmchaintree.command.cli import main


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        arguments = "--trials 2000 --frames 40 --seed 1 --forcefield amber14-all.xml implicit/gbn2.xml".split()
        assert main(["sample", *arguments, "--report", "run.html", "-o", "<b>&amp;"]) == 0
    return folder / "run.html"


def withoutViewer(page):
    """Return the page's text without scripts and styles."""
    text = page.read_text(encoding="utf-8")
    return re.sub(r"<(script|style)[^>]*>.*?</\1>", "", text, flags=re.DOTALL)


def test_thePageSaysWhatTheReportSays(page):
    text = withoutViewer(page)
    for words in ("radius of gyration (nm)", "R-hat", "Do not quote these means", "φ/ψ closed 8°", "CustomGBForce"):
        assert words in text
    assert "2,000 trials" in text and "21 frames, superposed" in text  # every second one of 41
    assert "forcefield" in text and "<b>&amp;" not in text  # names are no markup


def test_thePageNeedsNoNetwork(page):
    text = withoutViewer(page)
    assert re.findall(r"(?:src|href)=\"(?!data:)", text) == []
    models = re.search(r'id="frames">(.*?)</script>', page.read_text(encoding="utf-8"), re.DOTALL)[1]
    assert models.count("ENDMDL") == 21 and "</" not in models


def test_hardSpheresAndReplicasHavePages(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["sample", "--trials", "40", "--frames", "4", "--seed", "1", "--report", "a.html", "-o", "a"]) == 0
    ladder = "--trials 80 --frames 2 --trials-per-exchange 40 --temperatures 300:330:2 --seed 1".split()
    force = "--forcefield amber14-all.xml implicit/gbn2.xml".split()
    assert main(["sample", *ladder, *force, "--report", "b.html", "-o", "b"]) == 0
    assert "Energies" not in withoutViewer(tmp_path / "a.html")
    ofLadder = withoutViewer(tmp_path / "b.html")
    assert "At 300.0 K" in ofLadder and "first trajectory" in ofLadder


@pytest.mark.parametrize("package", ["jinja2", "molstar_cli"])
def test_aMissingPackageIsNoticedAtTheStart(runCommandHere, tmp_path, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    result = runCommandHere("sample", "--report", "run.html")
    assertRefused(result, tmp_path, [], f"--report needs {package}", "openmm-chaintree[report]")
