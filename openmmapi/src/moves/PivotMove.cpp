#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MoveDeclaration.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define PIVOT_MOVE(P)                                                                                                  \
    P(Angle, maxAngle, "largest angle")                                                                                \
    P(Indices, ballJoints, "all")

MOVE_PARAMETERS(PivotMove, PIVOT_MOVE)

namespace {

/**
 * Turns all that hangs by a ball joint. See TorsionMonteCarloIntegrator::addPivotMove().
 */
class PivotMove : public DeclaredMove<PivotMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure& structure, const string& name);
    bool propose(TrialSession& trials, RandomNumberGenerator& random);

private:
    /** The ball joints to choose from: those given, or all. */
    vector<int> choices;
    vector<int> drawnJoints = vector<int>(1);
    vector<Vec3> drawnRotations = vector<Vec3>(1);
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

MOVE("pivot", PivotMove, PIVOT_MOVE)
