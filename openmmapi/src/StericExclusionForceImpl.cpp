#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/ChainTreeKernels.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include "openmmchaintree/internal/FlagGuard.h"
#include "openmmchaintree/internal/SystemChecks.h"
#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/Warnings.h"
#include <cmath>
#include <cstring>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** A torsion in a ring is not turned if the wanted change is at most this, in radians. */
static const double LEAST_CLOSED_CHANGE = 1e-9;

static void fail(const string& message)
{
    throw OpenMMException("StericExclusionForce: " + message);
}

static bool isFinite(const Vec3& vector)
{
    return isfinite(vector[0]) && isfinite(vector[1]) && isfinite(vector[2]);
}

static void checkFinite(const vector<Vec3>& positions)
{
    for (size_t i = 0; i < positions.size(); i++)
        if (!isFinite(positions[i]))
            fail("the position of particle " + to_string(i) + " is not finite");
}

/**
 * Compare numbers by their bits, which finds every change and distinguishes NaNs.
 */
static bool haveSameBits(const vector<Vec3>& a, const vector<Vec3>& b)
{
    static_assert(sizeof(Vec3) == 3 * sizeof(double), "a Vec3 must be three numbers and nothing else");
    return a.size() == b.size() && (a.empty() || memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0);
}

/**
 * Warn if another Force uses periodic images, which this one ignores.
 */
static void warnOfPeriodicForces(const System& system)
{
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force& force = system.getForce(i);
        bool isPeriodic = false;
        try {
            isPeriodic = force.usesPeriodicBoundaryConditions();
        }
        catch (const OpenMMException&) {
            // Some Forces do not know.
        }
        if (isPeriodic) {
            warn("StericExclusionForce: the System is periodic (force " + to_string(i) + ", " + force.getName() +
                 "), but spheres ignore periodic images, since the StericExclusionForce does not use periodic boundary "
                 "conditions: only particles that are near each other as their positions stand can clash");
            return;
        }
    }
}

StericExclusionForceImpl::StericExclusionForceImpl(const StericExclusionForce& owner) :
    CustomCPPForceImpl(owner), owner(owner), life(make_shared<char>()), lock(make_shared<ContextLock>()),
    isInitialized(false), scene(NULL), trialScene(NULL), newest(NULL), otherIsBehind(false),
    trialSpheresWereFree(false), energyTermsOwner(NULL), proposalIsFree(false), settingPositions(false),
    energyIsSuppressed(false), hasVirtualSites(false), leastBoxWidth(0), hasWarnedOfNarrowBox(false)
{
}

void StericExclusionForceImpl::initialize(ContextImpl& context)
{
    const System& system = context.getSystem();
    if (owner.getNumParticles() != system.getNumParticles())
        fail("it has " + to_string(owner.getNumParticles()) + " particles, but the System has " +
             to_string(system.getNumParticles()));
    for (int i = 0; i < owner.getNumExclusions(); i++) {
        int particle1, particle2;
        owner.getExclusionParticles(i, particle1, particle2);
        string name = "exclusion " + to_string(i);
        checkIndex(particle1, system.getNumParticles(), "particle", "StericExclusionForce: " + name);
        checkIndex(particle2, system.getNumParticles(), "particle", "StericExclusionForce: " + name);
        if (particle1 == particle2)
            fail(name + " excludes particle " + to_string(particle1) + " from itself");
    }
    for (int i = 0; i < system.getNumParticles(); i++)
        hasVirtualSites = hasVirtualSites || system.isVirtualSite(i);
    leastBoxWidth = 2 * findLargestCutoff(system);
    original.reset(new StericExclusionForce(owner));
    structure.reset(new LinkStructure(system, owner, displacesParticles(context.getIntegrator())));
    velocities.reset(new VelocityTurner(system, *structure));

    kernel = createKernel(context);
    scene = trialScene = newest = &kernel.getAs<CalcStericExclusionForceKernel>().getScene();
    limits.setScene(*scene);
    CustomCPPForceImpl::initialize(context);
    if (scene->isPeriodic())
        scene->setBox(getBoxVectors(context));
    else
        warnOfPeriodicForces(system);
    isInitialized = true;
}

Kernel StericExclusionForceImpl::createKernel(ContextImpl& context) const
{
    // The kernel needs no Context, so the Reference platform's serves platforms without a kernel.

    const vector<string> kernelNames = {CalcStericExclusionForceKernel::Name()};
    Platform* platform = &context.getPlatform();
    if (!platform->supportsKernels(kernelNames))
        platform = &Platform::getPlatformByName("Reference");
    if (!platform->supportsKernels(kernelNames))
        fail("its kernel is missing; load the plugin library OpenMMChainTreeReference before creating a Context");
    Kernel created = platform->createKernel(CalcStericExclusionForceKernel::Name(), context);
    created.getAs<CalcStericExclusionForceKernel>().initialize(*original, *structure);
    return created;
}

