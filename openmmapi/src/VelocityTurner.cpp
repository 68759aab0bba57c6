#include "openmmchaintree/internal/VelocityTurner.h"
#include "ctvelocities.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/OpenMMException.h"
#include "openmm/reference/ReferencePlatform.h"
#include "openmmchaintree/internal/FlagGuard.h"
#include "openmmchaintree/internal/SystemChecks.h"
#include "openmmchaintree/internal/Warnings.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** Accelerations times this time, in ps, are about as large as velocities. */
static const double PUSH_TIME = 1e-3;

/** The tolerance of constraints of accelerations in double precision. */
static const double PUSH_TOLERANCE = 1e-10;

/**
 * Describe the first constraint that a joint turns other than about the constraint's own line, and what to do. Returns
 * an empty text if there is none.
 */
static string findTurnedConstraint(const System& system, const LinkStructure& structure)
{
    for (const pair<int, int>& particles : findConstraintsBetweenLinks(system, structure)) {
        const int particle1 = particles.first, particle2 = particles.second;
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
    particleLinks(structure.getParticleLinks()), hasConstraints(system.getNumConstraints() > 0), keepsMomentum(false),
    refusal(findTurnedConstraint(system, structure)), dynamicsIsExpected(true), mayHaveVelocities(true),
    hasWarned(false), isSetting(false), trialsFollow(false), hasPaused(false), hasBegun(false)
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
    if (isSetting)
        return;
    mayHaveVelocities = true;
    hasPaused = false;
}

/**
 * Get whether velocities can be turned. If not, this throws an exception or warns.
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

void VelocityTurner::begin(ContextImpl& context, Scene& scene)
{
    hasBegun = findVelocities(context) && canBeTurned();
    if (hasBegun)
        scene.getOrientations(before);
}

// ---- Turning ----

static double (*rows(vector<array<double, 9>>& matrices))[9]
{
    return reinterpret_cast<double(*)[9]>(matrices.data());
}

static double* numbers(vector<Vec3>& vectors)
{
    return reinterpret_cast<double*>(vectors.data());
}

/**
 * Turn vectors like velocities.
 */
void VelocityTurner::turn(vector<Vec3>& vectors) const
{
    if (keepsMomentum)
        ctTurnVelocitiesKeepingMomentum(masses.size(), particleLinks.data(), rows(turns), masses.data(),
                                        numbers(vectors));
    else
        ctTurnVelocities(masses.size(), particleLinks.data(), rows(turns), numbers(vectors));
}

void VelocityTurner::setVelocities(ContextImpl& context, const vector<Vec3>& values)
{
    FlagGuard guard(isSetting);
    context.setVelocities(values);
}

void VelocityTurner::end(ContextImpl& context, Scene& scene)
{
    if (!hasBegun)
        return;
    hasBegun = false;
    scene.getOrientations(turns);
    if (!ctFindTurns(turns.size(), rows(before), rows(turns)))
        return;
    turn(velocities);
    if (hasPaused)
        turn(push);
    setVelocities(context, velocities);
}

// ---- Between dynamics and trials ----

/**
 * Get the force groups of all Integrators of dynamics.
 */
static int findDynamicsGroups(const Integrator& integrator)
{
    int groups = 0;
    for (const Integrator* one : findIntegrators(integrator))
        if (isOfDynamics(*one))
            groups |= one->getIntegrationForceGroups();
    return groups;
}

/**
 * Compute accelerations that satisfy the constraints, at the positions in the Context. Returns false if they are all 0
 * or not finite. `velocities` must be the Context's, which are restored at the end.
 */
bool VelocityTurner::computePush(ContextImpl& context, vector<Vec3>& push)
{
    context.calcForcesAndEnergy(true, false, findDynamicsGroups(context.getIntegrator()));
    context.getForces(push);
    for (size_t i = 0; i < push.size(); i++)
        push[i] = masses[i] > 0 ? push[i] * (PUSH_TIME / masses[i]) : Vec3();
    if (hasConstraints) {
        const bool isDouble = dynamic_cast<ReferencePlatform*>(&context.getPlatform()) != NULL;
        setVelocities(context, push);
        try {
            context.applyVelocityConstraints(isDouble ? PUSH_TOLERANCE
                                                      : context.getIntegrator().getConstraintTolerance());
            context.getVelocities(push);
        }
        catch (...) {
            setVelocities(context, velocities);
            throw;
        }
        setVelocities(context, velocities);
    }
    double sum = 0;
    for (const Vec3& vector : push)
        sum += vector.dot(vector);
    return isfinite(sum) && sum > 0;
}

void VelocityTurner::pauseDynamics(ContextImpl& context)
{
    if (!hasPaused && dynamicsIsExpected && findVelocities(context))
        hasPaused = computePush(context, push);
}

bool VelocityTurner::beginStep(ContextImpl& context)
{
    if (trialsFollow || !hasPaused)
        return false;
    hasPaused = false;
    vector<Vec3> resumed;
    if (!findVelocities(context) || !computePush(context, resumed))
        return false;
    ctRotateVelocities(masses.size(), masses.data(), numbers(push), numbers(resumed), numbers(velocities));
    setVelocities(context, velocities);
    return true;
}
