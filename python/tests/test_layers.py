"""Which module may import which: the command, replicas, ensembles, statistics, scoring, structures, and the core."""

import ast
import re
import subprocess
import sys
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

import openmmchaintree
import pytest
from openmmchaintree.errors import InputError
from openmmchaintree.structures.trajectory import Trajectory

_PACKAGE = Path(openmmchaintree.__file__).parent

# From the bottom up. The core is all modules that lie in no folder.
_LAYERS = ("", "structures", "scoring", "repairs", "building", "statistics", "ensembles", "replicas", "command")
_MODULES = {
    path: ".".join(path.relative_to(_PACKAGE).with_suffix("").parts)
    for path in _PACKAGE.rglob("*.py")
    if path.name not in ("__init__.py", "__main__.py", "openmmchaintree.py") or path.parent != _PACKAGE
}

# Public calls of the core that need an extra import its modules when they are called.
_LATE = {
    ("clashes", "structures.clashsearch"),
    ("clashscores", "scoring.modelscores"),
    ("ensemble", "ensembles.beadrun"),
    ("ensemble", "ensembles.chainshape"),  # for annotations
    ("ensemble", "ensembles.coilrun"),
    ("ensemble", "ensembles.coilscene"),
    ("ensemble", "statistics.estimates"),
    ("missing", "building.coildraws"),
    ("missing", "building.missingresidues"),
    ("missing", "structures.structure"),
    ("repair", "repairs.run"),
    ("repair", "repairs.causes"),  # for annotations
    ("repair", "repairs.changes"),
    ("repair", "scoring.protonation"),
    ("loops", "ensembles.loopannealing"),
    ("loops", "ensembles.looprun"),
}

# Packages that the core may import: always, and where one module says in one sentence what is missing.
_NEEDED = {"openmm", "numpy", "openmmchaintree_forcefield", *sys.stdlib_module_names}
_OPTIONAL = {("openmmtoolsmove", "openmmtools")}

_BLOCKED = (
    "biotite", "dask", "distributed", "gemmi", "matplotlib", "mdtraj", "msgpack", "pymbar", "rich", "scipy",
    "tomli", "tomli_w",
)  # fmt: skip


def layerOf(module):
    return _LAYERS.index(module.split(".")[0]) if module.split(".")[0] in _LAYERS else 0


def importsOf(path, module):
    """Return the modules of the package, by their names in it, and the names of other packages that a file imports."""
    own, others = set(), set()
    names = module.split(".")
    package = names[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            others |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            others.add(node.module.split(".")[0])
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) + 1 - node.level]
            if node.module is None:
                own |= {".".join([*base, alias.name]) for alias in node.names}
            else:
                own.add(".".join([*base, node.module]))
    return own, others


@pytest.mark.parametrize("path", _MODULES, ids=_MODULES.values())
def test_importsGoDownwards(path):
    module = _MODULES[path]
    own, _ = importsOf(path, module)
    upwards = {other for other in own if layerOf(other) > layerOf(module) and (module, other) not in _LATE}
    assert not upwards


@pytest.mark.parametrize("module", [module for module in _MODULES.values() if layerOf(module) == 0])
def test_theCoreNeedsOnlyOpenMMAndNumPy(module):
    _, others = importsOf(_PACKAGE / f"{module}.py", module)
    assert not {other for other in others - _NEEDED if (module, other) not in _OPTIONAL}


def runWithout(packages, program, tmp_path):
    """Run a program in a Python in which some packages cannot be imported."""
    blocking = f"""
import sys
class Blocker:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {packages!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Blocker())
"""
    return subprocess.run([sys.executable, "-c", blocking + program], cwd=tmp_path, capture_output=True, text=True)