unique_ptr<Scene> StericExclusionForceImpl::createScene(const StericExclusionForce& spheres) const
{
    unique_ptr<Scene> created(new Scene(spheres, *structure));
    if (created->isPeriodic())
        created->setBox(newest->getBox());
    return created;
}

void StericExclusionForceImpl::requireInitialized() const
{
    if (!isInitialized)
        fail("the Context is not complete, because reinitialize() threw an exception; correct its cause and call "
             "reinitialize() again");
}

vector<pair<int, int>> StericExclusionForceImpl::getBondedParticles() const
{
    vector<pair<int, int>> bonds(owner.getNumBonds());
    for (int i = 0; i < owner.getNumBonds(); i++)
        owner.getBondParticles(i, bonds[i].first, bonds[i].second);
    for (int i = 0; i < owner.getNumClosures(); i++) {
        int particle1, particle2, particle3, particle4;
        owner.getClosureParticles(i, particle1, particle2, particle3, particle4);
        bonds.push_back(make_pair(particle2, particle3));
    }
    return bonds;
}

void StericExclusionForceImpl::updateParametersInContext(ContextImpl& context)
{
    if (!owner.hasStructureOf(*original))
        fail("its particles, bonds, torsions, ball joints, closures or exclusions differ from those that the Context "
             "was created with; reinitialize the Context");
    kernel.getAs<CalcStericExclusionForceKernel>().copyParametersToContext(context, owner);
    limits.overlapsWereChanged();
    context.systemChanged();
}

// ---- Positions and limits ----

/**
 * Take notice of the Context's positions.
 */
void StericExclusionForceImpl::updatePositions(ContextImpl& context)
{
    context.getPositions(buffer);
    if (agreedPositions.empty()) {
        // An evaluation of no forces is cheap and throws the usual exception if positions were never set; on GPU
        // platforms they are undefined then. The CPU platform also throws if they are not finite, but names no
        // particle.

        try {
            context.calcForcesAndEnergy(false, false, 0);
        }
        catch (const OpenMMException&) {
            if (context.getPlatform().getName() == "CPU")
                checkFinite(buffer);
            throw;
        }
        checkFinite(buffer);
    }
    adoptPositions(context, buffer);
}

void StericExclusionForceImpl::adoptPositions(ContextImpl& context, const vector<Vec3>& positions)
{
    const BoxVectors box = getBoxVectors(context);
    const bool areNew = !haveSameBits(positions, agreedPositions);
    if (areNew || !newest->hasBox(box)) {
        newest->setPositions(positions, box);
        agreedPositions = positions;
        stateWasChanged(*newest);
        if (areNew)
            limits.particlesWereMoved();
        else
            limits.overlapsWereChanged();
    }
    limits.positionsWereSeen(context.getStepCount());
}

Scene& StericExclusionForceImpl::queryState(ContextImpl& context)
{
    updatePositions(context);
    bringUpToDate(*scene);
    return *scene;
}

void StericExclusionForceImpl::updateContextState(ContextImpl& context, bool& forcesInvalid)
{
    ContextUse use(lock, ContextLock::OpenMM);
    limits.stepBegins(context.getStepCount());
    HelperAdmission admission(*lock);
    if (velocities->beginStep(context))
        forcesInvalid = true;
}

void StericExclusionForceImpl::positionsWereSet(ContextImpl& context, const vector<Vec3>& restored)
{
    if (settingPositions)
        return;
    if (!restored.empty()) {
        context.getPositions(buffer);
        if (haveSameBits(buffer, restored))
            return;
    }
    limits.restart();
    velocities->forgetPause();
}

void StericExclusionForceImpl::computeVirtualSites(ContextImpl& context)
{
    if (hasVirtualSites)
        context.computeVirtualSites();
}

void StericExclusionForceImpl::takeNoticeOfPositions(ContextImpl& context)
{
    computeVirtualSites(context);
    updatePositions(context);
    limits.noStepIsUnderWay(); // no other Integrator is in a step when trials begin
}

void StericExclusionForceImpl::setContextPositions(ContextImpl& context, const vector<Vec3>& positions,
                                                   const BoxVectors& box)
{
    FlagGuard guard(settingPositions);
    if (scene->isPeriodic() && getBoxVectors(context) != box)
        context.setPeriodicBoxVectors(box[0], box[1], box[2]);
    context.setPositions(positions);
    computeVirtualSites(context);
}

