"""Which rows the benchmark has."""

from typing import NamedTuple

from .interface import ForceRow, PairRow
from .platforms import CPU, whyNot
from .program import Contestant
from .proteins import Model, ProteinModels
from .pythonrace import PythonRace
from .races import (
    FULL_GRID,
    INSTRUCTION_SETS,
    LAZY_GRID,
    OURS,
    SIMD_GRID,
    VERLET,
    Chain,
    EngineRace,
    Moves,
    Question,
    Race,
)
from .rivals import RIVALS
from .steps import RESIDUES, NeedRow, PartRow

# What a user can ask for, in the order in which it runs.
GROUPS = {
    "figures": "The paper's figures 7 and 8 and its table 1",
    "chains": "Compact chains, one torsion a trial",
    "large": "Large chains, one torsion a trial",
    "proteins": "Proteins, one torsion of the backbone a trial",
    "windows": "Eight consecutive torsions of the backbone a trial",
    "sidechains": "One torsion of a side chain a trial",
    "positions": "All positions read after each accepted trial",
    "worst": "Whole chains of the paper's figure 6",
    "simd": "The engine's instruction sets",
    "ways": "The engine's ways of testing trials",
    "calls": "Our calls from Python",
    "python": "Our calls from Python, and what one could call instead",
    "needs": "Waters of radius 0, atoms far away, all but 12 residues at rest, in steps of 10,000 trials",
    "forces": "Energy and forces",
    "pairs": "Pairs within 0.8 nm",
    "nearest": "Least distance to 1,000 obstacles",
}

# The others are of chains that the program makes.
WITH_PROTEINS = {*GROUPS} - {"chains", "large", "worst"}

_UNIFORM, _FIVE_DEGREES, _ONE_DEGREE = Moves("uniform"), Moves("gaussian", 5.0), Moves("gaussian", 1.0)
_SIDE_CHAIN = Moves("sidechain")
_WINDOW = 8
_WINDOWS = Moves("biased", 5.0, _WINDOW), Moves("biased", 1.0, _WINDOW)

_GRIDS_AND_OURS = (FULL_GRID, LAZY_GRID, SIMD_GRID, VERLET, OURS)
_WITHOUT_FULL_GRID = (LAZY_GRID, SIMD_GRID, VERLET, OURS)
_TOO_SLOW = "brute"  # all pairs take longer than anybody would wait

# Who of the figures' contestants races on each chain; the others race on the first.
_OF_EACH_CHAIN = (*_GRIDS_AND_OURS, "published", "improved")

_SIZES = (1000, 2500, 5000, 10000)
_WORST_SIZES = (648, 3000, 8232, 17496, 31944)
_QUICK_SIZE = 1000

# How the engine can test trials, if it is not left to choose.
CHOSEN, WAYS = "chosen", ("tree", "boxes", "clearances")

_LARGE = 100000
_LARGEST = 1000000  # there, the full grid would take all the time

# Trials of each chain of a row. All contestants of a row run as many, however long they take.
PAPER_TRIALS = 20000  # the paper's number
_TRIALS = 4000  # with five chains as many together as the paper's
_LARGE_TRIALS = 500
_LARGE_BLOCK = 100  # of trials that take milliseconds
_PYTHON_TRIALS = 400
_QUESTIONS = 50
_WORST_QUESTIONS = 5


