#include "openmmchaintree/internal/VelocityTurner.h"
#include "ctvelocities.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/Warnings.h"
#include <algorithm>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Name the first constraint that a joint turns otherwise than about its own line, and what to do. Returns nothing if
 * there is none.
 */
static string findTurnedConstraint(const System& system, const LinkStructure& structure)
{
    for (int i = 0; i < system.getNumConstraints(); i++) {
        int particle1, particle2;
        double distance;
        system.getConstraintParameters(i, particle1, particle2, distance);
        if (structure.areKeptTogether(particle1, particle2))
            continue;
        const string name = "the constraint between particles " + to_string(particle1) + " and " + to_string(particle2);
        const bool isInMolecule =
            (structure.getParticleMolecule(particle1) == structure.getParticleMolecule(particle2));
        const string joint = isInMolecule ? structure.findJointTurning(particle1, particle2) : "two molecules";
        if (!joint.empty())
            return name + " lies across " + joint +
                   ", and velocities turned with their links would break it; remove one of them, or let no dynamics "
                   "take turns with Monte Carlo";
    }
    return "";
}

VelocityTurner::VelocityTurner(const System& system, const LinkStructure& structure) :
    particleLinks(structure.getParticleLinks()), keepsMomentum(false), refusal(findTurnedConstraint(system, structure)),
    dynamicsIsExpected(true), mayHaveVelocities(true), hasWarned(false), hasBegun(false)
{
    for (int i = 0; i < system.getNumParticles(); i++)
        masses.push_back(system.getParticleMass(i));
    for (int i = 0; i < system.getNumForces(); i++)
        keepsMomentum |= (dynamic_cast<const CMMotionRemover*>(&system.getForce(i)) != NULL);
}

void VelocityTurner::expectNoDynamics()
{
    dynamicsIsExpected = false;
    mayHaveVelocities = false;
}

void VelocityTurner::requireTurnable() const
{
    if (!refusal.empty())
        throw OpenMMException("StericExclusionForce: " + refusal);
}

void VelocityTurner::velocitiesWereSet()
{
    mayHaveVelocities = true;
}

/**
 * Get whether the velocities that there are can be turned. If not, this is an error or a warning.
 */
bool VelocityTurner::canBeTurned()
{
    if (refusal.empty())
        return true;
    if (dynamicsIsExpected)
        requireTurnable();
    if (!hasWarned) {
        hasWarned = true;
        warn("StericExclusionForce: velocities are not turned with links: " + refusal);
    }
    return false;
}

bool VelocityTurner::findVelocities(ContextImpl& context)
{
    if (!mayHaveVelocities)
        return false;
    context.getVelocities(velocities);
    const bool found = any_of(velocities.begin(), velocities.end(), [](const Vec3& velocity) {
        return velocity != Vec3();
    });
    mayHaveVelocities = found || dynamicsIsExpected;
    return found;
}

void VelocityTurner::begin(ContextImpl& context, CalcStericExclusionForceKernel& kernel)
{
    hasBegun = findVelocities(context) && canBeTurned();
    if (hasBegun)
        kernel.getOrientations(before);
}

static double (*rows(vector<array<double, 9>>& matrices))[9]
{
    return reinterpret_cast<double(*)[9]>(matrices.data());
}

void VelocityTurner::end(ContextImpl& context, CalcStericExclusionForceKernel& kernel)
{
    if (!hasBegun)
        return;
    hasBegun = false;
    kernel.getOrientations(turns);
    if (!ctFindTurns(turns.size(), rows(before), rows(turns)))
        return;
    double* numbers = reinterpret_cast<double*>(velocities.data());
    if (keepsMomentum)
        ctTurnVelocitiesKeepingMomentum(masses.size(), particleLinks.data(), rows(turns), masses.data(), numbers);
    else
        ctTurnVelocities(masses.size(), particleLinks.data(), rows(turns), numbers);
    context.setVelocities(velocities);
}
