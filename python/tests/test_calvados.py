"""Systems of CALVADOS against those made from the published formulas, and against energies by hand."""

import math

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import InputError, createCalvadosSystem, createStericExclusionForce
from publishedcalvados import RESIDUES, makeCalvados, serpentine

ALL = "MGSYRDFKAWELQTVNPHICGSRYGGFSDKRNGSYGGE"


def energyOf(system, positions):
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


class _Source:
    """A protein of Cα atoms and one more heavy atom a residue, as a structure with positions."""

    def __init__(self, sequence, positions):
        self.topology = app.Topology()
        chain, places = self.topology.addChain("A"), []
        for number, (letter, place) in enumerate(zip(sequence, positions, strict=True), 1):
            residue = self.topology.addResidue(RESIDUES[letter][0], chain, str(number))
            self.topology.addAtom("CA", app.element.carbon, residue)
            self.topology.addAtom("N", app.element.nitrogen, residue)
            places += [place, np.add(place, (0, 0, 0.1))]
        self.positions = np.reshape(places, (-1, 3)) * unit.nanometer


@pytest.mark.parametrize(("model", "version"), [("calvados2", 2), ("calvados3", 3)])
@pytest.mark.parametrize("ionicStrength", [0.05, 0.5])
def test_energiesAreThoseOfTheAuthors(model, version, ionicStrength):
    box = (11, 12, 13)
    topology, ours, positions = createCalvadosSystem(
        [ALL, ALL], 310, pH=30, ionicStrength=ionicStrength, model=model, box=box
    )  # histidine has no charge at this pH, as in the authors' table
    theirs = makeCalvados(ALL, 2, box, 310, ionicStrength, version)[1]
    places = positions + np.random.default_rng(version).normal(scale=0.05, size=positions.shape)
    assert energyOf(ours, places) == pytest.approx(energyOf(theirs, places), rel=1e-13)
    masses = [[system.getParticleMass(i) for i in range(2 * len(ALL))] for system in (ours, theirs)]
    assert masses[0] == masses[1] and topology.getNumBonds() == 2 * len(ALL) - 2


@pytest.mark.parametrize(("model", "version"), [("calvados2", 2), ("calvados3", 3)])
def test_domainsAreElasticNetworks(model, version):
    domain = range(5, 25)
    source = _Source(ALL, serpentine(len(ALL), 0.4))
    _, ours, positions = createCalvadosSystem(source, 293, pH=30, model=model, domains=[domain], box=(12, 12, 12))
    shift = 0 if version == 2 else 0.1 * 14.00672 / (14.00672 + 12.01078)  # to the centers of mass
    assert positions == pytest.approx(serpentine(len(ALL), 0.4) + [0, 0, shift], abs=1e-12)
    theirs = makeCalvados(ALL, 1, (12, 12, 12), version=version, domain=domain, positions=positions)[1]
    places = positions + np.random.default_rng(1).normal(scale=0.05, size=positions.shape)
    assert energyOf(ours, places) == pytest.approx(energyOf(theirs, places), rel=1e-13)


def test_twoBeadsByHand():
    # Lysine and phosphoserine, both termini, at 300 K: what the formulas of the papers give, in other units.
    distance, t, ionic, pH = 0.9, 300.0, 0.2, 6.2
    _, system, _ = createCalvadosSystem("KGB", t, pH, ionic)
    places = np.array([[0, 0, 0], [0.2, 0.3, 0], [distance, 0, 0]])
    bonds = sum(0.5 * 8033 * (math.dist(places[i], places[i + 1]) - 0.38) ** 2 for i in (0, 1))
    sigma, lam = (0.636 + 0.601) / 2, (0.179021173899 + 0.0925) / 2
    lennardJones = [4 * 0.8368 * ((sigma / r) ** 12 - (sigma / r) ** 6) for r in (distance, 2.0)]
    sticky = lam * (lennardJones[0] - lennardJones[1])
    permittivity = 5321 / t + 233.76 - 0.9297 * t + 1.417e-3 * t**2 - 8.292e-7 * t**3
    coulomb = 138.935458 / permittivity  # kJ nm/mol
    debye = math.sqrt(permittivity * 8.31446e-3 * t / (8 * math.pi * 138.935458 * ionic * 0.602214076))
    screened = [math.exp(-r / debye) / r for r in (distance, 4.0)]
    charges = (1 + 1) * (-2 + 1 / (1 + 10 ** (pH - 6.01)) - 1)
    expected = bonds + sticky + charges * coulomb * (screened[0] - screened[1])
    assert energyOf(system, places) == pytest.approx(expected, rel=1e-4)


