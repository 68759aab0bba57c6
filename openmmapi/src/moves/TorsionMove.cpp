#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void readTorsionMove(const SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator)
{
    integrator.addTorsionMove(weight, node.getDoubleProperty("maxAngle"), readIndices(node),
                              node.getIntProperty("count"));
}

static const MoveKind KIND("torsion", "TorsionMove", TorsionMonteCarloIntegrator::TorsionMove, readTorsionMove);

namespace {

/**
 * Turns a number of different torsions, each by a uniform angle. See TorsionMonteCarloIntegrator::addTorsionMove().
 */
class TorsionMove : public MonteCarloMove {
public:
    TorsionMove(double maxAngle, const vector<int>& torsions, int count) :
        MonteCarloMove(KIND), maxAngle(maxAngle), torsions(torsions), count(count)
    {
        checkLargestAngle(maxAngle, KIND.name);
        if (count < 1)
            throw OpenMMException("TorsionMonteCarloIntegrator: the number of torsions that a move turns must be at "
                                  "least 1, but is " +
                                  to_string(count));
    }
    bool hasSize() const
    {
        return maxAngle > 0;
    }
    string summarize() const
    {
        return (count == 1 ? KIND.name : to_string(count) + " torsions") + " " + toSize(maxAngle, "rad");
    }
    vector<MoveParameter> getParameters() const
    {
        return {{"maxAngle", maxAngle, ""}, {"torsions", torsions, "Torsion"}, {"count", count, ""}};
    }
    void bind(const LinkStructure& structure, const string& name);
    bool propose(TrialSession& trials, RandomNumberGenerator& random);
    const double maxAngle;
    /** The torsions to choose from as they were given; empty for all. */
    const vector<int> torsions;
    const int count;

private:
    /** The torsions to choose from: those given, or all. */
    vector<int> choices;
    vector<bool> isDrawn;
    vector<int> drawnChoices, drawnTorsions;
    vector<double> drawnChanges;
};

} // namespace

void TorsionMove::bind(const LinkStructure& structure, const string& name)
{
    int numTorsions = structure.getTorsionLinks().size();
    if (numTorsions == 0)
        throw OpenMMException(name + " turns torsions, but the StericExclusionForce has none");
    for (int torsion : torsions)
        checkIndex(torsion, numTorsions, "torsion", name);
    checkUnique(torsions, name + " names torsion ");
    for (int torsion : torsions)
        structure.checkNoClosure(structure.getTorsionLinks()[torsion], name);
    choices = torsions;
    if (torsions.empty())
        for (int torsion = 0; torsion < numTorsions; torsion++)
            if (structure.getLinkClosure(structure.getTorsionLinks()[torsion]) == -1)
                choices.push_back(torsion);
    if (choices.empty())
        throw OpenMMException(name +
                              " turns torsions, but all of them lie in rings of closures; only closed moves turn "
                              "these");
    if (count > (int)choices.size())
        throw OpenMMException(name + " turns " + to_string(count) + " torsions at once, but has only " +
                              to_string(choices.size()) + " to choose from");
    isDrawn.assign(choices.size(), false);
    drawnChoices.resize(count);
    drawnTorsions.resize(count);
    drawnChanges.resize(count);
}

bool TorsionMove::propose(TrialSession& trials, RandomNumberGenerator& random)
{
    // Floyd's algorithm: every set of `count` choices is equally likely, and nothing is remembered between trials.

    for (int i = 0; i < count; i++) {
        int last = choices.size() - count + i;
        int choice = random.drawIndex(last + 1);
        if (isDrawn[choice])
            choice = last;
        isDrawn[choice] = true;
        drawnChoices[i] = choice;
    }
    for (int i = 0; i < count; i++) {
        isDrawn[drawnChoices[i]] = false;
        drawnTorsions[i] = choices[drawnChoices[i]];
        drawnChanges[i] = random.drawSymmetric(getScale() * maxAngle);
    }
    trials.proposeTorsions(drawnTorsions, drawnChanges);
    return true;
}

// ---- The methods of the integrator ----

int TorsionMonteCarloIntegrator::addTorsionMove(double weight, double maxAngle, const vector<int>& torsions, int count)
{
    return addMove(make_unique<::TorsionMove>(maxAngle, torsions, count), weight);
}

void TorsionMonteCarloIntegrator::getTorsionMoveParameters(int move, double& weight, double& maxAngle,
                                                           vector<int>& torsions, int& count) const
{
    auto& found = moves->get<::TorsionMove>(move, KIND, weight);
    maxAngle = found.maxAngle;
    torsions = found.torsions;
    count = found.count;
}

void TorsionMonteCarloIntegrator::setTorsionMoveParameters(int move, double weight, double maxAngle,
                                                           const vector<int>& torsions, int count)
{
    setMove(move, KIND, make_unique<::TorsionMove>(maxAngle, torsions, count), weight);
}
