"""Scores by the definitions of other programs, as tables for people and as CSV and JSON for programs."""

import csv
import io
import math
from pathlib import Path

from ...notes import listFirst
from ...scoring.modelscores import AF3, MOLPROBITY, OWN, POSEBUSTERS
from ...scoring.parts import countByParts
from ..terminal import printable
from .clashreport import countClashes
from .noteoutput import printNotes
from .tables import alignedLines, makeTable

SCHEMA = "openmm-chaintree clash scores 1"

# The columns of CSV by definition, and those of all definitions.
_COLUMNS = {
    OWN: ("own_clashes", "own_per_1000_atoms"),
    MOLPROBITY: ("clashscore", "clashes", "atoms"),
    AF3: ("has_clash", "clashing_chains"),
    POSEBUSTERS: ("poses_pass", "poses", "pose_clashes"),
}
_FIRST_COLUMNS, _LAST_COLUMNS = ("file", "model"), ("broken_bonds", "pierced_rings", "error")


def plainScores(search, scores):
    """Return ClashScores of a ScoreSearch as plain dictionaries and lists, in nm."""
    names = search.names
    plain = {"model": scores.number}
    if scores.own is not None:
        clashes = scores.own.clashes
        plain[OWN] = {"per1000Atoms": scores.own.clashesPer1000Atoms, **_plainClashes(search, clashes)}
    if scores.molprobity is not None:
        score, atomCount, clashes, flipped = scores.molprobity
        plain[MOLPROBITY] = {"clashscore": score, "atoms": atomCount, "flipped": flipped}
        plain[MOLPROBITY] |= _plainClashes(search, clashes)
    if scores.chains is not None:
        hasClash = any(chain.hasClash for chain in scores.chains)
        plain[AF3] = {"hasClash": hasClash, "chains": [chain._asdict() for chain in scores.chains]}
    if scores.poses is not None:
        checks = [check._asdict() for check in scores.poses]
        for check in checks:
            check["leastDistance"] = check["leastDistance"] if math.isfinite(check["leastDistance"]) else None
        plain[POSEBUSTERS] = {"passes": all(check.passes for check in scores.poses), "checks": checks}
    plain["brokenBonds"] = [
        {"atoms": [str(names[bond.particle1]), str(names[bond.particle2])], **bond._asdict()}
        for bond in scores.brokenBonds
    ]
    plain["piercedRings"] = [
        {
            "ring": [str(names[atom]) for atom in pierced.ring],
            "atoms": [str(names[pierced.particle1]), str(names[pierced.particle2])],
            "particles": [pierced.particle1, pierced.particle2],
        }
        for pierced in scores.piercedRings
    ]
    return plain


def _plainClashes(search, clashes):
    counts = countByParts(search.topology, [clash[:2] for clash in clashes])
    return {
        "clashes": len(clashes),
        "chains": [{"chain": chain, "clashes": count} for chain, count in counts.chains.items()],
        "interfaces": [{"chains": list(pair), "clashes": count} for pair, count in counts.interfaces.items()],
        "ligands": [{"ligand": ligand, "clashes": count} for ligand, count in counts.ligands.items()],
        "pairs": [
            {
                "particle1": clash.particle1,
                "particle2": clash.particle2,
                "atom1": clash.atom1._asdict(),
                "atom2": clash.atom2._asdict(),
                "overlap": clash.overlap,
            }
            for clash in clashes
        ],
    }


def asCSV(files, definitions):
    """Yield CSV in pieces: a heading, and a line for each model of each file, or for its error.

    files : list of dict, with "file", and "models" or "error"
    """
    columns = [column for definition in _COLUMNS if definition in definitions for column in _COLUMNS[definition]]
    yield _asLines([[*_FIRST_COLUMNS, *columns, *_LAST_COLUMNS]])
    for file in files:
        name = printable(file["file"])
        yield _asLines(
            [
                name,
                model["model"],
                *_cells(model, definitions),
                len(model["brokenBonds"]),
                len(model["piercedRings"]),
                "",
            ]
            for model in file["models"]
        )
        if file["error"] is not None:
            yield _asLines([[name, "", *["" for _ in columns], "", "", printable(file["error"])]])


def _cells(model, definitions):
    """Return the cells of the definitions' columns."""
    cells = []
    if OWN in definitions:
        cells += [model[OWN]["clashes"], f"{model[OWN]['per1000Atoms']:.2f}"]
    if MOLPROBITY in definitions:
        score = model[MOLPROBITY]
        cells += [f"{score['clashscore']:.2f}", score["clashes"], score["atoms"]]
    if AF3 in definitions:
        cells += [_word(model[AF3]["hasClash"]), sum(chain["hasClash"] for chain in model[AF3]["chains"])]
    if POSEBUSTERS in definitions:
        checks = model[POSEBUSTERS]["checks"]
        cells += [_word(model[POSEBUSTERS]["passes"]), len({check["ligand"] for check in checks})]
        cells.append(sum(check["clashCount"] for check in checks))
    return cells