class Plan(NamedTuple):
    """What shall run.

    groups : list of str, of GROUPS
    contestants : list of Contestant, the program's
    chosen : list of str, or None for the usual contestants of each group
    proteins : list of ProteinModels
    isQuick : bool, only what is small
    """

    groups: list[str]
    contestants: list[Contestant]
    chosen: list[str] | None
    proteins: list[ProteinModels]
    isQuick: bool

    def makeRows(self):
        """Return the rows, and what is skipped with the reason for each, as pairs of str.

        Raises
        ------
        InputError
            if an element of a protein has no radius
        """
        rows, skipped = [], []
        for group in GROUPS:
            if group in self.groups:
                for row in _MAKERS[group](self, group):
                    reason = _whyNot(row)
                    if reason is None:
                        rows.append(row)
                    else:
                        skipped.append((f"{group}: {row}", reason))
        if "python" in self.groups:
            skipped += [(rival.name, whyNot(rival.requirement)) for rival in RIVALS]
        if "forces" in self.groups:
            skipped.append(("forces on the CPU platform", whyNot(CPU)))
        if "pairs" in self.groups:
            skipped.append(("SciPy's pairs", whyNot("scipy")))
        return rows, [entry for entry in skipped if entry[1] is not None]

    def pick(self, *usual):
        """Return the names of those who run trials: of the usual ones, or of those that are chosen."""
        return self._pick("trials", usual)

    def pickAll(self, measure, isAble=lambda contestant: contestant.name != _TOO_SLOW):
        """Return the names of those who take part in a measure, and by default are fast enough."""
        able = [contestant.name for contestant in self.contestants if isAble(contestant)]
        return self._pick(measure, able)

    def _pick(self, measure, usual):
        names = [contestant.name for contestant in self.contestants if contestant.measure == measure]
        return [name for name in names if name in (usual if self.chosen is None else self.chosen)]

    def largest(self):
        """Return the Model of heavy atoms with most of them."""
        return max((protein.heavyAtoms for protein in self.proteins), key=_sizeOf)

    def sizes(self, *sizes):
        """Return those of some sizes of chains that are wanted."""
        return [size for size in sizes if not self.isQuick or size <= _QUICK_SIZE]


def _chains(plan, group):
    for size in plan.sizes(*_SIZES):
        yield Race(group, Chain("random", size), _UNIFORM, _TRIALS, plan.pick(*_GRIDS_AND_OURS))
    small = (_FIVE_DEGREES, _ONE_DEGREE)
    for kind, kinds in (("random", small), ("hilbert", (_UNIFORM, *small)), ("serpentine", (_UNIFORM, *small))):
        for size in plan.sizes(_SIZES[0], _SIZES[-1]):
            for moves in kinds:
                yield Race(group, Chain(kind, size), moves, _TRIALS, plan.pick(*_GRIDS_AND_OURS))


def _large(plan, group):
    for kind, moves in (("hilbert", _UNIFORM), ("serpentine", _ONE_DEGREE)):
        for size in plan.sizes(_SIZES[-1], _LARGE):
            names = plan.pick(*_GRIDS_AND_OURS)
            yield Race(group, Chain(kind, size), moves, _LARGE_TRIALS, names, block=_LARGE_BLOCK)
        for size in plan.sizes(_LARGEST):
            names = plan.pick(*_WITHOUT_FULL_GRID)
            yield Race(group, Chain(kind, size), moves, _LARGE_TRIALS, names, block=_LARGE_BLOCK, mostChains=1)


def _figures(plan, group):
    names = plan.pickAll("trials")
    fast = [name for name in names if name in _OF_EACH_CHAIN]
    slow = [name for name in names if name not in _OF_EACH_CHAIN]
    chains = [Chain("random", size) for size in plan.sizes(*_SIZES)]
    for chain in (*chains, *(protein.backbone for protein in plan.proteins)):
        yield Race(group, chain, _UNIFORM, PAPER_TRIALS, fast or slow, slow if fast else ())


def _proteins(plan, group):
    for protein in plan.proteins:
        for model in protein.withSideChains():
            for moves in (_UNIFORM, _FIVE_DEGREES, _ONE_DEGREE):
                yield Race(group, model, moves, _TRIALS, plan.pick(*_GRIDS_AND_OURS))


def _windows(plan, group):
    for protein in plan.proteins:
        for moves in _WINDOWS:
            yield Race(group, protein.heavyAtoms, moves, _TRIALS, plan.pick(*_WITHOUT_FULL_GRID))
    for size in plan.sizes(_SIZES[0], _SIZES[-1]):
        yield Race(group, Chain("random", size), _WINDOWS[-1], _TRIALS, plan.pick(*_WITHOUT_FULL_GRID))


def _sideChains(plan, group):
    for protein in plan.proteins:
        yield Race(group, protein.heavyAtoms, _SIDE_CHAIN, _TRIALS, plan.pick(*_WITHOUT_FULL_GRID))


def _positions(plan, group):
    chains = [Chain("random", size) for size in plan.sizes(_SIZES[0], _SIZES[-1])]
    for chain in (*chains, plan.largest()):
        for moves in (_UNIFORM, _ONE_DEGREE):
            yield Race(group, chain, moves, _TRIALS, plan.pick(*_WITHOUT_FULL_GRID), readsPositions=True)


