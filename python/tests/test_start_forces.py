"""The note on strong forces at the start of a run."""

import numpy as np
import pytest
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.plan import Choice
from openmmchaintree.command.preparing.minimizing import minimizeStructure
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.command.startforces import noteOnForces


@pytest.fixture(scope="module")
def model():
    return EnergyModel(["amber14/protein.ff14SB.xml"], 300)


@pytest.fixture(scope="module")
def strained(villin):
    """Villin with an oxygen of GLU 31 at a hydrogen of another residue, and with a distorted bond in PHE 6."""
    places = {(atom.residue.id, atom.name): atom.index for atom in villin.topology.atoms()}
    positions = villin.positions.copy()
    positions[places["31", "OE1"]] = positions[places["10", "HA"]] + [0.05, 0, 0]
    positions[places["6", "CZ"]] += [0.1, 0, 0]
    return villin._replace(positions=positions)


def sample(structure, model, choice=Choice(hasEnergies=True)):  # noqa: B008 (a tuple)
    return Sampling(structure, 1, choice, model)


def test_aGoodStartHasNoNote(villin, model):
    assert noteOnForces(sample(villin, model), False) == []


def test_badContactsAndDistortedBondsAreNamed(strained, model):
    (note,) = noteOnForces(sample(strained, model), False)
    names = [item.rsplit(" ", 1)[0] for item in note.items]
    assert {"GLU 31 OE1", "PHE 10 HA", "PHE 6 CZ"} <= set(names)
    sizes = [float(item.rsplit(" ", 1)[1].replace(",", "")) for item in note.items]
    assert sizes == sorted(sizes, reverse=True) and sizes[-1] > 30000
    assert "which --minimize relaxes" in str(note)
    assert "although the energy was minimized" in str(noteOnForces(sample(strained, model), True)[0])


def test_minimizingRelaxesThem(strained, model):
    assert noteOnForces(sample(minimizeStructure(strained, model, None), model), True) == []


def test_fixedAtomsDoNotCount(strained, model):
    choice = Choice(hasEnergies=True, fix="not (resSeq 20 to 25 and sidechain)")
    sampling = sample(strained, model, choice)
    assert sampling.plan.fixed[np.array([a.residue.id in ("6", "10", "31") for a in strained.topology.atoms()])].all()
    assert noteOnForces(sampling, False) == []
