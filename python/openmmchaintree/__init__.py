"""openmm-chaintree: exact steric exclusion and torsion-space Monte Carlo for OpenMM.

`StericExclusionForce` and `TorsionMonteCarloIntegrator` are the plugin's classes. `createStericExclusionForce` and
`findTorsions` make a force from an `openmm.app.Topology`, `selectAtoms` chooses atoms of it, and `findClashes` searches
files for clashes. Numbers are in nm, rad, kJ/mol and K, or OpenMM Quantities; results are plain numbers and NumPy
arrays in these units.
"""

from openmmchaintree_forcefield import registerParser

from .loading import loadPlugin

loadPlugin()
registerParser()

from . import _build  # noqa: E402
from .bondlengths import setBondLengths  # noqa: E402
from .calvados import CalvadosSystem, createCalvadosSystem  # noqa: E402
from .clashes import Clash, FrameClashes, findClashes  # noqa: E402
from .clashscores import scoreClashes  # noqa: E402
from .coil import coilDensities, createCoilForce  # noqa: E402
from .defaultmoves import addDefaultMoves  # noqa: E402
from .densities import DrawnTorsions, ramachandranDensities, rotamerDensities  # noqa: E402
from .ensemble import Ensemble, sampleEnsemble  # noqa: E402
from .errors import InputError  # noqa: E402
from .loops import AnnealedLoops, LoopEnsemble, annealLoop, sampleLoop  # noqa: E402
from .missing import BuiltStructure, buildMissing  # noqa: E402
from .moveadder import AddedMove, AddedMoves  # noqa: E402
from .naming import AtomName  # noqa: E402
from .openmmchaintree import (  # noqa: E402
    EnergyPlan,
    GrownLoop,
    LoopGrowth,
    MinimumDistance,
    MoveStatistics,
    OuterStatistics,
    PlannedEnergy,
    StageStatistics,
    StericExclusionForce,
    TorsionDensity,
    TorsionMonteCarloIntegrator,
    TraversalStatistics,
)
from .ownclasses import registerClasses  # noqa: E402
from .repair import Repair, repairStructure  # noqa: E402
from .replicaexchange import ParallelReplicaExchangeSampler  # noqa: E402
from .reporter import ClashError, ClashReporter  # noqa: E402
from .samplereporter import SampleReporter  # noqa: E402
from .selection import selectAtoms  # noqa: E402
from .sterics import createStericExclusionForce  # noqa: E402
from .systemtopology import createTopology  # noqa: E402
from .torsions import LeftOutTorsion, Torsion, TorsionSearch, findTorsions  # noqa: E402

registerClasses()

__version__: str = _build.VERSION

__all__ = [
    "AddedMove",
    "AddedMoves",
    "AnnealedLoops",
    "AtomName",
    "BuiltStructure",
    "CalvadosSystem",
    "Clash",
    "ClashError",
    "ClashReporter",
    "DrawnTorsions",
    "EnergyPlan",
    "Ensemble",
    "FrameClashes",
    "GrownLoop",
    "InputError",
    "LeftOutTorsion",
    "LoopEnsemble",
    "LoopGrowth",
    "MinimumDistance",
    "MoveStatistics",
    "OuterStatistics",
    "ParallelReplicaExchangeSampler",
    "PlannedEnergy",
    "Repair",
    "SampleReporter",
    "StageStatistics",
    "StericExclusionForce",
    "Torsion",
    "TorsionDensity",
    "TorsionMonteCarloIntegrator",
    "TorsionSearch",
    "TraversalStatistics",
    "addDefaultMoves",
    "annealLoop",
    "buildMissing",
    "coilDensities",
    "createCalvadosSystem",
    "createCoilForce",
    "createStericExclusionForce",
    "createTopology",
    "findClashes",
    "findTorsions",
    "ramachandranDensities",
    "repairStructure",
    "rotamerDensities",
    "sampleEnsemble",
    "sampleLoop",
    "scoreClashes",
    "selectAtoms",
    "setBondLengths",
]
