#include "openmmchaintree/internal/ReciprocalSpace.h"
#include "openmm/internal/NonbondedForceImpl.h"
#include "openmm/Platform.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include <algorithm>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** A cutoff for direct space, which is not evaluated, so that lists of neighbors stay short. nm. */
static const double SHORT_CUTOFF = 0.3;

ReciprocalSpace::ReciprocalSpace(ContextImpl& context, const NonbondedForce& force, const vector<double>& charges) :
    outer(context), charges(charges), copy(new NonbondedForce())
{
    // OpenMM finds alpha and the grid by the default box of the System when it makes the Context.

    Vec3 box[3];
    context.getSystem().getDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
    system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
    system.addForce(copy);
    for (double charge : charges) {
        system.addParticle(1);
        copy->addParticle(charge, 1, 0);
    }
    copy->setNonbondedMethod(force.getNonbondedMethod());
    copy->setCutoffDistance(force.getCutoffDistance());
    copy->setEwaldErrorTolerance(force.getEwaldErrorTolerance());
    copy->setIncludeDirectSpace(false);
    copy->setUseDispersionCorrection(false);
    if (force.getNonbondedMethod() == NonbondedForce::PME) {
        double alpha;
        int sizes[3];
        NonbondedForceImpl::calcPMEParameters(context.getSystem(), force, alpha, sizes[0], sizes[1], sizes[2], false);
        copy->setPMEParameters(alpha, sizes[0], sizes[1], sizes[2]);
        copy->setCutoffDistance(min(SHORT_CUTOFF, force.getCutoffDistance()));
    }
}

/**
 * Make an Integrator for the inner Context.
 */
Integrator& ReciprocalSpace::createIntegrator()
{
    inner.reset();
    integrator.reset(new VerletIntegrator(0.001));
    return *integrator;
}

/**
 * Make the inner Context on the CPU platform. Returns false if there is none.
 */
bool ReciprocalSpace::createOnCPU(const string& threads)
{
    for (int i = 0; i < Platform::getNumPlatforms(); i++) {
        Platform& platform = Platform::getPlatform(i);
        if (platform.getName() != "CPU")
            continue;
        const map<string, string> properties = {{"Threads", threads}, {"DeterministicForces", "true"}};
        inner.reset(new Context(system, createIntegrator(), platform, properties));
        return true;
    }
    return false;
}

void ReciprocalSpace::createInner()
{
    const string platform = outer.getPlatform().getName();
    const bool isPME = (copy->getNonbondedMethod() == NonbondedForce::PME);
    if (platform == "CPU" && createOnCPU(outer.getPlatform().getPropertyValue(outer.getOwner(), "Threads")))
        return;
    if (platform == "Reference" && isPME && createOnCPU("1")) {
        // The CPU platform enlarges grids of some sizes, but tells it only once it has used them.

        evaluate();
        double alpha, innerAlpha;
        int sizes[3], innerSizes[3];
        copy->getPMEParameters(alpha, sizes[0], sizes[1], sizes[2]);
        copy->getPMEParametersInContext(*inner, innerAlpha, innerSizes[0], innerSizes[1], innerSizes[2]);
        if (equal(sizes, sizes + 3, innerSizes))
            return;
    }
    inner.reset(outer.createLinkedContext(system, createIntegrator()));
}

double ReciprocalSpace::evaluate()
{
    const BoxVectors box = getBoxVectors(outer);
    inner->setPeriodicBoxVectors(box[0], box[1], box[2]);
    outer.getPositions(positions);
    inner->setPositions(positions);
    return inner->getState(State::Energy).getPotentialEnergy();
}

double ReciprocalSpace::computeEnergy()
{
    if (!inner)
        createInner();
    return evaluate();
}
