"""The stub says what SWIG's module is, in its documentation too, and a type checker finds mistakes by it."""

import ast
import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import openmmchaintree
import pytest
from openmmchaintree import openmmchaintree as wrapped

_PROJECT = Path(__file__).parents[2]
_PACKAGE = Path(wrapped.__file__).parent
_STUB = ast.parse((_PACKAGE / "openmmchaintree.pyi").read_text(encoding="utf-8"))
_STUBS = {node.name: node for node in _STUB.body if isinstance(node, ast.ClassDef)}
_CLASSES = ("LoopGrowth", "StericExclusionForce", "TorsionDensity", "TorsionMonteCarloIntegrator")
_NUMBERS = re.compile(r"^:type (\w+): .*(?:float|Quantity).*\n:param \1: ((?:.|\n(?!:))*)", re.MULTILINE)
_UNIT = re.compile(r"\b(nm|bar|radians|Kelvin|K|kJ/mol(?:/nm\^2)?)\b")
_TUPLES = (
    "TraversalStatistics",
    "MoveStatistics",
    "StageStatistics",
    "OuterStatistics",
    "PlannedEnergy",
    "MinimumDistance",
    "GrownLoop",
)
_LISTS = ("EnergyPlan",)

# A few lines of each kind. A type checker must reject the lines marked as wrong.
_PROGRAM = """
import numpy as np
import openmm
import openmm.app as app
from openmm import unit
from openmmchaintree import *

force = StericExclusionForce()
force.addParticle(0.1, force.Donor)
force.addParticle(radius=1 * unit.angstrom, hydrogenBondRole=StericExclusionForce.Acceptor)
force.addBond(0, "1")  # wrong
force.addTorsion(0, 1, 2)  # wrong
context: openmm.Context
pairs, overlaps = force.getClashes(context)
pairs.shape, overlaps.max()
pairs, before, after = force.getChangedNeighborPairs(context, 0.5)
pairs, before = force.getChangedNeighborPairs(context, 0.5)  # wrong
distance: float = force.getMinimumDistance(context, [0], np.array([1, 2])).distance
free: bool = force.proposeTorsions(context, [3], [0.1])
force.proposeTorsions(context, 3, [0.1])  # wrong
integrator = TorsionMonteCarloIntegrator(300 * unit.kelvin)
integrator.addTorsionMove(1, 0.1, [0, 1], count=2)
integrator.addTorsionMove(1, 0.1, count="all")  # wrong
integrator.setTorsionMoveParameters(0, 1, 0.1, torsions=None)
integrator.addClosedMove(1, 0.1, [0, 1], hop=0.5)
integrator.addClosedMove(1, 0.1, hop=[0.5])  # wrong
density = TorsionDensity.fromTable(np.ones((3, 4)), floor=0.1)
TorsionDensity.fromRotamers([1], [[60]] * unit.degrees, [[0.2]])  # wrong
integrator.addDrawnMove(1, [(0, 1)], density)
integrator.addDrawnMove(1, [0, 1], 0.5)  # wrong
integrator.setRigidBodyMoveParameters(1, 1, 0.1, 0.1, [0])
integrator.removeMove(1)
force.setTorsionAngles(context, -force.getTorsionAngles(context))
integrator.getMoveStatistics(0).accepted
integrator.getMoveStatistics(0).rejected  # wrong
integrator.setNativeEnergies(False)
integrator.setNativeEnergies("no")  # wrong
reason: str = integrator.getEnergyPlan(context)[0].reason
foreign = [entry.force for entry in integrator.getEnergyPlan(context) if entry.kind == "foreign"]
energy: float = integrator.getPotentialEnergy(context)
integrator.getStageStatistics()[0].rejected  # wrong
topology: app.Topology
createStericExclusionForce(topology, torsions="phi").addExclusion(0, 1)
createStericExclusionForce(topology, bondCutoff="3")  # wrong
kind: str = findTorsions(topology).torsions[0].kind
findTorsions(topology, selection="resSeq 10 to 20", fixed=lambda atom: atom.residue.chain.id == "B")
findTorsions(topology, selection=selectAtoms(topology, [1, 2])[:1], fixed=np.array([True, False]))
findTorsions(topology, selection=None, fixed=lambda: True)  # wrong
atom: str = findClashes("a.pdb", "a.dcd")[0].clashes[0].atom1.residue
findClashes("a.pdb", 3)  # wrong
ClashReporter("a.csv", 100, maxOverlap=0.1 * unit.nanometer)
ClashReporter("a.csv", "100")  # wrong
SampleReporter("a.csv", 100, reference=context.getState(positions=True).getPositions(asNumpy=True))
SampleReporter("a.csv", "100")  # wrong
"""


def methodsOf(stub):
    return {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}


def parametersOf(function):
    arguments = function.args
    names = [argument.arg for argument in arguments.args]
    required = len(names) - len(arguments.defaults)
    return {name: number >= required for number, name in enumerate(names) if name != "self"}


