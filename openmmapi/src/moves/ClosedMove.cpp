#include "ctclosure.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/ClosedWindows.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include <cmath>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define CLOSED_MOVE(P)                                                                                                 \
    P(Angle, maxAngle, "largest angle")                                                                                \
    P(Indices, torsions, "those of backbones and of rings of closures")                                                \
    P(Number, hop, "share of hops", "1", 0, 1)

MOVE_PARAMETERS(ClosedMove, CLOSED_MOVE)

/** The reverse move has restored a torsion if it differs by at most this, in radians: some 1e-7 nm. */
static const double RETURN_TOLERANCE = 1e-6;
/** Solutions near the state are preferred; within this distance, in radians, all are about equally likely. */
static const double NEARNESS = 0.35;

namespace {

typedef double Solutions[CT_CLOSURES_MOST][CT_PIVOTS];

/**
 * Turns consecutive torsions without moving the chain behind them. See TorsionMonteCarloIntegrator::addClosedMove().
 */
class ClosedMove : public DeclaredMove<ClosedMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);
    double computeLogRatio(TrialSession& trials);

private:
    void lookAt(const TrialSession& trials, const ClosedWindows::Window& drawn, const ClosedWindows::Pivots& pivots);
    bool drawSolution(RandomNumberGenerator& random);
    bool leadsBack(const ctWindow& turned, double& logWeights) const;
    unique_ptr<ClosedWindows> windows;
    /** The window of the trial before it, its turns, and whether the trial chose among all solutions. */
    ctWindow window;
    double angles[CT_WINDOW_MOST];
    bool isHop;
    /** Of a hop: the logarithm of the sum of the weights of all solutions. */
    double logWeights;
    vector<Vec3> positions;
};

} // namespace

/**
 * Add the torsions in rings of closures that a pool lacks. Only closed moves turn them.
 */
static void addRings(const LinkStructure& structure, vector<int>& pool)
{
    const vector<int>& links = structure.getTorsionLinks();
    vector<bool> isInPool(links.size(), false);
    for (int torsion : pool)
        isInPool[torsion] = true;
    for (int torsion = 0; torsion < (int)links.size(); torsion++)
        if (!isInPool[torsion] && structure.getLinkClosure(links[torsion]) != -1)
            pool.push_back(torsion);
}

void ClosedMove::bind(const LinkStructure& structure, const string& name)
{
    vector<int> pool = findWindowTorsions(structure, torsions, name, true);
    if (torsions.empty())
        addRings(structure, pool);
    windows = make_unique<ClosedWindows>(structure, pool);
    if (windows->getWindows().empty())
        throw OpenMMException(name +
                              " turns windows of eight torsions in a row, but its torsions have none: among seven, "
                              "eight or nine that follow each other along a chain there must be three pairs of "
                              "neighbours whose bonds share a particle, and the turns must keep all closures");
    for (const ClosedWindows::Window& found : windows->getWindows())
        positions.reserve(found.particles.size());
}

/**
 * Get the axes of a window in space.
 */
void ClosedMove::lookAt(const TrialSession& trials, const ClosedWindows::Window& drawn,
                        const ClosedWindows::Pivots& pivots)
{
    trials.getPositions(drawn.particles, positions);
    window.count = drawn.torsions.size();
    copy(pivots.begin(), pivots.end(), window.pivots);
    for (int i = 0; i < window.count; i++) {
        const Vec3& end = positions[drawn.axes[i].second];
        const Vec3 axis = getAxisDirection(positions, drawn.axes[i]);
        for (int j = 0; j < 3; j++) {
            window.points[i][j] = end[j];
            window.axes[i][j] = axis[j];
        }
    }

    // The axes of a pair of pivots meet at the end of the first and the beginning of the second.

    for (int i = 1; i < CT_PIVOTS; i += 2)
        copy_n(window.points[pivots[i - 1]], 3, window.points[pivots[i]]);
}

/**
 * Get the weight of a solution by its distance from the state. The reverse has the same weight.
 */
