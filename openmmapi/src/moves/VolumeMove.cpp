#include "openmm/OpenMMException.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include <cmath>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define VOLUME_MOVE(P)                                                                                                 \
    P(Number, pressure, "pressure", "bar")                                                                             \
    P(Fraction, maxChange, "largest change of the logarithm of the volume")

MOVE_PARAMETERS(VolumeMove, VOLUME_MOVE)

/** 1 bar in kJ/mol/nm^3. */
static const double BAR = AVOGADRO * 1e-25;

namespace {

/**
 * Scales the periodic box and the centroids of molecules. See TorsionMonteCarloIntegrator::addVolumeMove().
 */
class VolumeMove : public DeclaredMove<VolumeMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    string getSubject() const;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);
    bool changesVolume() const
    {
        return true;
    }
    double computeWork(TrialSession& trials);
    double computeLogRatio(TrialSession& trials);

private:
    int numMolecules = 0;
    /** The change of the logarithm of the volume in the last trial. */
    double logChange = 0;
};

} // namespace

string VolumeMove::getSubject() const
{
    stringstream subject;
    subject.imbue(locale::classic());
    subject << getKind().name << " at " << pressure << " bar";
    return subject.str();
}

void VolumeMove::bind(const LinkStructure& structure, const string& name)
{
    if (!structure.isPeriodic())
        throw OpenMMException(name + " changes the volume of the periodic box, but the StericExclusionForce has none; "
                                     "call its setUsesPeriodicBoundaryConditions()");
    numMolecules = structure.getMolecules().size();
    for (size_t particle = 0; particle < structure.getParticleLinks().size(); particle++)
        if (structure.getMolecules()[structure.getParticleMolecule(particle)].fixed)
            throw OpenMMException(name + " moves all molecules, but that of particle " + to_string(particle) +
                                  " has fixed particles and cannot move");
}

bool VolumeMove::draw(const TrialSession&, RandomNumberGenerator& random, Proposal& proposal)
{
    logChange = random.drawSymmetric(getScale() * maxChange);
    proposal.scaleBox(exp(logChange / 3));
    return true;
}

static double volumeOf(const BoxVectors& box)
{
    return box[0][0] * box[1][1] * box[2][2];
}

double VolumeMove::computeWork(TrialSession& trials)
{
    return pressure * BAR * (volumeOf(trials.getProposedBox()) - volumeOf(trials.getBox()));
}

double VolumeMove::computeLogRatio(TrialSession&)
{
    // A volume element of the centroids is proportional to V^N, and of V, whose logarithm is drawn uniformly, to V.

    return (numMolecules + 1) * logChange;
}

MOVE("volume", VolumeMove, VOLUME_MOVE)
