#include "openmmchaintree/internal/MoleculeChoices.h"
#include "openmmchaintree/internal/MoveDeclaration.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define RIGID_BODY_MOVE(P)                                                                                             \
    P(Length, maxTranslation, "largest translation")                                                                   \
    P(Angle, maxAngle, "largest angle")                                                                                \
    P(Indices, molecules, "all without fixed particles")

MOVE_PARAMETERS(RigidBodyMove, RIGID_BODY_MOVE)

namespace {

/**
 * Moves a whole molecule as a rigid body. See TorsionMonteCarloIntegrator::addRigidBodyMove().
 */
class RigidBodyMove : public DeclaredMove<RigidBodyMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);

private:
    /** The molecules to choose from, by their indices in the LinkStructure. */
    vector<int> choices;
};

} // namespace

void RigidBodyMove::bind(const LinkStructure& structure, const string& name)
{
    choices = chooseMolecules(structure, molecules, name);
}

bool RigidBodyMove::draw(const TrialSession&, RandomNumberGenerator& random, Proposal& proposal)
{
    int molecule = choices[random.drawIndex(choices.size())];
    Vec3 translation = random.drawPointInBall(getScale() * maxTranslation);
    Vec3 rotation = random.drawDirection() * random.drawSymmetric(getScale() * maxAngle);
    proposal.addRigidMotion(molecule, rotation, translation);
    return true;
}

MOVE("rigid body", RigidBodyMove, RIGID_BODY_MOVE)