static double computeWeight(const double* turns)
{
    double squared = NEARNESS * NEARNESS;
    for (int i = 0; i < CT_PIVOTS; i++)
        squared += turns[i] * turns[i];
    return 1 / (squared * squared);
}

static double sumWeights(const Solutions& solutions, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += computeWeight(solutions[i]);
    return sum;
}

/**
 * Draw one of all solutions by its weight. Returns false if there is none.
 */
bool ClosedMove::drawSolution(RandomNumberGenerator& random)
{
    Solutions solutions;
    const int count = ctFindClosures(&window, angles, solutions);
    if (count == 0)
        return false;
    const double sum = sumWeights(solutions, count);
    logWeights = log(sum);
    double left = random.drawUniform() * sum;
    int drawn = 0;
    while (drawn < count - 1 && (left -= computeWeight(solutions[drawn])) >= 0)
        drawn++;
    for (int i = 0; i < CT_PIVOTS; i++)
        angles[window.pivots[i]] = solutions[drawn][i];
    return true;
}

bool ClosedMove::draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
{
    const vector<ClosedWindows::Window>& all = windows->getWindows();
    const ClosedWindows::Window& drawn = all[random.drawIndex(all.size())];
    const vector<ClosedWindows::Pivots>& choices = windows->getChoices(drawn);
    lookAt(trials, drawn, choices[random.drawIndex(choices.size())]);
    fill_n(angles, window.count, 0.0);
    for (int i = 0, pivot = 0; i < window.count; i++)
        if (pivot < CT_PIVOTS && window.pivots[pivot] == i)
            pivot++;
        else
            angles[i] = random.drawSymmetric(getScale() * maxAngle);
    isHop = random.drawUniform() < hop;
    if (isHop ? !drawSolution(random) : !ctCloseNear(&window, angles))
        return false;
    for (int i = 0; i < window.count; i++)
        proposal.addTorsion(drawn.torsions[i], angles[i]);
    return true;
}

/**
 * Get whether turns of the pivots undo the trial's turns.
 */
static bool undo(const ctWindow& window, const double* angles, const double* pivotTurns)
{
    for (int i = 0; i < CT_PIVOTS; i++)
        if (!(fabs(remainder(angles[window.pivots[i]] + pivotTurns[i], 2 * M_PI)) <= RETURN_TOLERANCE))
            return false;
    return true;
}

/**
 * Get whether the same method, with the drivers turned back, can reverse the trial.
 *
 * @param turned            the window after the trial
 * @param[out] logWeights   of a hop: the logarithm of the sum of the weights of all solutions there
 */
bool ClosedMove::leadsBack(const ctWindow& turned, double& logWeights) const
{
    double back[CT_WINDOW_MOST];
    for (int i = 0; i < window.count; i++)
        back[i] = -angles[i];
    if (isHop) {
        Solutions solutions;
        const int count = ctFindClosures(&turned, back, solutions);
        logWeights = log(sumWeights(solutions, count));
        for (int i = 0; i < count; i++)
            if (undo(window, angles, solutions[i]))
                return true;
        return false;
    }

    // Newton's method begins at the proposed drivers, independent of the pivots before.

    for (int pivot : window.pivots)
        back[pivot] = 0;
    if (!ctCloseNear(&turned, back))
        return false;
    double pivotTurns[CT_PIVOTS];
    for (int i = 0; i < CT_PIVOTS; i++)
        pivotTurns[i] = back[window.pivots[i]];
    return undo(window, angles, pivotTurns);
}

double ClosedMove::computeLogRatio(TrialSession&)
{
    ctWindow turned;
    ctTurnWindow(&window, angles, &turned);
    double logWeightsBack = 0;
    if (!leadsBack(turned, logWeightsBack))
        return -numeric_limits<double>::infinity();
    const double ratio = ctComputeLogJacobian(&window) - ctComputeLogJacobian(&turned);
    if (!isfinite(ratio)) // No trial leaves or enters a state whose pivots lie on a line.
        return -numeric_limits<double>::infinity();
    return isHop ? ratio + logWeights - logWeightsBack : ratio;
}

MOVE("closed", ClosedMove, CLOSED_MOVE)
