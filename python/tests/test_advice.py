"""What errors advise: options that the command has, and that help. No error is longer than five lines."""

import ast
import json
import re
from pathlib import Path

import numpy as np
import openmm
import openmmchaintree
import pytest
from commands import assertRefused
from openmmchaintree.command import clashes, ensemble, repair, runkinds, sample
from openmmchaintree.command.arguments import Parser
from openmmchaintree.command.cli import runParsed
from openmmchaintree.notes import listFirst
from scenes import DIPEPTIDE, pdbLine, writePDB

PROTEIN = "amber14/protein.ff14SB.xml"
_PACKAGE = Path(openmmchaintree.__file__).parent
_OPTION = r"--[a-z][a-z-]*"


def _optionsOf(command):
    parser = Parser(add_help=False)
    command.addArguments(parser)
    return {option for action in parser._actions for option in action.option_strings}


def _namedOptions(path, pattern):
    """Return the options that texts of a module name, as a pattern finds them."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    texts = [node.value for node in nodes if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    return {option for text in texts for option in re.findall(pattern, text)}


def test_namedOptionsExist():
    """Modules of a command name options that it has; shared ones those of sample and clashes, or name the command."""
    options = {one.__name__.split(".")[-1]: _optionsOf(one) for one in (sample, clashes, ensemble, repair)}
    found = 0
    for path in sorted(_PACKAGE.rglob("*.py")):
        known = options["sample"] & options["clashes"]
        if _PACKAGE / "command" in path.parents:
            owners = [name for name in options if name.removesuffix("es") in path.name]
            known = options[owners[0] if owners else "sample"]
        named = _namedOptions(path, rf"{''.join(f'(?<!{name} )' for name in options)}{_OPTION}")
        assert named - {"--version", "--help"} <= known, path
        for name, ofCommand in options.items():
            assert _namedOptions(path, rf"{name} ({_OPTION})") <= ofCommand, path
        found += len(named)
    assert found > 40


@pytest.fixture
def runHere(runCommandHere, monkeypatch):
    """A function that samples without drawing pictures, which takes longer."""
    monkeypatch.setattr(runkinds, "savePicture", lambda *arguments: None)
    return lambda *arguments: runCommandHere("sample", *arguments)


# Values for options of which the advice names none.
_VALUES = {"--unknown-radius": ["0.2"], "--forcefield": [PROTEIN]}


def _followed(message):
    """Return the options that a message advises, with their values: the first one of two."""
    arguments = []
    for option, value in re.findall(rf'(?<! or )({_OPTION})( "[^"]*")?', message):
        arguments += [option, *([value.strip(' "')] if value else _VALUES.get(option, []))]
    return arguments


def _withHydroxyl():
    """A hydrogen on the oxygen of a peptide bond."""
    lines = list(DIPEPTIDE)
    carbon, oxygen = (next(line for line in lines if line[12:20] == f" {name}   ALA") for name in "CO")
    ends = [np.array([float(line[k : k + 8]) for k in (30, 38, 46)]) for line in (carbon, oxygen)]
    more = pdbLine(99, "HX", "ALA", "A", 2, *(ends[1] + 0.8 * (ends[1] - ends[0])))
    lines.insert(lines.index(oxygen) + 1, more)
    return lines


def _ligand(name, *elements):
    return [
        pdbLine(900 + i, element, name, "L", 1, 40 + 1.5 * i, 40, 40, record="HETATM", element=element)
        for i, element in enumerate(elements)
    ]


_CASES = {
    "a radius": (lambda: [*DIPEPTIDE, *_ligand("LIG", "B", "O")], [], "without a known radius (1): L:LIG 1 B, boron: "),
    "hydrogens": (
        lambda: [line for line in DIPEPTIDE if not line.endswith("H")],
        ["--forcefield", PROTEIN],
        "lack hydrogens (3): A:ACE 1; ",
    ),
    "other hydrogens": (_withHydroxyl, ["--forcefield", PROTEIN], "with hydrogens too many (1): A:ALA 2: "),
    "no ligand": (
        lambda: [*DIPEPTIDE, *_ligand("SO4", "S", "O")],
        ["--forcefield", PROTEIN],
        "that the force field does not have (1): L:SO4 1: ",
    ),
    "no ligands": (
        lambda: [*DIPEPTIDE, *(line for name in ("LIA", "LIB", "LIC", "2LD") for line in _ligand(name, "S", "O"))],
        ["--forcefield", PROTEIN],
        "that the force field does not have (4): L:LIA 1; ",
    ),
    "a force field": (lambda: DIPEPTIDE, ["--temperature", "300"], "--temperature needs "),
}


@pytest.mark.parametrize("case", _CASES)
def test_adviceHelps(runHere, tmp_path, case):
    makeLines, options, words = _CASES[case]
    writePDB(tmp_path / "structure.pdb", makeLines())
    options = ("structure.pdb", "--trials", 10, "--frames", 1, *options)
    refused = runHere(*options)
    assertRefused(refused, tmp_path, ["structure.pdb"], words)
    result = runHere(*options, *_followed(refused.stderr.split(words)[1]))
    assert result.returncode == 0, result.stderr


def test_manyResiduesThatLackHydrogens(runHere, tmp_path, villin):
    atoms = [atom for atom in villin.topology.atoms() if atom.element.symbol != "H"]
    places = [(n, atom.name, atom.residue.name, "A", atom.residue.id) for n, atom in enumerate(atoms)]
    lines = [pdbLine(*place, *(10 * villin.positions[atom.index])) for place, atom in zip(places, atoms, strict=True)]
    writePDB(tmp_path / "structure.pdb", lines)
    refused = runHere("structure.pdb", "--forcefield", PROTEIN)
    assertRefused(refused, tmp_path, ["structure.pdb"], "lack hydrogens (35): ", "--add-hydrogens adds them")


def test_nucleicAcidsThatAForceFieldOfProteinsDoesNotHave(runHere, tmp_path):
    names = [name for name in ("DA", "DC", "DG", "DT") for _ in range(2)]
    atoms = ("O5'", "C5'", "C4'", "C3'", "O3'")
    lines = [
        pdbLine(5 * n + k, atom, name, "A", n, 9.0 * n, 1.5 * k, 0)
        for n, name in enumerate(names)
        for k, atom in enumerate(atoms)
    ]
    writePDB(tmp_path / "structure.pdb", lines)
    refused = runHere("structure.pdb", "--forcefield", PROTEIN)
    assertRefused(refused, tmp_path, ["structure.pdb"], "does not have (8): ", "let --prepare replace them")


def test_residuesBoundToUnknownOnesAreNotNamed(runHere, tmp_path):
    """As in a glycoprotein: without the sugars, the amino acids fit."""
    lines = list(DIPEPTIDE)
    carbon, hydrogen = (next(line for line in lines if line[12:20].split() == [name, "ALA"]) for name in ("CB", "HB1"))
    ends = [np.array([float(line[k : k + 8]) for k in (30, 38, 46)]) for line in (carbon, hydrogen)]
    lines.remove(hydrogen)
    sugar = [
        pdbLine(99 + number, name, "NAG", "L", 1, *(ends[0] + far * (ends[1] - ends[0])), record="HETATM")
        for number, (name, far) in enumerate((("C1", 1.4), ("O5", 2.7)))
    ]
    writePDB(tmp_path / "structure.pdb", [*lines, "TER", *sugar, f"CONECT{carbon[6:11]}   99"])
    refused = runHere("structure.pdb", "--forcefield", PROTEIN)
    assertRefused(refused, tmp_path, ["structure.pdb"], "does not have (1): L:NAG 1: ", '--leave-out "resname NAG"')
    assert "bound to" not in refused.stderr


def test_existingFilesCanBeReplaced(runHere, tmp_path):
    names = [f"villin{ending}" for ending in ("-settings.toml", "-topology.pdb", ".dcd", ".png")]
    for name in names:
        (tmp_path / name).write_text("mine")
    refused = runHere("--trials", 10)
    words = "villin.dcd, villin-topology.pdb, villin.png, and 1 more: exist; --overwrite "
    assertRefused(refused, tmp_path, names, words)
    assert runHere("--trials", 10, *_followed(refused.stderr)).returncode == 0


def test_adviceOfTheLibrary(capsys):
    """It names calls, for which the command has options."""

    def run(options):
        raise openmm.OpenMMException("no agreement. Please report this; setNativeEnergies(False) lets OpenMM evaluate")

    parser = Parser()
    parser.set_defaults(run=run)
    assert runParsed(parser, []) == 2
    assert "this; --no-native-energies lets OpenMM evaluate" in capsys.readouterr().err


def test_withoutNativeEnergies(runHere, tmp_path):
    writePDB(tmp_path / "structure.pdb", DIPEPTIDE)
    options = ("structure.pdb", "--forcefield", PROTEIN, "--no-native-energies", "--trials", 20)
    options += ("--json", "summary.json")
    result = runHere(*options)
    assert result.returncode == 0, result.stderr
    energy = json.loads((tmp_path / "summary.json").read_text())["energy"]
    assert {force["kind"] for force in energy["forces"]} == {"foreign"}


@pytest.mark.parametrize(
    ("held", "kinds", "words"),
    [
        ("20 to 21", "phi", "since loops of one or two residues cannot be closed"),
        ("20 to 22", "phi", "add kinds of torsions"),
    ],
)
def test_adviceThatWasFollowedIsNotGiven(runHere, tmp_path, held, kinds, words):
    options = ("--fix", f"not resSeq {held}", "--close", "loops", "--trials", 10)
    refused = runHere(*options, "--torsions", kinds)
    assertRefused(refused, tmp_path, [], words)
    assert "(--close" not in refused.stderr


# A row of guanines of which there are but phosphorus atoms.
_BEADS = [pdbLine(i, "P", "G", "A", i, 6.0 * i, 0, 0) for i in range(1, 301)]


def _glycines(alpha, carbon):
    """Return glycines, each with these heights of its carbons above its N."""
    heights = {"N": 0.0, "CA": alpha, "C": carbon, "O": carbon + 1.2}
    places = [(number, name, height) for number in range(200) for name, height in heights.items()]
    return [pdbLine(1, name, "GLY", "A", number, 6.0 * number, height, 0) for number, name, height in places]


@pytest.mark.parametrize(
    ("content", "arguments", "words"),
    [
        (_BEADS, ["structure.pdb"], ["to sample: ", "A:G 1 is missing; ", "; and ", " more"]),
        (_BEADS, ["structure.pdb", *(f"{i}.pdb" for i in range(1000))], ["0.pdb, 1.pdb, 2.pdb, and 997 more"]),
        (_BEADS, ["structure.pdb", "--forcefield", "x" * 5000], ["--forcefield xxx", " … "]),
        (_glycines(0.0, 1.5), ["structure.pdb"], ["bonded atoms are at one place (", "; and 197 more)"]),
        (_glycines(9.0, 10.5), ["structure.pdb"], ["bonded atoms are far apart (", "; and 197 more)"]),
    ],
)
def test_refusalsAreShort(runHere, tmp_path, content, arguments, words):
    writePDB(tmp_path / "structure.pdb", content)
    assertRefused(runHere(*arguments), tmp_path, ["structure.pdb"], *words)


def test_firstOfMany():
    assert [listFirst("abcd"[:count]) for count in range(5)] == ["", "a", "a, b", "a, b, c", "a, b, c, and 1 more"]
    assert listFirst(map(str, range(2000)), "; ") == "0; 1; 2; and 1,997 more"
