#include "openmmchaintree/internal/SystemChecks.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomGBForce.h"
#include "openmm/CustomHbondForce.h"
#include "openmm/CustomIntegrator.h"
#include "openmm/CustomManyParticleForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/GayBerneForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/MonteCarloAnisotropicBarostat.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/MonteCarloFlexibleBarostat.h"
#include "openmm/MonteCarloMembraneBarostat.h"
#include "openmm/NonbondedForce.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/Warnings.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** The largest change of a distance by rounding to three decimals of ångström, in nm: sqrt(3) * 1e-4. */
static const double ROUNDING = 1.74e-4;

static void fail(const string& message)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: " + message);
}

StericExclusionForceImpl& ChainTreePlugin::findStericExclusionForce(ContextImpl& context)
{
    StericExclusionForceImpl* found = NULL;
    for (ForceImpl* impl : context.getForceImpls()) {
        StericExclusionForceImpl* candidate = dynamic_cast<StericExclusionForceImpl*>(impl);
        if (candidate != NULL && found != NULL)
            fail("the System has more than one StericExclusionForce");
        if (candidate != NULL)
            found = candidate;
    }
    if (found == NULL)
        fail("the System has no StericExclusionForce");
    return *found;
}

bool ChainTreePlugin::isBarostat(const Force& force)
{
    return dynamic_cast<const MonteCarloBarostat*>(&force) != NULL ||
           dynamic_cast<const MonteCarloAnisotropicBarostat*>(&force) != NULL ||
           dynamic_cast<const MonteCarloMembraneBarostat*>(&force) != NULL ||
           dynamic_cast<const MonteCarloFlexibleBarostat*>(&force) != NULL;
}

/**
 * Throw an exception if there is a barostat, with a reason and a remedy.
 */
static void checkNoBarostat(const System& system, const string& reason)
{
    for (int i = 0; i < system.getNumForces(); i++)
        if (isBarostat(system.getForce(i)))
            fail("the System has a barostat (force " + to_string(i) + ", " + system.getForce(i).getName() + "), " +
                 reason);
}

void ChainTreePlugin::checkHardSpheres(const System& system)
{
    checkNoBarostat(system, "which ignores hard spheres; call setStericMode(Soft) or Off, or remove it");
}

void ChainTreePlugin::checkVolumeMoves(const System& system, double temperature)
{
    checkNoBarostat(system, "which changes the volume, as a volume move does; remove one of them");
    if (temperature == 0)
        fail("a volume move needs a temperature above 0");
}

/**
 * Get the cutoff of a Force of one of these classes, or 0.
 */
template <class... Forces>
static double findCutoff(const Force& force)
{
    double cutoff = 0;
    auto measure = [&](auto* one) {
        if (one != NULL && one->usesPeriodicBoundaryConditions())
            cutoff = one->getCutoffDistance();
    };
    (measure(dynamic_cast<const Forces*>(&force)), ...);
    return cutoff;
}

double ChainTreePlugin::findLargestCutoff(const System& system)
{
    double largest = 0;
    for (int i = 0; i < system.getNumForces(); i++)
        largest =
            max(largest, findCutoff<NonbondedForce, CustomNonbondedForce, CustomGBForce, GBSAOBCForce, CustomHbondForce,
                                    CustomManyParticleForce, GayBerneForce>(system.getForce(i)));
    return largest;
}

vector<pair<int, int>> ChainTreePlugin::findConstraintsBetweenLinks(const System& system,
                                                                    const LinkStructure& structure)
{
    vector<pair<int, int>> found;
    for (int i = 0; i < system.getNumConstraints(); i++) {
        int particle1, particle2;
        double distance;
        system.getConstraintParameters(i, particle1, particle2, distance);
        if (!structure.areKeptTogether(particle1, particle2))
            found.push_back(make_pair(particle1, particle2));
    }
    return found;
}