def test_chargesFollowThePH():
    def chargesOf(sequence, pH):
        system = createCalvadosSystem(sequence, pH=pH).system
        return [system.getForce(1).getParticleParameters(i)[0] for i in range(len(sequence))]

    assert chargesOf("GHG", 6) == pytest.approx([1, 0.5, -1])
    assert chargesOf("GHG", 1)[1] == pytest.approx(1, abs=1e-4)
    assert chargesOf("GOG", 6.3)[1] == pytest.approx(-1.5)
    assert chargesOf("GBG", 7.5)[1] == pytest.approx(-1.968654940548496, abs=1e-9)  # of the authors' table
    assert chargesOf("GOG", 7.5)[1] == pytest.approx(-1.9406490568972323, abs=1e-9)
    assert chargesOf("KDEA", 7) == pytest.approx([2, -1, -1, -1])


def test_aBoxHoldsFoldedChainsWithoutOverlaps():
    sequences, box = [ALL * 3, ALL, "GS"], np.array([8.0, 9.0, 10.0])
    topology, system, positions = createCalvadosSystem(sequences, box=box)
    bonds = np.array([(one.index, two.index) for one, two in topology.bonds()])
    lengths = np.linalg.norm(positions[bonds[:, 0]] - positions[bonds[:, 1]], axis=1)
    assert lengths == pytest.approx(0.3825)
    apart = positions[:, np.newaxis] - positions
    apart -= box * np.rint(apart / box)
    distances = np.linalg.norm(apart, axis=2) + 9 * np.eye(len(positions))
    distances[bonds[:, 0], bonds[:, 1]] = distances[bonds[:, 1], bonds[:, 0]] = 9
    assert distances.min() > 0.53  # a bend; otherwise two bonds
    assert np.diag(
        [v.value_in_unit(unit.nanometer)[i] for i, v in enumerate(system.getDefaultPeriodicBoxVectors())]
    ) == (pytest.approx(np.diag(box)))
    force = createStericExclusionForce(topology, positions, system=system)
    assert force.usesPeriodicBoundaryConditions() and force.getNumBallJoints() == len(bonds)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"source": "ACX"}, "calvados2 has no residue X"),
        ({"source": "AB", "model": "calvados3"}, "calvados3 has no residue B"),
        ({"source": "AB", "model": "calvados"}, "there is no model 'calvados': choose one of calvados2, calvados3"),
        ({"source": ""}, "a sequence is empty"),
        ({"source": ["A", " "]}, "a sequence is empty"),
        ({"source": ["A", "C"]}, "several chains need a box"),
        ({"source": ["A" * 3000], "box": (8, 8, 8)}, "the box has no room for 3,000 residues"),
        ({"source": "A", "box": (7.9, 9, 9)}, "box must be three lengths of 8 nm"),
        ({"source": "A", "domains": [[0]]}, "domains need a structure"),
        ({"source": "A", "temperature": 0}, "temperature and ionicStrength must be above 0"),
        ({"source": _Source("AC", [(0, 0, 0), (0.6, 0, 0)])}, "chain A has a gap between residues 1 and 2"),
        ({"source": _Source("AC", [(0, 0, 0), (0.4, 0, 0)]), "domains": [[2]]}, "domains names residue 2"),
        ({"source": _Source("", [])}, "the structure has no amino acid"),
    ],
)
def test_errorsNameTheCulprit(arguments, message):
    with pytest.raises(InputError, match=message.replace("(", r"\(")):
        createCalvadosSystem(**arguments)