_CORE = """
import io
import numpy as np
import openmm
from openmm import app, unit
from openmmchaintree import *

villin = app.PDBFile(app.__path__[0] + "/data/test.pdb")
modeller = app.Modeller(villin.topology, villin.positions)
modeller.delete([residue for residue in villin.topology.residues() if residue.name in ("HOH", "Cl")])
topology, positions = modeller.topology, modeller.positions
system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(topology)
system.addForce(createStericExclusionForce(topology, positions, system=system))
force = StericExclusionForce.cast(system.getForce(system.getNumForces() - 1))
selectAtoms(topology, lambda atom: atom.name == "CA")
rotamerDensities(topology, force), ramachandranDensities(topology, force)
integrator = TorsionMonteCarloIntegrator(300)
print(addDefaultMoves(integrator, topology, system))
integrator.setTrialsPerStep(20)
simulation = app.Simulation(topology, system, integrator, openmm.Platform.getPlatformByName("Reference"))
simulation.context.setPositions(positions)
lines = io.StringIO()
simulation.reporters.append(ClashReporter(lines, 1))
simulation.step(2)
assert len(lines.getvalue().splitlines()) == 3
pairs, overlaps = force.getClashes(simulation.context)

# A reporter that makes the force itself finds bonds and clashes.
bare = openmm.System()
for _ in topology.atoms():
    bare.addParticle(1)
simulation = app.Simulation(topology, bare, openmm.VerletIntegrator(0.001))
simulation.context.setPositions(positions)
simulation.reporters.append(ClashReporter(lines, 1))
simulation.step(1)
createTopology(bare, elements=["C"] * topology.getNumAtoms(), bonds=[])

# So does the distance of atoms, with images.
from openmmchaintree.covalent import bondedPairs
from openmmchaintree.imageclashes import noteOnImages
from openmmchaintree.naming import nameAtom
inNm = positions.value_in_unit(unit.nanometer)
inNm = np.array([[v.x, v.y, v.z] for v in inNm])
assert len(bondedPairs(inNm, np.array([a.element.atomic_number for a in topology.atoms()]))) > 500
assert noteOnImages(force, inNm, np.eye(3), [nameAtom(atom) for atom in topology.atoms()]).items
"""


def test_theCoreRunsWithOpenMMAndNumPyAlone(tmp_path):
    result = runWithout(_BLOCKED, _CORE, tmp_path)
    assert result.returncode == 0, result.stderr
    assert "side chains from rotamer to rotamer" in result.stdout


@pytest.mark.parametrize(
    "package, call, reason",
    [
        ("gemmi", "findClashes('x.pdb')", "reading structure files needs gemmi"),
        ("mdtraj", "selectAtoms(app.PDBFile(villin).topology, 'name CA')", "a selection by text needs mdtraj"),
        ("biotite", "templateBonds('HEM', ['FE', 'NA'])", "finding the bonds of HEM, which its Topology lacks, needs"),
    ],
)
def test_aMissingPackageIsNamed(tmp_path, package, call, reason):
    program = (
        "from openmm import app\nfrom openmmchaintree import *\nfrom openmmchaintree.templates import templateBonds\n"
        f"villin = app.__path__[0] + '/data/test.pdb'\n{call}\n"
    )
    result = runWithout((package,), program, tmp_path)
    (*_, message) = result.stderr.splitlines()
    assert message.startswith(f"ImportError: {reason}")
    assert message.endswith(f"(No module named '{package}'): pip install 'openmm-chaintree[tools]'")


@pytest.mark.parametrize(
    "package, words, needing",
    [
        ("gemmi", "sample", "reading structure files"),
        ("rich", "sample", "the command"),
        ("matplotlib", "clashes --picture a.png", "the command"),
    ],
)
def test_theCommandNamesAMissingPackage(tmp_path, package, words, needing):
    program = f"from openmmchaintree_command import main; sys.argv[1:] = {words.split()!r}; sys.exit(main())"
    result = runWithout((package,), program, tmp_path)
    assert result.returncode == 2
    assert result.stderr == (
        f"openmm-chaintree: {needing} needs {package}, which cannot be imported (No module named '{package}'): "
        "pip install 'openmm-chaintree[tools]'\n"
    )


def test_aTrajectoryWithoutMDTraj(tmp_path, monkeypatch):
    (tmp_path / "a.dcd").write_bytes(b"a trajectory")
    monkeypatch.setitem(sys.modules, "mdtraj", None)
    with pytest.raises(InputError, match=r"a\.dcd: reading trajectories needs mdtraj, .*'openmm-chaintree\[tools\]'$"):
        Trajectory(tmp_path / "a.dcd")


def requirements(table, names):
    """Return the requirements in some lists of a table of pyproject.toml, without the inclusion of other lists."""
    listed = [entry for name in names for entry in table[name] if isinstance(entry, str)]
    return {entry for entry in listed if not entry.startswith("openmm-chaintree[")}


def test_anExtraHasEachPackage():
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    extras = requirements(project["project"]["optional-dependencies"], ("tools", "report", "poses", "cluster"))
    assert extras <= requirements(project["dependency-groups"], ("tools",))
    assert project["tool"]["scikit-build"]["metadata"]["dependencies"]["others"] == ["numpy"]
    names = {re.match("[A-Za-z0-9-]+", entry)[0].lower().replace("-", "_") for entry in extras}
    imported = set()
    for path, module in _MODULES.items():
        imported |= importsOf(path, module)[1] | set(re.findall(r'importExtra\(\s*"(\w+)', path.read_text()))
    assert imported - _NEEDED - {package for _, package in _OPTIONAL} == names
