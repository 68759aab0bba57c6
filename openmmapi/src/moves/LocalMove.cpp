#include "ctlocal.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/internal/TorsionWindows.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void readLocalMove(const SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator)
{
    integrator.addLocalMove(weight, node.getDoubleProperty("sigma"), node.getDoubleProperty("stiffness"),
                            readIndices(node), node.getIntProperty("window"));
}

static const MoveKind KIND("local", "LocalMove", TorsionMonteCarloIntegrator::LocalMove, readLocalMove);

namespace {

/**
 * Turns a window of torsions so that what lies behind it is shifted little. See
 * TorsionMonteCarloIntegrator::addLocalMove().
 */
class LocalMove : public MonteCarloMove {
public:
    LocalMove(double sigma, double stiffness, const vector<int>& torsions, int window);
    bool hasSize() const
    {
        return true;
    }
    string summarize() const
    {
        return KIND.name + " " + toSize(sigma, "rad");
    }
    vector<MoveParameter> getParameters() const
    {
        return {{"sigma", sigma, ""},
                {"stiffness", stiffness, ""},
                {"torsions", torsions, "Torsion"},
                {"window", window, ""}};
    }
    void bind(const LinkStructure& structure, const string& name);
    bool propose(TrialSession& trials, RandomNumberGenerator& random);
    double computeLogRatio(TrialSession& trials);
    const double sigma, stiffness;
    /** The torsions that windows consist of as they were given; empty for those of the backbones. */
    const vector<int> torsions;
    const int window;

private:
    /** A window, and where its axes and ends are found. */
    class Choice {
    public:
        vector<int> torsions;
        /** The particles of all axes, each once, in the order of the chain, and the one behind the last. */
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

LocalMove::LocalMove(double sigma, double stiffness, const vector<int>& torsions, int window) :
    MonteCarloMove(KIND), sigma(sigma), stiffness(stiffness), torsions(torsions), window(window)
{
    const string whose = "TorsionMonteCarloIntegrator: the ";
    checkAngle(sigma, whose + "sigma of a local move");
    if (sigma == 0)
        throw OpenMMException(whose + "sigma of a local move must be above 0");
    checkNotNegative(stiffness, whose + "stiffness of a local move");
    if (window < 1 || window > CT_LOCAL_MOST)
        throw OpenMMException(whose + "window of a local move must have 1 to " + to_string(CT_LOCAL_MOST) +
                              " torsions, but has " + to_string(window));
}

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

bool LocalMove::propose(TrialSession& trials, RandomNumberGenerator& random)
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
    trials.proposeTorsions(choice.torsions, changes);
    return true;
}

double LocalMove::computeLogRatio(TrialSession&)
{
    // The step back is as long, but drawn from the distribution of where this one leads.

    ctLocalWindow after;
    ctLocalSteps stepsBack;
    ctTurnLocalWindow(&before, changes.data(), &after);
    if (!ctFindLocalSteps(&after, getScale() * sigma, stiffness, &stepsBack))
        return -numeric_limits<double>::infinity();
    return ctComputeLocalLogDensity(&stepsBack, changes.data()) - ctComputeLocalLogDensity(&steps, changes.data());
}

// ---- The methods of the integrator ----

int TorsionMonteCarloIntegrator::addLocalMove(double weight, double sigma, double stiffness,
                                              const vector<int>& torsions, int window)
{
    return addMove(make_unique<::LocalMove>(sigma, stiffness, torsions, window), weight);
}

void TorsionMonteCarloIntegrator::getLocalMoveParameters(int move, double& weight, double& sigma, double& stiffness,
                                                         vector<int>& torsions, int& window) const
{
    auto& found = moves->get<::LocalMove>(move, KIND, weight);
    sigma = found.sigma;
    stiffness = found.stiffness;
    torsions = found.torsions;
    window = found.window;
}

void TorsionMonteCarloIntegrator::setLocalMoveParameters(int move, double weight, double sigma, double stiffness,
                                                         const vector<int>& torsions, int window)
{
    setMove(move, KIND, make_unique<::LocalMove>(sigma, stiffness, torsions, window), weight);
}
