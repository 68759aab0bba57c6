"""Copies, pickles and XML of the force and the integrator, and what has lost its class on the way."""

import copy
import gc
import pickle
import subprocess
import sys

import openmm
import pytest
from openmm import unit
from openmmchaintree import StericExclusionForce, TorsionDensity, TorsionMonteCarloIntegrator
from openmmchaintree.ownclasses import registerClasses


def makeForce():
    force = StericExclusionForce()
    force.setForceGroup(7)
    force.setName("spheres")
    force.setOverlapTolerance(0.1 / 3)
    force.addParticle(0.17, StericExclusionForce.Donor)
    for _ in range(3):
        force.addParticle(1 / 3)
    for i in range(3):
        force.addBond(i, i + 1)
    force.addTorsion(0, 1, 2, 3)
    force.addExclusion(0, 2)
    return force


def makeIntegrator():
    integrator = TorsionMonteCarloIntegrator(310)
    integrator.setRandomNumberSeed(17)
    integrator.setIntegrationForceGroups({1, 3})
    integrator.setStericMode(integrator.Soft)
    integrator.addTorsionMove(0.5, 0.2, [4, 0], 2)
    integrator.addRigidBodyMove(2, 0.1, 0.3)
    integrator.addClosedMove(1, 0.2, hop=0.3)
    integrator.addDrawnMove(1, [3, (4,)], TorsionDensity.fromTable([1, 2, 0], floor=0.1))
    return integrator


def duplicates(original):
    yield copy.copy(original)
    yield copy.deepcopy(original)
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        yield pickle.loads(pickle.dumps(original, protocol))


def toXml(thing):
    return openmm.XmlSerializer.serialize(thing)


@pytest.mark.parametrize("make", [makeForce, makeIntegrator])
def test_duplicates(make):
    for duplicate in duplicates(make()):
        gc.collect()  # frees the original
        assert type(duplicate) is type(make())
        assert duplicate.thisown
        assert toXml(duplicate) == toXml(make())


def test_duplicatesAreApart():
    force = makeForce()
    for duplicate in duplicates(force):
        duplicate.setOverlapTolerance(0.25)
        duplicate.addParticle(0.1)
    assert toXml(force) == toXml(makeForce())


class NotedForce(StericExclusionForce):
    pass


def test_subclassesAndAttributes():
    force = NotedForce()
    force.note = ["kept"]
    force.itself = force
    for duplicate in duplicates(force):
        assert type(duplicate) is NotedForce
        assert duplicate.note == ["kept"]
    assert copy.copy(force).note is force.note
    deep = copy.deepcopy(force)
    assert deep.note is not force.note
    assert deep.itself is deep


# ---- Objects that come from OpenMM ----


def fromXml(original):
    return openmm.XmlSerializer.deserialize(toXml(original))


def bareFromXml(original):
    """As it comes where nobody looks at what OpenMM returns."""
    kind = "Force" if isinstance(original, openmm.Force) else "Integrator"
    return getattr(openmm.XmlSerializer, f"_deserialize{kind}")(toXml(original))


@pytest.mark.parametrize("make", [makeForce, makeIntegrator])
def test_ownClassFromXml(make):
    for found in (fromXml(make()), openmm.XmlSerializer.clone(make())):
        gc.collect()
        assert type(found) is type(make())
        assert found.thisown
        assert toXml(found) == toXml(make())


def test_ownClassFromOwners():
    for system in (makeSystem(), fromXml(makeSystem()), *duplicates(makeSystem())):
        assert [type(force) for force in system.getForces()] == [openmm.HarmonicBondForce, StericExclusionForce]
        assert not system.getForce(1).thisown
    compound = openmm.CompoundIntegrator()
    compound.addIntegrator(makeIntegrator())
    compound.addIntegrator(openmm.VerletIntegrator(0.001))
    for owner in (compound, fromXml(compound)):
        assert type(owner.getIntegrator(0)) is TorsionMonteCarloIntegrator
        assert type(owner.getIntegrator(1)) is openmm.VerletIntegrator
    collective = openmm.CustomCVForce("E")
    collective.addCollectiveVariable("E", makeForce())
    assert type(collective.getCollectiveVariable(0)) is StericExclusionForce