/**
 * Move the Context to a scene's state.
 */
void StericExclusionForceImpl::showState(ContextImpl& context, Scene& shown)
{
    // A platform may round positions, so agreedPositions are what the Context returns, or empty if this fails.

    agreedPositions.clear();
    setContextPositions(context, shown.followState(), shown.getBox());
    context.getPositions(agreedPositions);
}

// ---- Scaling of the box ----

/**
 * Get whether no cutoff of a Force keeps a trial from scaling the box of a scene.
 */
bool StericExclusionForceImpl::mayScaleBox(const Scene& scaled, double factor) const
{
    const BoxVectors& box = scaled.getBox();
    return factor == 1 || factor * min(box[0][0], min(box[1][1], box[2][2])) >= leastBoxWidth;
}

void StericExclusionForceImpl::warnOfNarrowBox()
{
    if (hasWarnedOfNarrowBox)
        return;
    hasWarnedOfNarrowBox = true;
    warn("TorsionMonteCarloIntegrator: a trial would make the periodic box narrower than twice the largest cutoff of a "
         "Force, or than twice the distance at which spheres clash; such volumes are not sampled");
}

// ---- Two scenes ----

void StericExclusionForceImpl::setTrialSpheres(const CoreSpheres& spheres)
{
    Scene* wanted = scene;
    if (!spheres.radii.empty()) {
        if (!(cores == spheres)) {
            StericExclusionForce replaced(*original);
            replaced.setOverlapTolerance(0);
            replaced.setHydrogenBondAllowance(0);
            for (size_t i = 0; i < spheres.radii.size(); i++)
                replaced.setParticleParameters(i, spheres.radii[i], StericExclusionForce::NoHydrogenBond);
            for (auto& exclusion : spheres.exclusions)
                replaced.addExclusion(exclusion[0], exclusion[1]);
            unique_ptr<Scene> created = createScene(replaced);
            setTrialScene(*created);
            coreScene = std::move(created);
            cores = spheres;
        }
        wanted = coreScene.get();
    }
    setTrialScene(*wanted);
}

void StericExclusionForceImpl::setTrialScene(Scene& wanted)
{
    if (trialScene == &wanted)
        return;
    if (!agreedPositions.empty()) {
        // The numbers of a checkpoint give the same bits to a run that resumes from one.

        vector<double> state;
        newest->getState(state);
        wanted.setState(state);
        if (&wanted == scene)
            limits.restart();
    }
    trialScene = &wanted;
    stateWasChanged(wanted);
}

bool StericExclusionForceImpl::trialSpheresAreFree()
{
    if (trialScene == scene)
        return false;
    trialSpheresWereFree = trialSpheresWereFree || !trialScene->hasClash();
    return trialSpheresWereFree;
}

/**
 * Give a scene the state if the other one has a newer state. This comes after updatePositions().
 */
void StericExclusionForceImpl::bringUpToDate(Scene& behind)
{
    if (!otherIsBehind || newest == &behind || agreedPositions.empty())
        return;
    behind.setPositions(agreedPositions, newest->getBox());
    otherIsBehind = false;
    if (&behind == scene)
        limits.restart();
}

/**
 * Take notice that a scene's state has changed, and that its spheres may overlap now.
 */
void StericExclusionForceImpl::stateWasChanged(Scene& changed)
{
    newest = &changed;
    otherIsBehind = (trialScene != scene);
    trialSpheresWereFree = false;
}

// ---- Checkpoints ----

void StericExclusionForceImpl::getLimits(vector<pair<int, int>>& pairs, vector<double>& limits)
{
    scene->getLimits(pairs, limits);
}

void StericExclusionForceImpl::setLimits(ContextImpl& context, const vector<pair<int, int>>& pairs,
                                         const vector<double>& limits)
{
    queryState(context);
    this->limits.setLimits(pairs, limits);
}

void StericExclusionForceImpl::createCheckpoint(CheckpointWriter& writer)
{
    // A continued run must have the same bits as a run from this checkpoint, which does not hold the pause.

    velocities->forgetPause();

    // Limits belong to the force's own spheres, so its scene must have the state.

    bringUpToDate(*scene);
    vector<double> state;
    newest->getState(state);
    writer.write(state);
    limits.writeLimits(writer);
    writer.write(agreedPositions);
    limits.writeStep(writer);
}

vector<int> StericExclusionForceImpl::describeStructure() const
{
    vector<int> description = structure->describe();
    if (original->usesPeriodicBoundaryConditions())
        description.push_back(1);
    if (structure->isFlexible())
        description.push_back(2);
    return description;
}

