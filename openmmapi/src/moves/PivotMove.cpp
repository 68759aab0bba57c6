#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void readPivotMove(const SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator)
{
    integrator.addPivotMove(weight, node.getDoubleProperty("maxAngle"), readIndices(node));
}

static const MoveKind KIND("pivot", "PivotMove", TorsionMonteCarloIntegrator::PivotMove, readPivotMove);

namespace {

/**
 * Turns all that hangs by a ball joint. See TorsionMonteCarloIntegrator::addPivotMove().
 */
class PivotMove : public MonteCarloMove {
public:
    PivotMove(double maxAngle, const vector<int>& ballJoints) :
        MonteCarloMove(KIND), maxAngle(maxAngle), ballJoints(ballJoints), drawnJoints(1), drawnRotations(1)
    {
        checkLargestAngle(maxAngle, KIND.name);
    }
    bool hasSize() const
    {
        return maxAngle > 0;
    }
    string summarize() const
    {
        return KIND.name + " " + toSize(maxAngle, "rad");
    }
    vector<MoveParameter> getParameters() const
    {
        return {{"maxAngle", maxAngle, ""}, {"ballJoints", ballJoints, "BallJoint"}};
    }
    void bind(const LinkStructure& structure, const string& name);
    bool propose(TrialSession& trials, RandomNumberGenerator& random);
    const double maxAngle;
    /** The ball joints to choose from as they were given; empty for all. */
    const vector<int> ballJoints;

private:
    /** The ball joints to choose from: those given, or all. */
    vector<int> choices;
    vector<int> drawnJoints;
    vector<Vec3> drawnRotations;
};

} // namespace

void PivotMove::bind(const LinkStructure& structure, const string& name)
{
    const int numBallJoints = structure.getBallJointLinks().size();
    if (numBallJoints == 0)
        throw OpenMMException(name + " turns ball joints, but the StericExclusionForce has none");
    for (int ballJoint : ballJoints)
        checkIndex(ballJoint, numBallJoints, "ball joint", name);
    checkUnique(ballJoints, name + " names ball joint ");
    for (int ballJoint : ballJoints)
        structure.checkNoClosure(structure.getBallJointLinks()[ballJoint], name);
    choices = ballJoints;
    if (ballJoints.empty())
        for (int ballJoint = 0; ballJoint < numBallJoints; ballJoint++)
            if (structure.getLinkClosure(structure.getBallJointLinks()[ballJoint]) == -1)
                choices.push_back(ballJoint);
    if (choices.empty())
        throw OpenMMException(name + " turns ball joints, but all of them lie in rings of closures");
}

bool PivotMove::propose(TrialSession& trials, RandomNumberGenerator& random)
{
    drawnJoints[0] = choices[random.drawIndex(choices.size())];
    drawnRotations[0] = random.drawRotation(getScale() * maxAngle);
    trials.proposeBallRotations(drawnJoints, drawnRotations);
    return true;
}

// ---- The methods of the integrator ----

int TorsionMonteCarloIntegrator::addPivotMove(double weight, double maxAngle, const vector<int>& ballJoints)
{
    return addMove(make_unique<::PivotMove>(maxAngle, ballJoints), weight);
}

void TorsionMonteCarloIntegrator::getPivotMoveParameters(int move, double& weight, double& maxAngle,
                                                         vector<int>& ballJoints) const
{
    auto& found = moves->get<::PivotMove>(move, KIND, weight);
    maxAngle = found.maxAngle;
    ballJoints = found.ballJoints;
}

void TorsionMonteCarloIntegrator::setPivotMoveParameters(int move, double weight, double maxAngle,
                                                         const vector<int>& ballJoints)
{
    setMove(move, KIND, make_unique<::PivotMove>(maxAngle, ballJoints), weight);
}