def _word(value):
    return "true" if value else "false"


def _asLines(rows):
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue()


def printFolder(files, definitions, console, rows):
    """Print the scores of the models of a folder on a rich Console, the highest clashscores first."""
    models = [(file["file"], model) for file in files for model in file["models"]]
    if MOLPROBITY in definitions:
        models.sort(key=lambda entry: entry[1][MOLPROBITY]["clashscore"], reverse=True)
    columns = [name for definition in _COLUMNS if definition in definitions for name in _COLUMNS[definition]]
    lines = [[name.replace("_", " ") for name in (*columns, *_LAST_COLUMNS[:2], "file")]]
    for name, model in models[:rows]:
        faults = len(model["brokenBonds"]), len(model["piercedRings"])
        lines.append([str(cell) for cell in (*_cells(model, definitions), *faults, Path(name).name)])
    console.print(f"{len(models):,} models of {len(files):,} files")
    for line in alignedLines(lines, [True] * (len(lines[0]) - 1) + [False]):
        console.print(line)
    if len(models) > rows:
        console.print(f"{len(models) - rows:,} more not shown")


def printScores(models, notes, console, rows, isVerbose):
    """Print the plain scores of a file on a rich Console; all notes if verbose."""
    printNotes(notes, console, isVerbose)
    for model in models[:rows]:
        if len(models) > 1:
            console.print(f"model {model['model']}")
        _printModel(model, console, rows)
    if len(models) > rows:
        console.print(f"{len(models) - rows:,} more models not shown")


def _printModel(model, console, rows):
    if OWN in model:
        own = model[OWN]
        console.print(f"own definition: {countClashes(own['clashes'])}, {own['per1000Atoms']:.1f} per 1,000 atoms")
    if MOLPROBITY in model:
        score = model[MOLPROBITY]
        console.print(
            f"MolProbity: clashscore {score['clashscore']:.2f}, {countClashes(score['clashes'])} of {score['atoms']:,} "
            "atoms with hydrogens"
        )
        if score["flipped"]:
            console.print(f"flipped: {listFirst(score['flipped'])}")
        _printParts(score, console, rows)
    if AF3 in model:
        clashing = [chain["chain"] for chain in model[AF3]["chains"] if chain["hasClash"]]
        console.print(f"AlphaFold 3: has_clash {_word(clashing)}{': chain ' if clashing else ''}{', '.join(clashing)}")
    if POSEBUSTERS in model:
        _printPoses(model[POSEBUSTERS], console, rows)
    for bond in model["brokenBonds"][:rows]:
        console.print(f"broken bond: {' – '.join(bond['atoms'])}, {bond['length']:.3f} nm")
    if len(model["brokenBonds"]) > rows:
        console.print(f"{len(model['brokenBonds']) - rows:,} more broken bonds not shown")
    for pierced in model["piercedRings"][:rows]:
        console.print(f"pierced ring: {' – '.join(pierced['atoms'])} through that of {pierced['ring'][0]}")


def _printParts(score, console, rows):
    parts = [(f"within chain {entry['chain']}", entry["clashes"]) for entry in score["chains"]]
    parts += [(f"between {' and '.join(entry['chains'])}", entry["clashes"]) for entry in score["interfaces"]]
    parts += [(f"of {entry['ligand']}", entry["clashes"]) for entry in score["ligands"]]
    if len(parts) > 1:
        console.print(", ".join(f"{count:,} {part}" for part, count in parts[:rows]))
    pairs = sorted(score["pairs"], key=lambda pair: pair["overlap"], reverse=True)
    if pairs:
        table = makeTable([], ["overlap (nm)"], ["between", "and"])
        for pair in pairs[:rows]:
            table.add_row(f"{pair['overlap']:.4f}", *(_nameAtom(pair[end]) for end in ("atom1", "atom2")))
        console.print(table)


def _nameAtom(plain):
    return (
        f"{plain['chain']}:{plain['residue']} {plain['atom']}"
        if plain["chain"]
        else f"{plain['residue']} {plain['atom']}"
    )


def _printPoses(poses, console, rows):
    if not poses["checks"]:
        console.print("PoseBusters: there is no ligand")
        return
    console.print(f"PoseBusters: ligands {'pass' if poses['passes'] else 'fail'}")
    for check in [check for check in poses["checks"] if not check["passes"]][:rows]:
        clashes, volume = countClashes(check["clashCount"]), f"{100 * check['volumeOverlap']:.1f}%"
        console.print(f"{check['ligand']} beside {check['other']}: {clashes}, {volume} of its volume overlaps")
