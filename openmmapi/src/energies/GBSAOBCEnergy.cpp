#include "openmm/GBSAOBCForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include <cmath>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** Constants of OpenMM without a parameter: nm, kJ nm / (mol e^2). */
static const double OFFSET = 0.009, PROBE_RADIUS = 0.14, COULOMB = 138.93545764438198;
static const double ALPHA = 1, BETA = 0.8, GAMMA = 4.85;

static string translateGBSAOBC(const GBSAOBCForce& force, const NativeForceKind::Setting& setting, EnergyTerms& terms)
{
    const bool isPeriodic = force.getNonbondedMethod() == GBSAOBCForce::CutoffPeriodic;
    if (isPeriodic && !setting.isPeriodic)
        return "its cutoff is periodic";
    const string reason = checkBornPartners(terms);
    if (!reason.empty())
        return reason;
    EnergyTerms::Born born = EnergyTerms::Born();
    born.force = setting.index;
    for (int i = 0; i < force.getNumParticles(); i++) {
        double charge, radius, scale;
        force.getParticleParameters(i, charge, radius, scale);
        born.charges.push_back(charge);
        born.radii.push_back(radius);
        born.offsetRadii.push_back(radius - OFFSET);
        born.scaledRadii.push_back(scale * (radius - OFFSET));
    }
    born.filled = born.rescaled = true;
    born.alphas.assign(force.getNumParticles(), ALPHA);
    born.betas.assign(force.getNumParticles(), BETA);
    born.gammas.assign(force.getNumParticles(), GAMMA);
    born.coulomb = COULOMB;
    born.soluteDielectric = force.getSoluteDielectric();
    born.solventDielectric = force.getSolventDielectric();
    born.surfaceEnergy = 4 * M_PI * force.getSurfaceAreaEnergy();
    born.probeRadius = PROBE_RADIUS;
    born.cutoff = numeric_limits<double>::infinity();
    born.periodic = isPeriodic;
    if (force.getNonbondedMethod() != GBSAOBCForce::NoCutoff) {
        born.cutoff = force.getCutoffDistance();
        born.shift = 1 / born.cutoff;
    }
    terms.born.push_back(born);
    return "";
}

static const NativeForceKind GBSA_OBC(translateGBSAOBC, copyForce, NativeForceKind::NeedsPairs);
