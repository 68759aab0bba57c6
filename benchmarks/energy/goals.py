"""What is promised of energies, and whether a run shows it: exactness on all machines, times on a server core."""

from precision.goals import describeGoal
from racing.races import OURS

from .proteins import NO_CUTOFF, REACTION_FIELD
from .rows import GROWTH, MOVE_NAMES, ONE_ENERGY, PIVOT, SIDE_CHAIN, SMALL_PIVOT, STAGES, TRIALS, WINDOW, WORK
from .tables import AVX2, AVX512, PORTABLE, anyOf, combineRuns, growthOf, ratio, widest

# Of U and its changes, kJ/mol.
_RELATIVE, _ABSOLUTE, _CHANGE = 1e-6, 5e-3, 1e-3

# Single precision misses these by a factor at most; energies that are wrong miss them by more than this.
_WRONG = 10

_LARGE, _SMALL = "5dfr_h", "villin"
_RF, _NONE = REACTION_FIELD.name, NO_CUTOFF.name

# (protein, method, move, µs): energy work; the same until a part refuses; whole trials.
_WORK_GOALS = (
    (_LARGE, _RF, SIDE_CHAIN, 9),
    (_LARGE, _RF, WINDOW, 130),
    (_LARGE, _RF, PIVOT, 110),
    (_SMALL, _NONE, SIDE_CHAIN, 6),
    (_SMALL, _NONE, PIVOT, 35),
    (_LARGE, _NONE, SIDE_CHAIN, 20),
    (_LARGE, _NONE, PIVOT, 550),
)
_RATIO_GOALS = ((_LARGE, _RF, SIDE_CHAIN, 300), (_LARGE, _RF, PIVOT, 30))
_STAGE_GOALS = ((_LARGE, _RF, PIVOT, 55),)
_TRIAL_GOALS = ((_SMALL, 20), ("1ubi_h", 30), (_LARGE, 45))
_GROWTH_GOALS = ((SMALL_PIVOT, 0.7), (SIDE_CHAIN, 0.1))
_SET_GOALS = ((AVX2, 1.3), (PORTABLE, 2.5))
_BYTES = 2000


def judge(entries):
    """Return lines about goals, and whether energies are wrong. A machine may be slow; that is no failure."""
    rows = combineRuns(entries)
    exact = [_judgeEnergy(entries), _judgeChange(entries)]
    goals = [*exact, *_judgeTimes(rows), *_judgeSets(rows), *_judgeGrowth(rows), _judgeMemory(rows)]
    isWrong = any(_isWrong(entry) for entry in entries if _isOurs(entry))
    return [describeGoal(goal) for goal in goals if goal["reached"] is not None or goal in exact], isWrong


def _goal(what, reached, evidence):
    return {"what": what, "reached": reached, "evidence": evidence}


def _isOurs(entry):
    return entry["contestant"].startswith(OURS) and "changeError" in entry


def _isWrong(entry):
    change = entry["changeError"]["largest"]
    return entry["energyError"] > _WRONG * _bound(entry) or change > _WRONG * _CHANGE


def _judgeEnergy(entries):
    what = f"U within {_RELATIVE:g} and {_ABSOLUTE:g} kJ/mol of OpenMM's Reference platform"
    ours = [entry for entry in entries if _isOurs(entry)]
    if not ours:
        return _goal(what, None, "no energies were compared")
    worst = max(ours, key=lambda entry: entry["energyError"] / _bound(entry))
    evidence = f"up to {worst['energyError']:.1e} kJ/mol of {worst['energy']:,.0f}, {worst['chain']}, {worst['method']}"
    return _goal(what, worst["energyError"] <= _bound(worst), evidence)


def _bound(entry):
    return _ABSOLUTE + _RELATIVE * abs(entry["energy"])


def _judgeChange(entries):
    what = f"changes of U within {_CHANGE:g} kJ/mol"
    ours = [entry for entry in entries if _isOurs(entry)]
    if not ours:
        return _goal(what, None, "no energies were compared")
    worst = max(entry["changeError"]["largest"] for entry in ours)
    return _goal(what, worst <= _CHANGE, f"up to {worst:.1e} kJ/mol")


def _find(rows, group, chain, method, moves=None):
    """Return the row of a protein, or None."""
    for row in rows:
        entry = anyOf(row)
        if (entry["group"], entry["chain"], entry["method"]) == (group, chain, method):
            if moves is None or entry["moves"] == str(moves):
                return row
    return None


def _judgeTimes(rows):
    for chain, method, moves, most in _WORK_GOALS:
        row = _find(rows, WORK, chain, method, moves)
        if row is not None:
            time = widest(row)["microseconds"]
            yield _goal(f"{_describe(chain, method, moves)}: {most} µs", time <= most, f"{time:.1f}")
    for chain, method, moves, least in _RATIO_GOALS:
        row = _find(rows, WORK, chain, method, moves)
        if row is not None and ONE_ENERGY in row:
            value = ratio(row, ONE_ENERGY, OURS)
            yield _goal(f"{_describe(chain, method, moves)}: {least} × OpenMM", value >= least, f"{value:.0f}")
    for chain, method, moves, most in _STAGE_GOALS:
        row = _find(rows, WORK, chain, method, moves)
        if row is not None:
            time = row[STAGES]["mean"]
            yield _goal(f"{_describe(chain, method, moves)}, until refused: {most} µs", time <= most, f"{time:.1f}")
    for chain, most in _TRIAL_GOALS:
        row = _find(rows, TRIALS, chain, _RF)
        if row is not None:
            time = row[OURS]["microseconds"]
            yield _goal(f"{chain}, {_RF}, whole trial: {most} µs", time <= most, f"{time:.1f}")


def _describe(chain, method, moves):
    return f"{chain}, {method}, {MOVE_NAMES[str(moves)]}"


def _judgeSets(rows):
    for name, most in _SET_GOALS:
        ratios = [
            row[name]["microseconds"] / row[AVX512]["microseconds"] for row in rows if name in row and AVX512 in row
        ]
        if ratios:
            what = f"{name.removeprefix(f'{OURS}-')} up to {most} × AVX-512"
            yield _goal(what, max(ratios) <= most, f"{min(ratios):.2f} to {max(ratios):.2f}")


def _judgeGrowth(rows):
    growths = growthOf([row for row in rows if anyOf(row)["group"] == GROWTH])
    for moves, most in _GROWTH_GOALS:
        value = growths.get(MOVE_NAMES[str(moves)])
        if value is not None:
            yield _goal(f"{MOVE_NAMES[str(moves)]}: grows up to N^{most}", value <= most, f"N^{value:.2f}")


def _judgeMemory(rows):
    what = f"{_BYTES:,} bytes a particle with a cutoff"
    bytesOf = [
        (ours["bytes"] + ours["treeBytes"]) / ours["particles"]
        for ours in map(widest, rows)
        if ours is not None and ours.get("bytes", -1) >= 0 and ours["method"] == _RF
    ]
    return _goal(what, max(bytesOf) <= _BYTES if bytesOf else None, f"up to {max(bytesOf, default=0):,.0f}")
