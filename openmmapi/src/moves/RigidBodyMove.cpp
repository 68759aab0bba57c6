#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
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
    const vector<LinkStructure::Molecule>& all = structure.getMolecules();
    choices.clear();
    vector<bool> isNamed(all.size(), false);
    for (int particle : molecules) {
        checkIndex(particle, structure.getParticleLinks().size(), "particle", name);
        int molecule = structure.getParticleMolecule(particle);
        if (all[molecule].fixed)
            throw OpenMMException(name + " names the molecule of particle " + to_string(particle) +
                                  ", which has fixed particles and cannot move");
        if (isNamed[molecule])
            throw OpenMMException(name + " names the molecule of particle " + to_string(particle) + " twice");
        isNamed[molecule] = true;
        choices.push_back(molecule);
    }
    if (molecules.empty())
        for (int molecule = 0; molecule < (int)all.size(); molecule++)
            if (!all[molecule].fixed)
                choices.push_back(molecule);
    if (choices.empty())
        throw OpenMMException(name + " moves molecules, but all molecules have fixed particles");
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
