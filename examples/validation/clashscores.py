"""Are clashscores those of the programs Reduce and Probe?

    python clashscores.py [--reduce FILE] [--probe FILE] STRUCTURE ...

Scores each STRUCTURE (PDB, plain or compressed by gzip) by the library, and by the programs `reduce` and `probe`, which
https://github.com/rlabduke has: without the hydrogens of the file, as MolProbity does, and without flips. Then scores
Reduce's hydrogens by the library, too.

Prints for the first model of each structure the clashes and the clashscore by the programs and by the library, the
share of the programs' pairs that the library has, and the share on Reduce's hydrogens. Exit status 1 if a clashscore
differs by more than 3% and 2 clashes.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import gemmi
from openmmchaintree import scoreClashes

REDUCE = ["-quiet", "-oh", "-his", "-flip", "-keep", "-allalt", "-limit120", "-pen9999"]
PROBE = ["-u", "-q", "-mc", "-het", "-once", "-NOVDWOUT", "ogt1 not water", "ogt1"]

Pair = frozenset[tuple[str, str, str]]


def output(*command: object) -> str:
    return subprocess.run([*map(str, command)], capture_output=True, text=True).stdout


def writeModel(path: Path, plain: Path) -> None:
    """Write the first model with names in their columns, and without segments, which the programs take for chains."""
    structure = gemmi.read_structure(str(path))
    while len(structure) > 1:
        del structure[1]
    for chain in structure[0]:
        for residue in chain:
            residue.segment = ""
    structure.write_pdb(str(plain))


def readAtom(text: str) -> tuple[str, str, str]:
    """Return the chain, the residue number with insertion code, and the name, of an atom as Probe writes it."""
    return text[:-14].strip(), text[-14:-9].replace(" ", ""), text[-5:-1].strip()


def readPairs(text: str) -> set[Pair]:
    """Return the pairs that clash in the raw output of Probe, and are no hydrogen bond."""
    clashes, bonds = set(), set()
    for line in text.splitlines():
        words = line.split(":")
        pair = frozenset((readAtom(words[3]), readAtom(words[4])))
        if words[2] == "hb":
            bonds.add(pair)
        elif float(words[6]) <= -0.4:
            clashes.add(pair)
    return clashes - bonds


def readCount(text: str) -> int:
    """Return the number of atoms that count in a PDB file with hydrogens."""
    lines = [line for line in text.splitlines() if line.startswith(("ATOM", "HETATM"))]
    return sum(line[17:20] != "HOH" and float(line[54:60] or 1) >= 0.02 for line in lines)


def scoreByLibrary(path: Path, keepHydrogens: bool) -> tuple[set[Pair], float]:
    score = scoreClashes(path, keepHydrogens=keepHydrogens)[0].molprobity
    assert score is not None
    pairs = {
        frozenset((atom.chain, atom.residue.split()[-1], atom.atom) for atom in (clash.atom1, clash.atom2))
        for clash in score.clashes
    }
    return pairs, score.clashscore


def share(found: set[Pair], expected: set[Pair]) -> str:
    return f"{100 * len(found & expected) / len(expected):.1f}" if expected else "–"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("structures", nargs="+", type=Path, metavar="STRUCTURE")
    parser.add_argument("--reduce", default="reduce")
    parser.add_argument("--probe", default="probe")
    options = parser.parse_args()
    isGood = True
    print(f"{'structure':24} {'programs':>16} {'library':>16} {'pairs %':>8} {'kept %':>7}")
    with tempfile.TemporaryDirectory() as folder:
        plain, bare, whole = (Path(folder) / name for name in ("plain.pdb", "bare.pdb", "whole.pdb"))
        for path in options.structures:
            writeModel(path, plain)
            bare.write_text(output(options.reduce, "-quiet", "-trim", "-allalt", plain))
            whole.write_text(output(options.reduce, *REDUCE, bare))
            expected = readPairs(output(options.probe, *PROBE, whole))
            score = 1000 * len(expected) / readCount(whole.read_text())
            own, ownScore = scoreByLibrary(plain, keepHydrogens=False)
            kept, _ = scoreByLibrary(whole, keepHydrogens=True)
            isGood &= abs(ownScore - score) <= 0.03 * score or abs(len(own) - len(expected)) <= 2
            counts = ((len(expected), score), (len(own), ownScore))
            programs, library = (f"{count:6d} {value:9.2f}" for count, value in counts)
            print(f"{path.name:24} {programs} {library} {share(own, expected):>8} {share(kept, expected):>7}")
    return 0 if isGood else 1


if __name__ == "__main__":
    sys.exit(main())