void StericExclusionForceImpl::checkCheckpoint(ContextImpl& context, const KeptGeometry& kept) const
{
    kept.check(*createScene(), context.getSystem());
}

bool StericExclusionForceImpl::havePositionsOf(ContextImpl& context, const KeptGeometry& kept) const
{
    vector<Vec3> positions;
    context.getPositions(positions);
    return kept.checkPositions(positions, getBoxVectors(context), context.getSystem(), *structure, *original);
}

void StericExclusionForceImpl::loadCheckpoint(const KeptGeometry& kept)
{
    agreedPositions.clear();
    scene->setState(kept.state);
    stateWasChanged(*scene);
    if (trialScene != scene) {
        trialScene->setState(kept.state);
        otherIsBehind = false;
    }
    limits.restore(kept.limits, !kept.state.empty());
    agreedPositions = kept.agreedPositions;
}

// ---- Energy ----

double StericExclusionForceImpl::calcForcesAndEnergy(ContextImpl& context, bool includeForces, bool includeEnergy,
                                                     int groups)
{
    requireInitialized();
    ContextUse use(lock, ContextLock::OpenMM);

    // The energy of other Forces does not need this force. GPU platforms still call computeForce().

    if (!hasEnergy(context))
        return 0;
    return CustomCPPForceImpl::calcForcesAndEnergy(context, includeForces, includeEnergy, groups);
}

double StericExclusionForceImpl::computeForce(ContextImpl& context, const vector<Vec3>& positions, vector<Vec3>& forces)
{
    if (!hasEnergy(context)) {
        forces.assign(forces.size(), Vec3());
        return 0;
    }

    // On GPU platforms this runs on another thread than the call that needs the forces.

    unique_ptr<ContextUse> use;
    if (!lock->helperMayPass())
        use.reset(new ContextUse(lock, ContextLock::OpenMM));
    adoptPositions(context, positions);
    bringUpToDate(*scene);
    return kernel.getAs<CalcStericExclusionForceKernel>().execute(forces);
}

/**
 * Get whether this force has an energy: not in the energy of other Forces, and not if an integrator's steric mode is
 * Off.
 */
bool StericExclusionForceImpl::hasEnergy(ContextImpl& context) const
{
    return !energyIsSuppressed && !hasSpheresOff(context.getIntegrator());
}

double StericExclusionForceImpl::computeOtherEnergy(ContextImpl& context, int groups)
{
    FlagGuard guard(energyIsSuppressed);
    return context.calcForcesAndEnergy(false, true, groups);
}

void StericExclusionForceImpl::setEnergyTerms(const EnergyTerms& terms, const void* owner)
{
    energyTermsOwner = NULL;
    trialScene->getEnergy().setTerms(terms);
    energyTermsOwner = owner;
}

// ---- Operation counts ----

void StericExclusionForceImpl::getTraversalStatistics(long long& queries, long long& volumeTests,
                                                      long long& particleTests, long long& nodesUpdated)
{
    queries = volumeTests = particleTests = nodesUpdated = 0;
    scene->addTraversalStatistics(queries, volumeTests, particleTests, nodesUpdated);
    if (trialScene != scene)
        trialScene->addTraversalStatistics(queries, volumeTests, particleTests, nodesUpdated);
}

void StericExclusionForceImpl::resetTraversalStatistics()
{
    scene->resetTraversalStatistics();
    trialScene->resetTraversalStatistics();
}

// ---- Trials of users ----

/**
 * Throw an exception unless all joints exist, are different, and lie in no ring of a closure.
 *
 * @param kind    the name of such a joint, as "torsion"
 * @param caller  the function that was called, as "proposeTorsions()"
 */
static void checkJoints(const vector<int>& joints, const vector<int>& links, const LinkStructure& structure,
                        const string& kind, const string& caller)
{
    vector<bool> isNamed(links.size(), false);
    for (int joint : joints) {
        checkIndex(joint, links.size(), kind, "StericExclusionForce: " + caller);
        structure.checkNoClosure(links[joint], "StericExclusionForce: " + caller);
        if (isNamed[joint])
            fail(caller + " names " + kind + " " + to_string(joint) + " twice");
        isNamed[joint] = true;
    }
}

/**
 * Propose and test a trial of a user, which stays open. Returns whether it is free.
 */
bool StericExclusionForceImpl::propose(ContextImpl& context, const Proposal& proposal)
{
    TrialSession session(*this, context, *scene, TrialSession::ApplyLimits);
    session.propose(proposal);
    const bool isFree = session.test();
    session.leaveOpen();
    return isFree;
}