def _worst(plan, group):
    whole = {contestant.name for contestant in plan.contestants if contestant.testsWholeChains}
    contestants = [name for name in plan.pickAll("trials") if name in whole]
    for size in plan.sizes(*_WORST_SIZES):
        yield Question(group, "whole", Chain("worst", size), _WORST_QUESTIONS, contestants, mostChains=1)


def _instructionSets(plan, group):
    return _engine(plan, group, "CHAINTREE_SIMD", {name: name for name in INSTRUCTION_SETS})


def _ways(plan, group):
    return _engine(plan, group, "CHAINTREE_TRIALS", {CHOSEN: "", **{name: name for name in WAYS}})


def _engine(plan, group, variable, settings):
    for size in plan.sizes(_SIZES[0], _SIZES[-1]):
        for kind, moves in (
            ("random", _UNIFORM),
            ("random", _FIVE_DEGREES),
            ("random", _ONE_DEGREE),
            ("hilbert", _ONE_DEGREE),
            ("serpentine", _ONE_DEGREE),
            ("random", _WINDOWS[-1]),
        ):
            yield EngineRace(group, Chain(kind, size), moves, _TRIALS, variable, settings)
    for moves in (_UNIFORM, _ONE_DEGREE, *_WINDOWS, _SIDE_CHAIN):
        yield EngineRace(group, plan.largest(), moves, _TRIALS, variable, settings)


def _calls(plan, group):
    return _fromPython(plan, group, _TRIALS, False)


def _python(plan, group):
    return _fromPython(plan, group, _PYTHON_TRIALS, True)


def _fromPython(plan, group, trials, withRivals):
    models = [protein.withSideChains()[-1] for protein in plan.proteins]
    withHydrogens = [model for model in models if model.protein.hasHydrogens]
    yield PythonRace(group, max(withHydrogens or models, key=_sizeOf), _UNIFORM, trials, withRivals)
    yield PythonRace(group, Chain("random", plan.sizes(*_SIZES)[-1]), _UNIFORM, trials, withRivals)


def _needs(plan, group):
    yield NeedRow(group, plan.largest(), PAPER_TRIALS)
    yield PartRow(group, plan.largest(), PAPER_TRIALS)


def _forces(plan, group):
    for protein in plan.proteins:
        if protein.protein.hasHydrogens:
            yield ForceRow(group, protein.protein, _QUESTIONS)


def _pairs(plan, group):
    for protein in plan.proteins:
        yield PairRow(group, protein.heavyAtoms, _QUESTIONS, plan.pickAll("pairs"))


def _nearest(plan, group):
    contestants = plan.pickAll("nearest", lambda contestant: True)
    for protein in plan.proteins:
        yield Question(group, "nearest", protein.heavyAtoms, _QUESTIONS, contestants)
    for size in plan.sizes(_SIZES[0], _SIZES[-1], _LARGE):
        yield Question(group, "nearest", Chain("hilbert", size), _QUESTIONS, contestants)


def _sizeOf(model):
    return len(model.scene.spheres)


_MAKERS = {
    "figures": _figures,
    "chains": _chains,
    "large": _large,
    "proteins": _proteins,
    "windows": _windows,
    "sidechains": _sideChains,
    "positions": _positions,
    "worst": _worst,
    "simd": _instructionSets,
    "ways": _ways,
    "calls": _calls,
    "python": _python,
    "needs": _needs,
    "forces": _forces,
    "pairs": _pairs,
    "nearest": _nearest,
}


def _whyNot(row):
    """Return why a row cannot run: too few torsions, or no contestant who can; None if it can."""
    if isinstance(row, (Race, Question, PairRow)) and not row.contestants:
        return "none of the contestants can do it"
    if isinstance(getattr(row, "chain", None), Model) and hasattr(row, "moves"):
        ofSideChains = row.moves == _SIDE_CHAIN
        count = row.chain.scene.countTorsions(ofSideChains)
        if count < row.moves.kappa:
            return f"there are {count} torsions of {'side chains' if ofSideChains else 'the backbone'}"
    if isinstance(row, PartRow) and row.chain.protein.residues < RESIDUES + 2:
        return f"there are {row.chain.protein.residues} residues"
    return None
