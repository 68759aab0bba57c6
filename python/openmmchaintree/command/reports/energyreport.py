"""The energies of a run, as tables for people and as JSON for programs, in kJ/mol."""

from .tables import alignedLines, makeTable, percent


def describeEnergies(energies):
    """Return a line on the parts of Energies and which code evaluates them."""
    byKind = {}
    for entry in energies.plan:
        byKind.setdefault(entry.kind, []).append(entry.name)
    parts = [f"{kind} {', '.join(byKind[kind])}" for kind in ("native", "constant") if kind in byKind]
    if "foreign" in byKind:
        parts.append(f"{', '.join(byKind['foreign'])} by OpenMM, which takes much longer")
    return f"energy: {energies.model}; {'; '.join(parts)}"


def summarizeEnergies(energies, along, last, stages, positions):
    """Return a summary of the Energies of a run as plain dictionaries and lists.

    Parameters
    ----------
    energies : Energies
        at the end
    along : list of float
        U of the initial frame and the later ones, kJ/mol
    last : float
        U at the end, kJ/mol
    stages : list
        of the RunState
    positions : (n, 3) float64 array, nm, the last ones
    """
    outer = energies.outerTests()
    total, parts = energies.byOpenMM(positions)
    return {
        "forceField": energies.model.files,
        "temperature": energies.model.temperature,
        "nonbondedCutoff": energies.model.cutoff,
        "potentialEnergy": {
            "first": along[0],
            "mean": sum(along[1:]) / len(along[1:]) if len(along) > 1 else None,
            "last": last,
            "lastByOpenMM": total,
        },
        "potentialEnergies": along,
        "forces": parts,
        "stages": energies.describeStages(stages),
        "outerTests": None if outer is None else outer._asdict(),
    }


def printEnergies(summary, console):
    """Print the result of `summarizeEnergies` on a rich Console."""
    energy = summary["potentialEnergy"]
    mean = "" if energy["mean"] is None else f", {energy['mean']:,.1f} as the mean of later frames"
    console.print(
        f"U: {energy['first']:,.1f} kJ/mol at the start{mean}, {energy['last']:,.1f} at the end; OpenMM's Reference "
        f"platform differs there by {energy['last'] - energy['lastByOpenMM']:.1g}"
    )
    header, *lines = _forceLines(summary["forces"])
    console.print(header, style="bold")
    for line in lines:
        console.print(line)
    if summary["stages"]:
        console.print(_stageTable(summary["stages"]))
    outer = summary["outerTests"]
    if outer is not None:
        share = 100 * outer["accepted"] / outer["attempted"]
        console.print(
            f"outer tests: {outer['accepted']:,} of {outer['attempted']:,} kept their trials ({share:.0f} %), by "
            f"differences of {outer['meanDifference']:.1f} ± {outer['standardDeviation']:.1f} kJ/mol; "
            f"trials taken back, which are in no other count: {outer['trialsTakenBack']:,}"
        )


def _forceLines(forces):
    """Return a line for each Force, after a heading; reasons are long."""
    energies = ["–" if force["energy"] is None else f"{force['energy']:,.1f}" for force in forces]
    rows = [("force", "kJ/mol", "evaluated", "because")]
    rows += [
        (force["name"], energy, force["kind"], force["reason"]) for force, energy in zip(forces, energies, strict=True)
    ]
    return alignedLines(rows, (False, True, False, False))


def _stageTable(stages):
    table = makeTable(["decided by"], ["trials", "refused", "%"])
    for stage in stages:
        computed, refused = stage["computed"], stage["refused"]
        table.add_row(stage["stage"], f"{computed:,}", f"{refused:,}", percent(refused, computed))
    return table
