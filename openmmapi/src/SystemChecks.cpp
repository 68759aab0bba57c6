#include "openmmchaintree/internal/SystemChecks.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomIntegrator.h"
#include "openmm/MonteCarloAnisotropicBarostat.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/MonteCarloFlexibleBarostat.h"
#include "openmm/MonteCarloMembraneBarostat.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/Warnings.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <cmath>
#include <sstream>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** What three decimals of ångström can change a distance by, in nm: sqrt(3) * 1e-4. */
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

void ChainTreePlugin::checkHardSpheres(const System& system)
{
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force* force = &system.getForce(i);
        if (isBarostat(*force))
            fail("the System has a barostat (force " + to_string(i) + ", " + force->getName() +
                 "), which knows nothing of hard spheres; call setStericMode(Soft) or Off, or remove it");
    }
}

void ChainTreePlugin::checkConstraints(const System& system, const LinkStructure& structure)
{
    for (int i = 0; i < system.getNumConstraints(); i++) {
        int particle1, particle2;
        double distance;
        system.getConstraintParameters(i, particle1, particle2, distance);
        if (structure.areKeptTogether(particle1, particle2))
            continue;
        string name = "the constraint between particles " + to_string(particle1) + " and " + to_string(particle2) +
                      " cannot hold: ";
        if (structure.getParticleMolecule(particle1) != structure.getParticleMolecule(particle2))
            fail(name + "they are in different molecules of the StericExclusionForce; add a bond between them");
        const string joint = structure.findJointBetween(particle1, particle2);
        if (!joint.empty())
            fail(name + joint + " moves them relative to each other");
    }
}

bool ChainTreePlugin::warnOfViolatedConstraints(const System& system, const vector<Vec3>& positions)
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
        return false;
    if (count > 1)
        message << ", and " << count - 1 << " more constraints are violated";
    message << ": moves keep such distances as they are; call Context::applyConstraints() first";
    warn(message.str());
    return true;
}

bool ChainTreePlugin::hasDynamics(const Integrator& integrator)
{
    auto compound = dynamic_cast<const CompoundIntegrator*>(&integrator);
    if (compound == NULL)
        return dynamic_cast<const TorsionMonteCarloIntegrator*>(&integrator) == NULL;
    for (int i = 0; i < compound->getNumIntegrators(); i++)
        if (hasDynamics(compound->getIntegrator(i)))
            return true;
    return false;
}

bool ChainTreePlugin::hasSilentSteps(const Integrator& integrator)
{
    if (auto compound = dynamic_cast<const CompoundIntegrator*>(&integrator)) {
        for (int i = 0; i < compound->getNumIntegrators(); i++)
            if (hasSilentSteps(compound->getIntegrator(i)))
                return true;
        return false;
    }
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

bool ChainTreePlugin::hasSpheresOff(const Integrator& integrator)
{
    if (auto compound = dynamic_cast<const CompoundIntegrator*>(&integrator)) {
        for (int i = 0; i < compound->getNumIntegrators(); i++)
            if (hasSpheresOff(compound->getIntegrator(i)))
                return true;
        return false;
    }
    auto sampler = dynamic_cast<const TorsionMonteCarloIntegrator*>(&integrator);
    return sampler != NULL && sampler->hasSpheresOff();
}
