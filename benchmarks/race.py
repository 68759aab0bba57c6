"""Race the engine against other methods on the same trials; see docs/benchmark.md.

PYTHONPATH=build/package python benchmarks/race.py --markdown tables.md --picture figures.png
"""

import sys
from typing import NamedTuple

from measure import OURS, Row, makeParser, run
from program import ProgramError
from proteins import ChainModels, Model, findStructures
from racetables import makeTables
from rivals import RIVALS, isHere, runFromPython

GROUPS = {
    "figures": "the paper's figures 7 and 8 and its table 1",
    "chains": "compact chains, one torsion a trial",
    "large": "large chains, one torsion a trial",
    "proteins": "proteins, one torsion of the backbone a trial",
    "windows": "eight consecutive torsions of the backbone a trial",
    "sidechains": "one torsion of a side chain a trial",
    "python": "our calls from Python, and what one could call instead",
    "pairs": "pairs within 0.8 nm",
}

FILES = ("bpti_h.pdb", "5dfr_h.pdb", "1shg.pdb", "1htb.pdb", "2cas.pdb.gz")
_RUNS = 5

# Trials of each chain. All contestants of a row run the same number of trials.
_PAPER_TRIALS = 20000  # the paper's number
_TRIALS = 4000
_LARGE_TRIALS, _LARGE_BLOCK = 500, 100  # of trials that take milliseconds
_PYTHON_TRIALS = 400
_QUESTIONS = 50
_QUICK_TRIALS = 300
_BLOCK = 500  # trials of a contestant before the next one's turn

_GRIDS = "fullgrid,lazygrid,simdgrid,verletlist"
_WITHOUT_FULL_GRID = "lazygrid,simdgrid,verletlist"
_OF_EACH_CHAIN = f"{_GRIDS},published,improved,{OURS}"
_OF_FIRST_CHAIN = "obbtree1,kobbtree"  # which take milliseconds

_SIZES, _QUICK_SIZES = (1000, 2500, 5000, 10000), (1000,)
_ENDS = (1000, 10000)
_CUTOFF = 0.8  # nm

_CHAIN_NAMES = {"random": "random compact", "hilbert": "Hilbert", "serpentine": "serpentine"}


class Moves(NamedTuple):
    """A kind of trial by the program's name, an angle in degrees, and the number of torsions that turn."""

    kind: str
    angle: float | None = None
    kappa: int = 1

    def __str__(self) -> str:
        step = self.kind if self.angle is None else f"{self.angle:g}°"
        return step if self.kappa == 1 else f"{self.kappa} × {step}"

    def options(self):
        """Return the options of the program."""
        return {"--moves": self.kind, "--angle": self.angle, "--kappa": self.kappa}


_UNIFORM, _FIVE_DEGREES, _ONE_DEGREE = Moves("uniform"), Moves("gaussian", 5.0), Moves("gaussian", 1.0)
_SIDE_CHAIN = Moves("sidechain")
_WINDOWS = Moves("biased", 5.0, 8), Moves("biased", 1.0, 8)


class Chain(NamedTuple):
    """A chain that the program makes: its kind by the program's name, and its number of spheres."""

    kind: str
    size: int

    @property
    def name(self):
        """Return what tables call it."""
        return _CHAIN_NAMES[self.kind]

    def __str__(self) -> str:
        return f"{self.name}, {self.size:,} spheres"

    def options(self, course):
        """Return the options of the program."""
        return {"--chain": self.kind, "--n": self.size}


# ---- Rows ----


def race(group, chain, moves, trials, contestants, ofFirst="", block=_BLOCK, mostRuns=sys.maxsize):
    """Return the Row of contestants in turns on the same trials; some of them take part in the first run only."""

    def measure(course, seed):
        names = [contestants, *([ofFirst] if ofFirst and seed == course.seed else [])]
        return runTrials(course, chain, moves, trials, {"--contestants": ",".join(names), "--block": block}, seed)

    return Row(group, f"{chain}, {moves}", measure, mostRuns)


def runTrials(course, chain, moves, trials, options, seed):
    """Let the program run trials of a chain; return the entries of its contestants."""
    trials = course.trials or trials
    given = {**chain.options(course), **moves.options(), "--seed": seed, "--trials": trials, **options}
    return [
        {
            **{key: line[key] for key in ("particles", "contestant", "isa", "trials", "microseconds")},
            **{key: float(line[key]) for key in ("accepted", "volumeTests", "particleTests")},
            "chain": chain.name,
            "moves": str(moves),
        }
        for line in course.program.run(given)
    ]


