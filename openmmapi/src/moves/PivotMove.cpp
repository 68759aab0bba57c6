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
 * Turns one ball joint. See TorsionMonteCarloIntegrator::addPivotMove().
 */
class PivotMove : public DeclaredMove<PivotMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);

private:
    /** The ball joints to choose from: those given, or all. */
    vector<int> choices;
};

} // namespace

void PivotMove::bind(const LinkStructure& structure, const string& name)
{
    choices = chooseBallJoints(structure, ballJoints, name);
}

bool PivotMove::draw(const TrialSession&, RandomNumberGenerator& random, Proposal& proposal)
{
    const int ballJoint = choices[random.drawIndex(choices.size())];
    proposal.addBallRotation(ballJoint, random.drawRotation(getScale() * maxAngle));
    return true;
}

MOVE("pivot", PivotMove, PIVOT_MOVE)
