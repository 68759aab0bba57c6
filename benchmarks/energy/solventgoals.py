"""What is promised of implicit solvent, and whether a run shows it."""

from precision.goals import describeGoal
from racing.races import OURS

from .rows import FOREIGN, ONE_ENERGY
from .solventrows import EXPRESSION, EXPRESSION_MOVES, EXPRESSIONS, OUTER_TEST, SIZES, SOLVENT, WHOLE
from .solventtables import acceptance, outerShare, sizeGrowth
from .tables import anyOf, combineRuns

# Of U, kJ/mol; energies that are wrong miss this by more than the factor.
_RELATIVE, _ABSOLUTE, _WRONG = 1e-6, 5e-3, 10

_TRIAL_GOALS = (("villin", 35), ("1ubi_h", 60), ("5dfr_h", 75))
_RATIO_GOAL = 1500
_WHOLE_GOALS = (("villin", 0.28), ("5dfr_h", 5))  # ms
_WHOLE_RATIO_GOAL = 150
_ACCEPTED_GOAL, _SHARE_GOAL = 0.8, 1 / 6
_GROWTH_GOAL = 0.2
_EXPRESSION_GOALS = dict(zip(EXPRESSION_MOVES, (12, 230), strict=True))


def judge(entries):
    """Return lines about goals, and whether energies are wrong. A machine may be slow; that is no failure."""
    rows = combineRuns(entries)
    ofGroup = {
        group: {anyOf(row)["chain"]: row for row in rows if anyOf(row)["group"] == group} for group in (SOLVENT, WHOLE)
    }
    exact, isWrong = _judgeEnergies(entries)
    goals = [
        *exact,
        *_judgeTrials(ofGroup[SOLVENT], ofGroup[WHOLE]),
        *_judgeWhole(ofGroup[WHOLE]),
        *_judgeGrowth([row for row in rows if anyOf(row)["group"] == SIZES]),
        *_judgeExpressions([row for row in rows if anyOf(row)["group"] == EXPRESSIONS]),
    ]
    return [describeGoal(goal) for goal in goals], isWrong


def _goal(what, reached, evidence):
    return {"what": what, "reached": reached, "evidence": evidence}


def _judgeEnergies(entries):
    ours = [entry for entry in entries if entry["contestant"].startswith(OURS) and "energyError" in entry]
    if not ours:
        return [], False
    worst = max(ours, key=lambda entry: entry["energyError"] / _bound(entry))
    what = f"U within {_RELATIVE:g} and {_ABSOLUTE:g} kJ/mol of OpenMM's Reference platform"
    evidence = f"up to {worst['energyError']:.1e} kJ/mol of {worst['energy']:,.0f}, {worst['chain']}"
    isWrong = not worst["energyError"] <= _WRONG * _bound(worst)
    return [_goal(what, worst["energyError"] <= _bound(worst), evidence)], isWrong


def _bound(entry):
    return _ABSOLUTE + _RELATIVE * abs(entry["energy"])


def _judgeTrials(rows, wholeRows):
    for chain, most in _TRIAL_GOALS:
        if chain in rows:
            time = rows[chain][OURS]["microseconds"]
            yield _goal(f"{chain}, whole trial: {most} µs", time <= most, f"{time:.1f}")
    for chain, row in rows.items():
        if FOREIGN in row:
            value = row[FOREIGN]["microseconds"] / row[OURS]["microseconds"]
            what = f"{chain}, whole trial: {_RATIO_GOAL:,} × OpenMM"
            yield _goal(what, value >= _RATIO_GOAL, f"{value:,.0f}")
    for chain, row in rows.items():
        value = acceptance(row[OURS])
        yield _goal(f"{chain}, outer tests: {_ACCEPTED_GOAL} kept", value >= _ACCEPTED_GOAL, f"{value:.2f}")
    for chain, row in rows.items():
        share = outerShare(row, wholeRows.values())
        if share is not None:
            what = f"{chain}, outer tests: up to a sixth of the time"
            yield _goal(what, share <= _SHARE_GOAL, f"{100 * share:.0f} %")


def _judgeWhole(rows):
    for chain, most in _WHOLE_GOALS:
        if chain in rows:
            time = 1e-3 * rows[chain][OUTER_TEST]["microseconds"]
            yield _goal(f"{chain}, one whole energy: {most} ms", time <= most, f"{time:.2f}")
    for chain, row in rows.items():
        if ONE_ENERGY in row:
            value = row[ONE_ENERGY]["microseconds"] / row[OUTER_TEST]["microseconds"]
            what = f"{chain}, one whole energy: {_WHOLE_RATIO_GOAL} × OpenMM"
            yield _goal(what, value >= _WHOLE_RATIO_GOAL, f"{value:.0f}")


def _judgeGrowth(rows):
    for moves, growth in sizeGrowth(rows).items():
        yield _goal(f"{moves}, in solvent: grow up to N^{_GROWTH_GOAL}", growth <= _GROWTH_GOAL, f"N^{growth:.2f}")


def _judgeExpressions(rows):
    for row in rows:
        custom = row[EXPRESSION]
        most = _EXPRESSION_GOALS[custom["moves"]]
        time = custom["microseconds"] / (1 - custom["clashed"] / custom["attempted"])
        what = f"{custom['chain']}, pairs by an expression, {custom['moves']}, of a free trial: {most} µs"
        yield _goal(what, time <= most, f"{time:.1f}")
