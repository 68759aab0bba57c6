"""Does the solver of closed windows find all closures and no others? Compared with brute force, on protein windows.

    python closures.py --program FILE [--windows 1250] [--steps 2000] [--seed 1] [STRUCTURE ...]

Draws WINDOWS windows of eight or nine torsions from each STRUCTURE (PDB; by default eight proteins in the folder that
CHAINTREE_TEST_DATA names, or the villin headpiece of OpenMM); in every second window the drivers turn by up to 16
degrees. The program `chaintree_closures`, which is built with the tests, solves each window twice: with the
library, and by brute force in long double, turning the first pivot through the circle in at least STEPS steps.

Prints the number of solutions; the missed and the invented ones, and correct ones that brute force does not know;
windows by their number of solutions; and times in microseconds. Exit status 1 if any was missed, invented or unknown.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from openmm import app, unit

ATOMS = ("N", "CA", "C")
LONGEST_BOND = 0.2  # nm

PARTS = ("microseconds", "percentile99", "worst")
PROTEINS = ("1crn", "1ctf", "1shg", "1ubi_h", "bpti_h", "5dfr_h", "3ptb", "1htb")


def findStructures():
    """Return the paths of the proteins found."""
    folder = os.environ.get("CHAINTREE_TEST_DATA")
    found = [Path(folder, f"{name}.pdb") for name in PROTEINS] if folder else []
    return [path for path in found if path.exists()] or [Path(app.__file__).parent / "data" / "test.pdb"]


def readBackbones(path):
    """Return the input of the program."""
    pdb = app.PDBFile(str(path))
    return describeBackbones(pdb.topology, np.array(pdb.positions.value_in_unit(unit.nanometer)))


def describeBackbones(topology, positions):
    """Return a line for each residue: where its atoms are, nm, and if phi and psi are free. Empty lines part chains."""
    lines, former = [], None
    for residue in topology.residues():
        places = {atom.name: positions[atom.index] for atom in residue.atoms()}
        if not set(ATOMS) <= places.keys():
            former = None
            continue
        backbone = np.array([places[name] for name in ATOMS])
        isBound = former is not None and np.linalg.norm(backbone[0] - former) < LONGEST_BOND
        if not isBound:
            lines.append("")
        phi = int(isBound and residue.name != "PRO")  # that of a proline is in a ring
        lines.append(" ".join([*(f"{x:.17g}" for x in backbone.ravel()), f"{phi} 1"]))
        former = backbone[2]
    return "\n".join(lines) + "\n"


def solve(options, path):
    """Return the program's results for a structure."""
    command = [options.program, options.windows, options.steps, options.seed]
    done = subprocess.run(list(map(str, command)), input=readBackbones(path), capture_output=True, text=True)
    *remarks, result = done.stdout.splitlines()
    if done.returncode not in (0, 1) or not result.startswith("{"):
        raise SystemExit(f"{path}: {done.stdout}{done.stderr}")
    for remark in remarks:
        print(f"{path.stem}: {remark}")
    return json.loads(result)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("structures", nargs="*", type=Path, metavar="STRUCTURE")
    parser.add_argument("--program", required=True, help="path of chaintree_closures, in the build folder")
    parser.add_argument("--windows", type=int, default=1250, help="windows per structure (default: %(default)s)")
    parser.add_argument("--steps", type=int, default=2000, help="steps of brute force (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="random seed (default: %(default)s)")
    options = parser.parse_args()
    names = ("solutions", "known", "missed", "invented", "unknown")
    total, counts = dict.fromkeys(names, 0), 0
    print(f"{'':10} {' '.join(f'{name:>9}' for name in names)}  {'all: median, 99 %, worst':>27} {'near':>20}")
    for path in options.structures or findStructures():
        found = solve(options, path)
        for name in names:
            total[name] += found[name]
        counts = counts + np.array(found["counts"])
        numbers = " ".join(f"{found[name]:9}" for name in names)
        times = [f"{found[kind][key]:6.2f}" for kind in ("all", "near") for key in PARTS]
        print(f"{path.stem:10} {numbers}  {' '.join(times)}", flush=True)
    print(f"{'all':10} {' '.join(f'{total[name]:9}' for name in names)}")
    print("windows by their number of solutions:", ", ".join(f"{i}: {n}" for i, n in enumerate(counts) if n))
    return int(total["missed"] > 0 or total["invented"] > 0 or total["unknown"] > 0)


if __name__ == "__main__":
    sys.exit(main())