bool StericExclusionForceImpl::proposeTorsions(ContextImpl& context, const vector<int>& torsions,
                                               const vector<double>& changes)
{
    if (torsions.size() != changes.size())
        fail("proposeTorsions() was given " + to_string(torsions.size()) + " torsions, but " +
             to_string(changes.size()) + " changes");
    checkJoints(torsions, structure->getTorsionLinks(), *structure, "torsion", "proposeTorsions()");
    Proposal proposal;
    for (size_t i = 0; i < torsions.size(); i++) {
        if (!isfinite(changes[i]))
            fail("the change of torsion " + to_string(torsions[i]) + " is not finite");
        proposal.addTorsion(torsions[i], changes[i]);
    }
    return propose(context, proposal);
}

bool StericExclusionForceImpl::proposeBallRotations(ContextImpl& context, const vector<int>& ballJoints,
                                                    const vector<Vec3>& rotations)
{
    if (ballJoints.size() != rotations.size())
        fail("proposeBallRotations() was given " + to_string(ballJoints.size()) + " ball joints, but " +
             to_string(rotations.size()) + " rotations");
    checkJoints(ballJoints, structure->getBallJointLinks(), *structure, "ball joint", "proposeBallRotations()");
    Proposal proposal;
    for (size_t i = 0; i < ballJoints.size(); i++) {
        if (!isFinite(rotations[i]))
            fail("the rotation of ball joint " + to_string(ballJoints[i]) + " is not finite");
        proposal.addBallRotation(ballJoints[i], rotations[i]);
    }
    return propose(context, proposal);
}

bool StericExclusionForceImpl::proposeRigidMotion(ContextImpl& context, int particle, const Vec3& rotation,
                                                  const Vec3& translation)
{
    checkIndex(particle, original->getNumParticles(), "particle", "StericExclusionForce: proposeRigidMotion()");
    if (!isFinite(rotation) || !isFinite(translation))
        fail("the rotation and translation given to proposeRigidMotion() must be finite");
    int molecule = structure->getParticleMolecule(particle);
    if (structure->getMolecules()[molecule].fixed)
        fail("the molecule of particle " + to_string(particle) + " has fixed particles and cannot move");
    return propose(context, Proposal().addRigidMotion(molecule, rotation, translation));
}

/**
 * Throw an exception unless a trial is open.
 */
void StericExclusionForceImpl::requireProposal() const
{
    if (!scene->hasTrial())
        fail("there is no open proposal; propose a trial first, after the last change of positions");
}

Scene& StericExclusionForceImpl::queryTrial(ContextImpl& context)
{
    queryState(context);
    requireProposal();
    return *scene;
}

void StericExclusionForceImpl::acceptProposal(ContextImpl& context)
{
    TrialSession session(*this, context, *scene, TrialSession::ApplyLimits);
    requireProposal();
    session.accept();
    session.end();
}

void StericExclusionForceImpl::rejectProposal()
{
    scene->reject();
}

// ---- Torsion angles ----

void StericExclusionForceImpl::getTorsionAngles(ContextImpl& context, vector<double>& angles)
{
    queryState(context);
    angles.resize(original->getNumTorsions());
    for (int i = 0; i < (int)angles.size(); i++)
        angles[i] = scene->getTorsionAngle(i);
}

void StericExclusionForceImpl::setTorsionAngles(ContextImpl& context, const vector<double>& angles)
{
    if ((int)angles.size() != original->getNumTorsions())
        fail("setTorsionAngles() was given " + to_string(angles.size()) + " angles, but there are " +
             to_string(original->getNumTorsions()) + " torsions");
    for (int i = 0; i < (int)angles.size(); i++)
        if (!isfinite(angles[i]))
            fail("the angle of torsion " + to_string(i) + " is not finite");
    TrialSession session(*this, context, *scene, TrialSession::IgnoreLimits);
    Proposal proposal;
    for (int i = 0; i < (int)angles.size(); i++) {
        const double present = scene->getTorsionAngle(i), change = remainder(angles[i] - present, 2 * M_PI);
        if (structure->getLinkClosure(structure->getTorsionLinks()[i]) != -1) {
            // Angles that were read and are set again may differ by rounding.

            if (fabs(change) > LEAST_CLOSED_CHANGE)
                structure->checkNoClosure(structure->getTorsionLinks()[i], "StericExclusionForce: setTorsionAngles()");
        }
        else if (angles[i] != present)
            proposal.addTorsion(i, change);
    }
    session.propose(proposal);
    session.accept();
    session.end();
    limits.restart();
}
