"""Numbers with units are taken everywhere, and those of another dimension refused by name."""

import gc

import numpy as np
import openmm
import pytest
from openmm import unit
from openmmchaintree import StericExclusionForce, TorsionDensity, TorsionMonteCarloIntegrator
from openmmchaintree.units import inUnit, positionsInNm


def test_quantityIsConverted():
    assert inUnit(1.5 * unit.angstrom, "nm", "radius") == pytest.approx(0.15)
    assert inUnit(180 * unit.degrees, "rad", "maxAngle") == pytest.approx(np.pi)
    assert inUnit([1 * unit.angstrom, 2.0], "nm", "radii") == pytest.approx([0.1, 2.0])
    assert inUnit(np.array([1.0, 2.0]) * unit.angstrom, "nm", "radii") == pytest.approx([0.1, 0.2])


def test_plainNumberStays():
    assert inUnit(0.15, "nm", "radius") == 0.15


def test_otherDimensionIsRefused():
    with pytest.raises(TypeError, match=r"^radius must be a length \(nm\), but has the unit kcal/mol$"):
        inUnit(1 * unit.kilocalorie_per_mole, "nm", "radius")


def test_positionsOfOtherShapeAreRefused():
    with pytest.raises(ValueError, match=r"^positions must have the shape \(2, 3\), not \(3, 3\)$"):
        positionsInNm(np.zeros((3, 3)), 2)


def test_forceParameters():
    force = StericExclusionForce()
    force.addParticle(1.7 * unit.angstrom)
    force.addParticle(0.12, hydrogenBondRole=force.Donor)
    radius, role = force.getParticleParameters(0)
    assert radius.value_in_unit(unit.nanometer) == pytest.approx(0.17)
    assert role == force.NoHydrogenBond
    assert force.getParticleParameters(1)[1] == force.Donor
    force.setParticleParameters(0, 2 * unit.angstrom, force.Acceptor)
    radius, role = force.getParticleParameters(0)
    assert radius.value_in_unit(unit.nanometer) == pytest.approx(0.2)
    assert role == force.Acceptor
    force.setOverlapTolerance(0.5 * unit.angstrom)
    assert force.getOverlapTolerance().value_in_unit(unit.nanometer) == pytest.approx(0.05)
    force.setHydrogenBondAllowance(0.7 * unit.angstrom)
    assert force.getHydrogenBondAllowance().value_in_unit(unit.nanometer) == pytest.approx(0.07)
    force.setForceConstant(1 * unit.kilocalorie_per_mole / unit.angstrom**2)
    constant = force.getForceConstant().value_in_unit(unit.kilojoule_per_mole / unit.nanometer**2)
    assert constant == pytest.approx(418.4)


def test_integratorParameters():
    integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
    integrator.setTemperature(310 * unit.kelvin)
    assert integrator.getTemperature() == 310 * unit.kelvin
    assert integrator.computeSystemTemperature() == 310 * unit.kelvin
    assert integrator.addTorsionMove(1, 10 * unit.degrees, torsions=[0], count=1) == 0
    assert integrator.addTorsionMove(1, maxAngle=0.1, torsions=np.arange(3)) == 1
    assert integrator.addRigidBodyMove(1.0, 1 * unit.angstrom, 5 * unit.degrees, molecules=[0]) == 2
    assert integrator.addGroupMove(1, 1, 180 * unit.degrees, maxDistance=60 * unit.angstrom, molecules=None) == 3
    weight, translation, angle, distance, molecules = integrator.getGroupMoveParameters(3)
    assert (weight, molecules) == (1, None)
    assert (translation, angle, distance) == (1 * unit.nanometer, np.pi * unit.radian, 6 * unit.nanometer)
    integrator.setGroupMoveParameters(3, weight=2, maxTranslation=0.5, maxAngle=0, maxDistance=4, molecules=[0, 7])
    assert integrator.getMoveDescription(3) == "group within 4 nm ±0.5 nm ±0 rad (weight 2, 2 molecules to choose from)"


