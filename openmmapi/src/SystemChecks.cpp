#include "openmmchaintree/internal/SystemChecks.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomIntegrator.h"
#include "openmm/MonteCarloAnisotropicBarostat.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/MonteCarloFlexibleBarostat.h"
#include "openmm/MonteCarloMembraneBarostat.h"
#include "openmm/OpenMMException.h"
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

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

/**
 * Throw an exception if a Force changes the periodic box, which rigid molecules and their distances know nothing of.
 */
static void checkNoBarostat(const System& system)
{
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force* force = &system.getForce(i);
        if (dynamic_cast<const MonteCarloBarostat*>(force) != NULL ||
            dynamic_cast<const MonteCarloAnisotropicBarostat*>(force) != NULL ||
            dynamic_cast<const MonteCarloMembraneBarostat*>(force) != NULL ||
            dynamic_cast<const MonteCarloFlexibleBarostat*>(force) != NULL)
            fail("the System has a barostat (force " + to_string(i) + ", " + force->getName() +
                 "), but periodic boundary conditions are not supported; remove it");
    }
}

/**
 * Throw an exception if a move could break a constraint.
 */
static void checkConstraints(const System& system, const LinkStructure& structure)
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

void ChainTreePlugin::checkSystem(const System& system, const LinkStructure& structure)
{
    checkNoBarostat(system);
    checkConstraints(system, structure);
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
