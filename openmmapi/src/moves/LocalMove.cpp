#include "ctlocal.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include <algorithm>
#include <cmath>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define LOCAL_MOVE(P)                                                                                                  \
    P(Angle, sigma, "sigma", Angle::AboveZero)                                                                         \
    P(Number, stiffness, "stiffness", "nm^-2")                                                                         \
    P(Indices, torsions, "those of backbones")                                                                         \
    P(Count, window, "number of torsions in a window", 1, CT_LOCAL_MOST)

MOVE_PARAMETERS(LocalMove, LOCAL_MOVE)

namespace {

/**
 * Turns a window of torsions so that the chain behind it moves little. See
 * TorsionMonteCarloIntegrator::addLocalMove().
 */
class LocalMove : public DeclaredMove<LocalMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);
    double computeLogRatio(TrialSession& trials);

private:
    /** A window, and the particles of its axes and ends. */
    class Choice {
    public:
        vector<int> torsions;
        /** The particles of all axes, each once, in the order of the chain, and the next one. */
        vector<int> particles;
        WindowAxes axes;
    };
    static Choice describeWindow(const LinkStructure& structure, const vector<int>& torsions);
    vector<Choice> choices;
    // Of the open trial.
    ctLocalWindow before;
    ctLocalSteps steps;
    vector<double> changes;
    // Memory.
    vector<double> normals;
    vector<Vec3> positions;
};

} // namespace

LocalMove::Choice LocalMove::describeWindow(const LinkStructure& structure, const vector<int>& torsions)
{
    Choice choice;
    choice.torsions = torsions;
    choice.axes = findWindowAxes(structure, torsions, choice.particles);
    choice.particles.push_back(structure.getTorsionParticles(torsions.back())[3]);
    return choice;
}

void LocalMove::bind(const LinkStructure& structure, const string& name)
{
    choices.clear();
    size_t numParticles = 0;
    for (auto& found : findTorsionWindows(structure, findWindowTorsions(structure, torsions, name), window)) {
        choices.push_back(describeWindow(structure, found));
        numParticles = max(numParticles, choices.back().particles.size());
    }
    if (choices.empty())
        throw OpenMMException(name +
                              " turns windows of torsions, but all of them lie in rings of closures; only closed "
                              "moves turn these");
    positions.reserve(numParticles);
    changes.reserve(window);
    normals.reserve(window);
}

static void copyTo(double* copy, const Vec3& x)
{
    for (int i = 0; i < 3; i++)
        copy[i] = x[i];
}

bool LocalMove::draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
{
    const Choice& choice = choices[random.drawIndex(choices.size())];
    trials.getPositions(choice.particles, positions);
    before.count = choice.torsions.size();
    for (int i = 0; i < before.count; i++) {
        copyTo(before.points[i], positions[choice.axes[i].first]);
        copyTo(before.axes[i], getAxisDirection(positions, choice.axes[i]));
    }
    for (int i = 0; i < CT_LOCAL_ENDS; i++)
        copyTo(before.ends[i], positions[positions.size() - CT_LOCAL_ENDS + i]);
    if (!ctFindLocalSteps(&before, getScale() * sigma, stiffness, &steps))
        return false;
    normals.resize(before.count);
    changes.resize(before.count);
    for (double& normal : normals)
        normal = random.drawNormal();
    ctDrawLocalStep(&steps, normals.data(), changes.data());
    for (int i = 0; i < before.count; i++)
        proposal.addTorsion(choice.torsions[i], changes[i]);
    return true;
}

double LocalMove::computeLogRatio(TrialSession&)
{
    // The reverse step has the same length, but is drawn from the distribution at the proposed state.

    ctLocalWindow after;
    ctLocalSteps stepsBack;
    ctTurnLocalWindow(&before, changes.data(), &after);
    if (!ctFindLocalSteps(&after, getScale() * sigma, stiffness, &stepsBack))
        return -numeric_limits<double>::infinity();
    return ctComputeLocalLogDensity(&stepsBack, changes.data()) - ctComputeLocalLogDensity(&steps, changes.data());
}

MOVE("local", LocalMove, LOCAL_MOVE)