def test_methodsOfOpenMMAreThoseThatTheyWere():
    assert openmm.System.getForce.__name__ == "getForce"
    assert "writable reference" in openmm.System.getForce.__doc__
    with pytest.raises(openmm.OpenMMException, match="Index out of range"):
        openmm.System().getForce(3)
    with pytest.raises(ValueError, match="Invalid input string"):
        openmm.XmlSerializer.deserialize("no XML")
    before = openmm.System.getForce
    registerClasses()
    assert openmm.System.getForce is before


@pytest.mark.parametrize("make", [makeForce, makeIntegrator])
def test_castOfWhatIsOwned(make):
    cls = type(make())
    bare = bareFromXml(make())
    assert cls.isinstance(bare)
    assert type(bare) is not cls
    found = cls.cast(bare)
    assert found is bare and type(found) is cls
    assert found.thisown
    assert cls.cast(found) is found
    assert toXml(cls.cast(bareFromXml(make()))) == toXml(make())


def test_castForceGoesIntoSystem():
    system = openmm.System()
    system.addForce(StericExclusionForce.cast(bareFromXml(makeForce())))
    gc.collect()
    bare = system.getForce(0)
    assert StericExclusionForce.isinstance(bare)
    force = StericExclusionForce.cast(bare)
    assert not force.thisown
    force.setOverlapTolerance(0.125)
    assert StericExclusionForce.cast(system.getForce(0)).getOverlapTolerance() == 0.125 * unit.nanometer


def test_castFromCompoundIntegrator():
    compound = openmm.CompoundIntegrator()
    compound.addIntegrator(openmm.VerletIntegrator(0.001))
    compound.addIntegrator(makeIntegrator())
    for owner in (compound, copy.deepcopy(compound)):
        assert not TorsionMonteCarloIntegrator.isinstance(owner.getIntegrator(0))
        integrator = TorsionMonteCarloIntegrator.cast(owner.getIntegrator(1))
        assert integrator.getNumMoves() == 4
        assert not integrator.thisown


def test_castOfSomethingElse():
    with pytest.raises(openmm.OpenMMException, match="the object is not a StericExclusionForce"):
        StericExclusionForce.cast(openmm.HarmonicBondForce())
    with pytest.raises(openmm.OpenMMException, match="the object is not a TorsionMonteCarloIntegrator"):
        TorsionMonteCarloIntegrator.cast(openmm.VerletIntegrator(0.001))
    with pytest.raises(TypeError):
        StericExclusionForce.cast(openmm.VerletIntegrator(0.001))
    assert not StericExclusionForce.isinstance(openmm.HarmonicBondForce())


# ---- Systems ----


def makeSystem():
    system = openmm.System()
    for _ in range(4):
        system.addParticle(1)
    system.addForce(openmm.HarmonicBondForce())
    system.addForce(makeForce())
    return system


def test_systems():
    for duplicate in duplicates(makeSystem()):
        assert toXml(duplicate) == toXml(makeSystem())
        assert StericExclusionForce.isinstance(duplicate.getForce(1))


def test_freshProcess(tmp_path):
    path = tmp_path / "pickled"
    path.write_bytes(pickle.dumps((makeForce(), makeIntegrator(), makeSystem())))
    program = f"""
import pickle
import openmm, openmmchaintree
with open({str(path)!r}, "rb") as file:
    force, integrator, system = pickle.load(file)
assert type(force) is openmmchaintree.StericExclusionForce
assert integrator.getMoveType(1) == integrator.RigidBodyMove
assert openmmchaintree.StericExclusionForce.cast(system.getForce(1)).getName() == "spheres"
for thing in (force, integrator, system):
    print(openmm.XmlSerializer.serialize(thing))
"""
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    expected = [toXml(thing) for thing in (makeForce(), makeIntegrator(), makeSystem())]
    assert run.stdout.split() == " ".join(expected).split()


def test_unknownVersion():
    xml = toXml(makeForce()).replace('version="1"', 'version="4"')
    with pytest.raises(openmm.OpenMMException, match="reads only versions 1 to 3"):
        openmm.XmlSerializer.deserialize(xml)