def _fromPython(group, chain):
    """Return the Row of our calls from Python and of other packages, beside the program's contestants."""

    def measure(course, seed):
        record = course.folder / "record"
        options = {"--contestants": f"lazygrid,{OURS}", "--block": 20, "--record": record}
        entries = runTrials(course, chain, _UNIFORM, _PYTHON_TRIALS, options, seed)
        common = {key: entries[0][key] for key in ("chain", "moves", "particles", "trials", "accepted")}
        return [*entries, *({**common, **entry} for entry in runFromPython(record, seed))]

    return Row(group, f"{chain}, {_UNIFORM}", measure)


def _pairs(group, chain):
    """Return the Row of pairs within a cutoff."""

    def measure(course, seed):
        questions = min(course.trials or _QUESTIONS, _QUESTIONS)
        options = {"--measure": "pairs", "--contestants": f"cells,{OURS}", "--cutoff": _CUTOFF, "--trials": questions}
        lines = course.program.run({**chain.options(course), **options, "--seed": seed})
        if len({line["pairs"] for line in lines}) > 1:
            raise ProgramError("contestants find different numbers of pairs")
        keys = ("particles", "contestant", "isa", "trials", "microseconds", "pairs")
        return [{**{key: line[key] for key in keys}, "chain": chain.name} for line in lines]

    return Row(group, str(chain), measure)


# ---- Which rows there are ----


def _rowsOf(group, proteins, isQuick):
    sizes, ends = (_QUICK_SIZES, _QUICK_SIZES) if isQuick else (_SIZES, _ENDS)
    withOurs, withoutFull = f"{_GRIDS},{OURS}", f"{_WITHOUT_FULL_GRID},{OURS}"
    if group == "figures":
        for chain in (*(Chain("random", size) for size in sizes), *(protein.backbone for protein in proteins)):
            yield race(group, chain, _UNIFORM, _PAPER_TRIALS, _OF_EACH_CHAIN, _OF_FIRST_CHAIN)
    elif group == "chains":
        for size in sizes:
            yield race(group, Chain("random", size), _UNIFORM, _TRIALS, withOurs)
        for kind in _CHAIN_NAMES:
            for size in ends:
                for moves in (_UNIFORM, _FIVE_DEGREES, _ONE_DEGREE)[kind == "random" :]:
                    yield race(group, Chain(kind, size), moves, _TRIALS, withOurs)
    elif group == "large" and not isQuick:
        for kind, moves in (("hilbert", _UNIFORM), ("serpentine", _ONE_DEGREE)):
            for size in (10000, 100000):
                yield race(group, Chain(kind, size), moves, _LARGE_TRIALS, withOurs, block=_LARGE_BLOCK)
            chain = Chain(kind, 1000000)
            yield race(group, chain, moves, _LARGE_TRIALS, withoutFull, block=_LARGE_BLOCK, mostRuns=1)
    elif group == "proteins":
        for model in (m for protein in proteins for m in (protein.heavyAtoms, protein.allAtoms) if m is not None):
            for moves in (_UNIFORM, _FIVE_DEGREES, _ONE_DEGREE):
                yield race(group, model, moves, _TRIALS, withOurs)
    elif group == "windows":
        for protein in proteins:
            for moves in _WINDOWS:
                yield race(group, protein.heavyAtoms, moves, _TRIALS, withoutFull)
        for size in ends:
            yield race(group, Chain("random", size), _WINDOWS[-1], _TRIALS, withoutFull)
    elif group == "sidechains":
        for protein in proteins:
            yield race(group, protein.heavyAtoms, _SIDE_CHAIN, _TRIALS, withoutFull)
    elif group == "python":
        models = [protein.allAtoms or protein.heavyAtoms for protein in proteins]
        withHydrogens = [model for model in models if model.name.endswith("all atoms")]
        yield _fromPython(group, max(withHydrogens or models, key=_sizeOf))
        yield _fromPython(group, Chain("random", sizes[-1]))
    elif group == "pairs":
        for protein in proteins:
            yield _pairs(group, protein.heavyAtoms)


def _sizeOf(model: Model):
    return len(model.positions)


def _plan(options):
    if options.quick and options.trials is None:
        options.trials = _QUICK_TRIALS
    paths, skipped = findStructures(options, FILES)
    proteins = [ChainModels(path) for path in paths]
    if "python" in options.rows:
        skipped += [f"{rival.name}: it is not installed" for rival in RIVALS if not isHere(rival)]
    return [row for group in options.rows for row in _rowsOf(group, proteins, options.quick)], skipped


def main(arguments=None):
    """Run the script; return its exit status."""
    about = (
        "Race the engine against cell grids, trees of boxes and the ChainTree as published in 2002, in turns on the "
        "same trials, all of whose verdicts are compared; and against what one could call from Python."
    )
    parser = makeParser("race.py", about, GROUPS, _RUNS, FILES)
    return run(parser, arguments, _plan, makeTables, "racepicture")


if __name__ == "__main__":
    sys.exit(main())
