#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void readRigidBodyMove(const SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator)
{
    integrator.addRigidBodyMove(weight, node.getDoubleProperty("maxTranslation"), node.getDoubleProperty("maxAngle"),
                                readIndices(node));
}

static const MoveKind KIND("rigid body", "RigidBodyMove", TorsionMonteCarloIntegrator::RigidBodyMove,
                           readRigidBodyMove);

namespace {

/**
 * Moves a whole molecule as a rigid body. See TorsionMonteCarloIntegrator::addRigidBodyMove().
 */
class RigidBodyMove : public MonteCarloMove {
public:
    RigidBodyMove(double maxTranslation, double maxAngle, const vector<int>& molecules) :
        MonteCarloMove(KIND), maxTranslation(maxTranslation), maxAngle(maxAngle), molecules(molecules)
    {
        checkNotNegative(maxTranslation, "TorsionMonteCarloIntegrator: the largest translation of a rigid body move");
        checkLargestAngle(maxAngle, KIND.name);
    }
    bool hasSize() const
    {
        return maxTranslation > 0 || maxAngle > 0;
    }
    string summarize() const
    {
        return KIND.name + " " + toSize(maxTranslation, "nm") + " " + toSize(maxAngle, "rad");
    }
    vector<MoveParameter> getParameters() const
    {
        return {
            {"maxTranslation", maxTranslation, ""}, {"maxAngle", maxAngle, ""}, {"molecules", molecules, "Molecule"}};
    }
    void bind(const LinkStructure& structure, const string& name);
    bool propose(TrialSession& trials, RandomNumberGenerator& random);
    const double maxTranslation, maxAngle;
    /** The molecules to choose from, each named by one of its particles; empty for all that can move. */
    const vector<int> molecules;

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

bool RigidBodyMove::propose(TrialSession& trials, RandomNumberGenerator& random)
{
    int molecule = choices[random.drawIndex(choices.size())];
    Vec3 translation = random.drawPointInBall(getScale() * maxTranslation);
    Vec3 rotation = random.drawDirection() * random.drawSymmetric(getScale() * maxAngle);
    trials.proposeRigidMotion(molecule, rotation, translation);
    return true;
}

// ---- The methods of the integrator ----

int TorsionMonteCarloIntegrator::addRigidBodyMove(double weight, double maxTranslation, double maxAngle,
                                                  const vector<int>& molecules)
{
    return addMove(make_unique<::RigidBodyMove>(maxTranslation, maxAngle, molecules), weight);
}

void TorsionMonteCarloIntegrator::getRigidBodyMoveParameters(int move, double& weight, double& maxTranslation,
                                                             double& maxAngle, vector<int>& molecules) const
{
    auto& found = moves->get<::RigidBodyMove>(move, KIND, weight);
    maxTranslation = found.maxTranslation;
    maxAngle = found.maxAngle;
    molecules = found.molecules;
}

void TorsionMonteCarloIntegrator::setRigidBodyMoveParameters(int move, double weight, double maxTranslation,
                                                             double maxAngle, const vector<int>& molecules)
{
    setMove(move, KIND, make_unique<::RigidBodyMove>(maxTranslation, maxAngle, molecules), weight);
}
