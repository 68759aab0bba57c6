"""Rows about what a user asks a Context: energy and forces, neighbour pairs."""

import copy
import importlib
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import openmm

from .course import Course, measure, summarizeTimes
from .platforms import CPU, makeContext, whyNot
from .program import ProgramError
from .proteins import Model, Protein, makeForce
from .races import ALL_CHAINS, askProgram

# Atoms move by so much (nm) from one question to the next, as within 2 fs at 300 K, and stray so far from where they
# began.
_STRIDE = 0.001
_EXCURSION = 0.01

_BLOCK_SIZE = 5

# By this part may an energy differ that is computed in single precision, or by this part of a small energy (kJ/mol).
_SINGLE_PRECISION = 1e-3
_SMALL_ENERGY = 0.01

CUTOFF = 0.8  # nm, of neighbour pairs


class ForceRow(NamedTuple):
    """Energy and forces of the soft force, and of a CustomNonbondedForce of the same form."""

    group: str
    protein: Protein
    trials: int
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.protein.name

    def run(self, course: Course, seed: int):
        """Return an entry for each force on each platform.

        Raises
        ------
        ProgramError
            if energies disagree
        """
        force = makeForce(self.protein)
        contestants = [self._contestant("force, Reference", "Reference", force)]
        if whyNot(CPU) is None:
            contestants.append(self._contestant("force, CPU", CPU, force))
            contestants.append(self._contestant("CustomNonbondedForce, CPU", CPU, makeCustomForce(force)))
        return _takeTurns(self, self.protein, course, seed, contestants, _checkEnergies)

    def _contestant(self, name, platform, force):
        context = makeContext(platform, self.protein.topology.getNumAtoms(), copy.copy(force))
        return _Contestant(name, context.setPositions, lambda positions: context.getState(energy=True, forces=True))


class PairRow(NamedTuple):
    """Pairs within a cutoff, from positions on: by the program's contestants, then by what one calls from Python."""

    group: str
    chain: Model
    trials: int
    contestants: Sequence[str]
    measure: str = "pairs"
    mostChains: int = ALL_CHAINS

    def __str__(self) -> str:
        return self.chain.name

    def run(self, course: Course, seed: int):
        """Return an entry for each contestant.

        Raises
        ------
        ProgramError
            if they do not find the same number of pairs
        """
        entries = askProgram(self, course, seed, {"--cutoff": CUTOFF})
        force = copy.copy(self.chain.force)
        context = makeContext("Reference", len(self.chain.protein.positions), force)
        contestants = [
            _Contestant(
                "getNeighborPairs", context.setPositions, lambda positions: force.getNeighborPairs(context, CUTOFF)[0]
            )
        ]
        if whyNot("scipy") is None:
            Tree = importlib.import_module("scipy.spatial").cKDTree
            contestants.append(
                _Contestant(
                    "SciPy",
                    lambda positions: None,
                    lambda positions: Tree(positions).query_pairs(CUTOFF, output_type="ndarray"),
                )
            )
        excluded = self.chain.scene.exclusions

        def check(positions, answers):
            distances = np.linalg.norm(np.subtract(*positions[excluded.T]), axis=1)
            near = np.count_nonzero(distances <= CUTOFF)
            counts = [len(answers[0]), *(len(pairs) - near for pairs in answers[1:])]
            if len(set(counts)) > 1:
                raise ProgramError(f"getNeighborPairs finds {counts[0]:,} pairs, {contestants[1].name} {counts[1]:,}")

        return entries + _takeTurns(self, self.chain.protein, course, seed, contestants, check)


class _Contestant(NamedTuple):
    """One who answers a question about positions: `prepare` takes no part in the time, `answer` does."""

    name: str
    prepare: Callable[[np.ndarray], Any]
    answer: Callable[[np.ndarray], Any]


def _takeTurns(row, protein, course, seed, contestants, check):
    """Ask contestants about one set of positions after the other; the first block does not count.

    check(positions, answers) raises an exception unless the answers agree.
    """
    walk = _walk(protein.positions, seed)
    times = {contestant.name: [] for contestant in contestants}
    blocks = max(1, course.questions(row.trials) // _BLOCK_SIZE)
    for _ in range(1 + blocks):
        block = [next(walk) for _ in range(_BLOCK_SIZE)]
        answers = []
        for contestant in contestants:
            answer, time = _askAll(contestant, block)
            answers.append(answer)
            times[contestant.name].append(time / len(block))
        check(block[-1], answers)
    common = {"group": row.group, "chain": protein.name, "particles": len(protein.positions), "seed": seed}
    common["trials"] = common["asked"] = blocks * _BLOCK_SIZE
    return [{**common, "contestant": name, **summarizeTimes(values[1:])} for name, values in times.items()]


def _askAll(contestant, block):
    """Return the answer to the last question of a block, and the time that all took."""
    total = 0.0
    for positions in block:
        contestant.prepare(positions)
        answer, time = measure(contestant.answer, positions)
        total += time
    return answer, total


def _walk(start, seed):
    """Yield positions that stray about a start, an Ornstein–Uhlenbeck process."""
    generator = np.random.default_rng(seed)
    pull = _STRIDE**2 / (2 * _EXCURSION**2)
    shift = np.zeros_like(start)
    while True:
        shift += _STRIDE * generator.standard_normal(start.shape) - pull * shift
        yield start + shift


def makeCustomForce(force):
    """Make a CustomNonbondedForce with the energy of a StericExclusionForce."""
    custom = openmm.CustomNonbondedForce(
        "0.5*k*step(overlap)*overlap^2; overlap = radius1 + radius2 - r - tolerance - allowance*bonded; "
        "bonded = max(donor1*acceptor2, acceptor1*donor2)"
    )
    custom.addGlobalParameter("k", force.getForceConstant())
    custom.addGlobalParameter("tolerance", force.getOverlapTolerance())
    custom.addGlobalParameter("allowance", force.getHydrogenBondAllowance())
    for name in ("radius", "donor", "acceptor"):
        custom.addPerParticleParameter(name)
    radii = []
    for i in range(force.getNumParticles()):
        radius, role = force.getParticleParameters(i)
        radii.append(_plain(radius))
        custom.addParticle([radii[-1], bool(role & force.Donor), bool(role & force.Acceptor)])
    for i in range(force.getNumExclusions()):
        custom.addExclusion(*force.getExclusionParticles(i))
    custom.setNonbondedMethod(custom.CutoffNonPeriodic)
    custom.setCutoffDistance(2 * max(radii) - _plain(force.getOverlapTolerance()))
    return custom


def _checkEnergies(positions, states):
    energies = [_plain(state.getPotentialEnergy()) for state in states]
    if max(energies) - min(energies) > _SINGLE_PRECISION * max(_SMALL_ENERGY, *energies):
        raise ProgramError(f"energies disagree: {', '.join(f'{energy:.6g}' for energy in energies)} kJ/mol")


def _plain(quantity):
    return quantity.value_in_unit(quantity.unit)