void ChainTreePlugin::checkConstraints(const System& system, const LinkStructure& structure)
{
    for (const pair<int, int>& particles : findConstraintsBetweenLinks(system, structure)) {
        const int particle1 = particles.first, particle2 = particles.second;
        string name = "the constraint between particles " + to_string(particle1) + " and " + to_string(particle2) +
                      " cannot hold: ";
        if (structure.getParticleMolecule(particle1) != structure.getParticleMolecule(particle2))
            fail(name + "they are in different molecules of the StericExclusionForce; add a bond between them");
        const string joint = structure.findJointBetween(particle1, particle2);
        if (!joint.empty())
            fail(name + joint + " moves them relative to each other");
    }
}

void ChainTreePlugin::warnOfViolatedConstraints(const System& system, const vector<Vec3>& positions)
{
    int count = 0;
    stringstream message;
    for (int i = 0; i < system.getNumConstraints(); i++) {
        int particle1, particle2;
        double distance;
        system.getConstraintParameters(i, particle1, particle2, distance);
        const Vec3 apart = positions[particle2] - positions[particle1];
        const double present = sqrt(apart.dot(apart));
        if (fabs(present - distance) <= ROUNDING)
            continue;
        if (count++ == 0)
            message << "TorsionMonteCarloIntegrator: particles " << particle1 << " and " << particle2 << " are "
                    << present << " nm apart, though a constraint of " << distance << " nm holds them";
    }
    if (count == 0)
        return;
    if (count > 1)
        message << ", and " << count - 1 << " more constraints are violated";
    message << ": moves keep such distances as they are; call Context::applyConstraints() first";
    warn(message.str());
}

vector<const Integrator*> ChainTreePlugin::findIntegrators(const Integrator& integrator)
{
    auto compound = dynamic_cast<const CompoundIntegrator*>(&integrator);
    if (compound == NULL)
        return {&integrator};
    vector<const Integrator*> found;
    for (int i = 0; i < compound->getNumIntegrators(); i++)
        for (const Integrator* one : findIntegrators(compound->getIntegrator(i)))
            found.push_back(one);
    return found;
}

template <class IsSuch>
static bool hasIntegrator(const Integrator& integrator, IsSuch isSuch)
{
    const vector<const Integrator*> integrators = findIntegrators(integrator);
    return any_of(integrators.begin(), integrators.end(), [&](const Integrator* one) {
        return isSuch(*one);
    });
}

bool ChainTreePlugin::isOfDynamics(const Integrator& integrator)
{
    return dynamic_cast<const TorsionMonteCarloIntegrator*>(&integrator) == NULL;
}

bool ChainTreePlugin::hasDynamics(const Integrator& integrator)
{
    return hasIntegrator(integrator, isOfDynamics);
}

/**
 * The same for an Integrator that is no CompoundIntegrator.
 */
static bool isSilent(const Integrator& integrator)
{
    auto custom = dynamic_cast<const CustomIntegrator*>(&integrator);
    if (custom == NULL)
        return false;
    for (int i = 0; i < custom->getNumComputations(); i++) {
        CustomIntegrator::ComputationType type;
        string variable, expression;
        custom->getComputationStep(i, type, variable, expression);
        if (type == CustomIntegrator::UpdateContextState)
            return false;
    }
    return true;
}

bool ChainTreePlugin::hasSilentSteps(const Integrator& integrator)
{
    return hasIntegrator(integrator, isSilent);
}

bool ChainTreePlugin::displacesParticles(const Integrator& integrator)
{
    return hasIntegrator(integrator, [](const Integrator& one) {
        auto sampler = dynamic_cast<const TorsionMonteCarloIntegrator*>(&one);
        return sampler != NULL && sampler->displacesParticles();
    });
}

bool ChainTreePlugin::hasSpheresOff(const Integrator& integrator)
{
    return hasIntegrator(integrator, [](const Integrator& one) {
        auto sampler = dynamic_cast<const TorsionMonteCarloIntegrator*>(&one);
        return sampler != NULL && sampler->hasSpheresOff();
    });
}