# A call with a unit that is wrong, and the parameter that it has to name. x is a force, i an integrator, c a Context.
_WRONG = [
    (lambda x, i, c: x.addParticle(1 * unit.kilocalorie_per_mole), "radius must be a length"),
    (lambda x, i, c: x.setParticleParameters(0, 1 * unit.degree), "radius must be a length"),
    (lambda x, i, c: x.setOverlapTolerance(1 * unit.kelvin), "tolerance must be a length"),
    (lambda x, i, c: x.setHydrogenBondAllowance(1 * unit.radian), "allowance must be a length"),
    (lambda x, i, c: x.setForceConstant(1 * unit.kilojoule_per_mole), "k must be a force constant"),
    (lambda x, i, c: x.getNeighborPairs(c, 1 * unit.nanometer**2), "cutoff must be a length"),
    (lambda x, i, c: x.getChangedNeighborPairs(c, 1 * unit.degree), "cutoff must be a length"),
    (lambda x, i, c: x.getClashesWith(c, [1, 2, 3] * unit.degrees, 0.1), "position must be a length"),
    (lambda x, i, c: x.getClashesWith(c, [1, 2, 3], 1 * unit.kelvin), "radius must be a length"),
    (lambda x, i, c: x.proposeTorsions(c, [0], [1] * unit.nanometers), "changes must be an angle"),
    (lambda x, i, c: x.proposeTorsions(c, [0], [1 * unit.nanometers]), "changes must be an angle"),
    (lambda x, i, c: x.proposeRigidMotion(c, 0, [0, 0, 1] * unit.nanometers, [0, 0, 0]), "rotation must be an angle"),
    (lambda x, i, c: x.proposeRigidMotion(c, 0, [0, 0, 1], [0, 0, 0] * unit.degrees), "translation must be a length"),
    (lambda x, i, c: i.setTemperature(1 * unit.kilojoule_per_mole), "temperature must be a temperature"),
    (lambda x, i, c: TorsionMonteCarloIntegrator(1 * unit.nanometer), "temperature must be a temperature"),
    (lambda x, i, c: i.addTorsionMove(1, 1 * unit.nanometer), "maxAngle must be an angle"),
    (lambda x, i, c: i.addTorsionMove(1 * unit.nanometer, 1), "weight must be a number"),
    (lambda x, i, c: i.addRigidBodyMove(1, 1 * unit.degree, 1), "maxTranslation must be a length"),
    (lambda x, i, c: i.addRigidBodyMove(1, 1, 1 * unit.angstrom), "maxAngle must be an angle"),
    (lambda x, i, c: i.addGroupMove(1, 1, 1, 1 * unit.degree), "maxDistance must be a length"),
    (lambda x, i, c: i.addClosedMove(1, 1 * unit.nanometer), "maxAngle must be an angle"),
    (lambda x, i, c: i.addClosedMove(1, 1, hop=1 * unit.degree), "hop must be a number"),
    (lambda x, i, c: i.setTorsionAngles(c, np.zeros(138) * unit.nanometer), "angles must be an angle"),
]


@pytest.mark.parametrize(("call", "message"), _WRONG, ids=[f"{i}-{wrong[1]}" for i, wrong in enumerate(_WRONG)])
def test_wrongUnitNamesTheParameter(villinRun, call, message):
    with pytest.raises(TypeError, match=message):
        call(*villinRun)


def test_whatIsNoNumberIsRefused():
    force = StericExclusionForce()
    with pytest.raises(TypeError, match="^radius must be a number, not str$"):
        force.addParticle("0.1")
    with pytest.raises(TypeError, match="^particle1 must be an integer, not float$"):
        force.addBond(0.5, 1)
    with pytest.raises(ValueError, match="^particle2 is out of the range of integers$"):
        force.addBond(0, 2**40)
    with pytest.raises(ValueError, match="^hydrogenBondRole must be NoHydrogenBond, Donor, Acceptor or"):
        force.addParticle(0.1, 4)


# ---- Lists that change while they are read ----


class Changing:
    """A number that empties its list when it is asked for its value."""

    def __init__(self, items, value):
        self.items = items
        self.value = value

    def empty(self):
        self.items.clear()
        gc.collect()
        return self.value

    __index__ = __float__ = empty


class ChangingSequence(Changing):
    def __len__(self):
        return 3

    def __getitem__(self, index):
        return float(range(3)[index]) + self.empty()


def changing(kind, value, others):
    items = []
    items += [kind(items, value), *others]
    return items


def test_listsThatChange():
    force = StericExclusionForce()
    system = openmm.System()
    for _ in range(4):
        system.addParticle(1)
        force.addParticle(0.1)
    for i in range(3):
        force.addBond(i, i + 1)
    force.addTorsion(0, 1, 2, 3)
    system.addForce(force)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions([[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1]])
    many = [10**6 + i for i in range(10_000)]
    with pytest.raises(openmm.OpenMMException, match="there is no particle 1000000"):
        force.getMinimumDistance(context, changing(Changing, 1, many), [0])
    assert force.getMinimumDistance(context, changing(Changing, 1, [2, 2]), [0]).distance == 1
    with pytest.raises(openmm.OpenMMException, match="10001 angles"):
        force.setTorsionAngles(context, changing(Changing, 0.5, [float(i) for i in many]))
    assert len(force.getClashesWith(context, changing(Changing, 1.0, [1e6 + 0.5, 1e6 + 1.5]), 0.1)[0]) == 0
    with pytest.raises(openmm.OpenMMException, match="1 ball joints, but 10001 rotations"):
        force.proposeBallRotations(context, [0], changing(ChangingSequence, 0, [[1.0, i, 3.0] for i in many]))

    integrator = TorsionMonteCarloIntegrator(300)
    density = TorsionDensity.fromTable([1, 2])
    integrator.addDrawnMove(1, changing(Changing, 1, [5, [7]]), density)
    assert integrator.getDrawnMoveParameters(0)[1] == [(1,), (5,), (7,)]
    integrator.addTorsionMove(1, 0.1, changing(Changing, 1, [5, 7]))
    assert list(integrator.getTorsionMoveParameters(1)[2]) == [1, 5, 7]
