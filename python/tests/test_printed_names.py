"""Names in files, and of files, are letters to a terminal, whatever they hold."""

import csv
import io
import os
import subprocess

import commands
import pytest
from openmmchaintree.command.terminal import ReportConsole, printable
from rich.table import Table
from scenes import GLYCINES, writePDB

EVIL = "\x1b]0;owned\x07"
CIF = """data_x
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_seq_id
_atom_site.auth_asym_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
"""


def writeEvil(path):
    """Glycines with evil names of chains, near each other, and an atom and a residue that belong to nothing."""
    rows = [
        f"ATOM {line[6:11]} {line[76:78]} {line[12:16]} {line[17:20]} {name} {line[22:26]} '{EVIL}{name}' "
        f"{line[30:46]} {float(line[46:54]) + shift}"
        for name, shift in (("A", 0), ("D", 2.2))
        for line in GLYCINES
        if line.startswith("ATOM")
    ]
    rows.append(f"HETATM 98 C 'C{EVIL}' 'X{EVIL}\x9b' B 1 '{EVIL}B' 1.5 0.1 0.1")
    rows.append(f"HETATM 99 C 'C{EVIL}' 'Y{EVIL}\x9b' B 1 '{EVIL}C' 1.0 0.1 0.1")
    path.write_text(CIF + "\n".join(rows) + "\n")


def isClean(text):
    return text == printable(text)


@pytest.mark.parametrize(
    "arguments",
    [
        ("clashes", "a.cif", "--verbose"),
        ("clashes", "a.cif", "--csv", "-"),
        ("clashes", "a.cif", "--json", "-"),
        ("clashes", "a.cif", "--notes", "-"),
        ("clashes", f"{EVIL}.pdb"),
        ("sample", "a.cif", "--move", EVIL),
        ("sample", "a.cif", "--forcefield", EVIL),
        ("sample", f"{EVIL}\x9b.pdb", "--trials", 10, "--verbose"),
        ("sample", "a.cif", f"--{EVIL}"),
        ("sample", "--config", "a.toml"),
        ("sample", "--resume", f"{EVIL}"),
    ],
)
def test_nothingReachesTheTerminal(runCommandHere, tmp_path, arguments):
    writeEvil(tmp_path / "a.cif")
    writePDB(tmp_path / f"{EVIL}\x9b.pdb", GLYCINES)
    (tmp_path / "a.toml").write_text('[sample]\ntrials = "\\u001b]0;owned"')
    result = runCommandHere(*arguments)
    assert isClean(result.stdout) and isClean(result.stderr)
    assert "owned" in result.stdout + result.stderr


def test_files(runCommandHere, tmp_path):
    writeEvil(tmp_path / "a.cif")
    assert runCommandHere("clashes", "a.cif", "--csv", "a.csv", "--picture", "a.svg").returncode == 0
    text = (tmp_path / "a.csv").read_text()
    assert isClean(text) and "\\x1b]0;owned" in text
    assert len({len(row) for row in csv.reader(io.StringIO(text))}) == 1


def test_letters():
    assert printable("φ ±5° – α\nC1' µ é 中 𝛼") == "φ ±5° – α\nC1' µ é 中 𝛼"
    assert printable("\x1b[31m\t\r\x9b\u202e\x7f") == "\\x1b[31m\\x09\\x0d\\u009b\\u202e\\x7f"
    console = ReportConsole([])
    console.file = io.StringIO()
    table = Table(EVIL)
    table.add_row(EVIL)
    console.print(EVIL, table)
    assert isClean(console.file.getvalue()) and console.file.getvalue().count("owned") == 3


def test_aFolderThatIsGone(tmp_path):
    folder = tmp_path / "gone"
    folder.mkdir()
    for command in (["clashes"], ["sample", "--trials", "10"], ["sample", "--config", "a.toml"]):
        result = subprocess.run(
            ["sh", "-c", 'mkdir -p gone && cd gone && rmdir ../gone && "$@"', "sh", *commands.COMMAND, *command],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env={**os.environ, "PYTHONSAFEPATH": "1"},
        )
        assert (result.returncode, result.stdout) == (2, "")
        words = "openmm-chaintree: the working folder was removed: run the command in one that is there\n"
        assert result.stderr == words
