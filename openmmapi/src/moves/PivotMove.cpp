#include "openmmchaintree/internal/JointChoices.h"
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
    choices = chooseBallJoints(structure, ballJoints, name);
}

bool PivotMove::propose(TrialSession& trials, RandomNumberGenerator& random)
{
    drawnJoints[0] = choices[random.drawIndex(choices.size())];
    drawnRotations[0] = random.drawRotation(getScale() * maxAngle);
    trials.proposeBallRotations(drawnJoints, drawnRotations);
    return true;
}

MOVE("pivot", PivotMove, PIVOT_MOVE)