def parametersAtRunTime(method):
    """Return {name: whether it may be left out}: by the signature, or where SWIG has none by its docstring."""
    parameters = inspect.signature(method).parameters.values()
    if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
        return {one.name: one.default is not one.empty for one in parameters if one.name != "self"}
    described = re.findall(r":type (\w+): (.*)", method.__doc__)
    return {name: kind.endswith("optional") for name, kind in described if not kind.endswith("out")}


@pytest.mark.parametrize("name", _CLASSES)
def test_methodsAreThoseOfTheClass(name):
    public = {
        member for member in vars(getattr(wrapped, name)) if not member.startswith("_") and member not in ("thisown",)
    }
    constants = {node.target.id for node in _STUBS[name].body if isinstance(node, ast.AnnAssign)}
    assert public == (methodsOf(_STUBS[name]).keys() | constants) - {"__init__"}
    for constant in constants:
        assert isinstance(getattr(getattr(wrapped, name), constant), int)


@pytest.mark.parametrize("name", _CLASSES)
def test_parametersAreThoseOfTheMethods(name):
    for method, stub in methodsOf(_STUBS[name]).items():
        assert parametersOf(stub) == parametersAtRunTime(getattr(getattr(wrapped, name), method)), method


@pytest.mark.parametrize("name", _CLASSES)
def test_defaultsAreThoseOfTheHeader(name):
    header = (_PROJECT / "openmmapi" / "include" / "openmmchaintree" / f"{name}.h").read_text(encoding="utf-8")
    for method, stub in methodsOf(_STUBS[name]).items():
        names = [argument.arg for argument in stub.args.args]
        for parameter, default in zip(reversed(names), reversed(stub.args.defaults), strict=False):
            known = inspect.signature(getattr(getattr(wrapped, name), method)).parameters
            if parameter in known:  # written in Python
                expected = repr(known[parameter].default)
            else:
                declaration = rf"\b{method}\((?:[^;()]|\(\))*\b{parameter} = ([\w.:<>]+(?:\(\))?)"
                expected = re.search(declaration, header)[1]
            inPython = {"std::vector<int>()": "None", "true": "True"}.get(expected, expected)
            assert ast.unparse(default) == inPython, (method, parameter)


@pytest.mark.parametrize("name", _TUPLES)
def test_fieldsAreThoseOfTheTuple(name):
    fields = [node.target.id for node in _STUBS[name].body if isinstance(node, ast.AnnAssign)]
    assert tuple(fields) == getattr(wrapped, name)._fields


@pytest.mark.parametrize("name", (*_CLASSES, *_TUPLES, *_LISTS))
def test_documentationIsThatOfTheModule(name):
    documented = getattr(wrapped, name)
    assert ast.get_docstring(_STUBS[name]) == inspect.getdoc(documented)
    for method, stub in methodsOf(_STUBS[name]).items():
        assert ast.get_docstring(stub) == inspect.getdoc(getattr(documented, method)), method


@pytest.mark.parametrize("name", _CLASSES)
def test_everyNumberHasItsUnit(name):
    for method, stub in methodsOf(_STUBS[name]).items():
        text = ast.get_docstring(stub)
        for parameter, description in _NUMBERS.findall(text):
            # Weights, widths of logarithms, shares and factors are numbers without unit.
            assert parameter in (
                "weight",
                "width",
                "hop",
                "scale",
                "scales",
                "maxChange",
                "logWeight",
                "logDensity",
            ) or _UNIT.search(description), f"{method}: {parameter}"
        if ast.unparse(stub.returns) == "Quantity":
            assert _UNIT.search(text), method


def test_nothingIsMissing():
    assert set(_STUBS) == {*_CLASSES, *_TUPLES, *_LISTS}
    for name in openmmchaintree.__all__:
        member = getattr(openmmchaintree, name)
        assert not member.__module__.endswith(".openmmchaintree") or name in _STUBS


def mypy(folder, *arguments):
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", "--config-file", str(_PROJECT / "pyproject.toml"), *arguments]
    environment = {**os.environ, "MYPYPATH": str(_PACKAGE.parent)}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_mistakesAreFound(tmp_path):
    (tmp_path / "program.py").write_text(_PROGRAM)
    result = mypy(tmp_path, "--strict", "program.py")
    lines = [number for number, line in enumerate(_PROGRAM.splitlines(), start=1) if line.endswith("# wrong")]
    found = sorted({int(number) for number in re.findall(r"^program\.py:(\d+): error", result.stdout, re.MULTILINE)})
    assert found == lines and len(lines) == 16, result.stdout


def test_thePackageHasNoTypeErrors(tmp_path):
    assert (_PACKAGE / "py.typed").exists()
    result = mypy(tmp_path, "-p", "openmmchaintree")
    assert result.returncode == 0, result.stdout
