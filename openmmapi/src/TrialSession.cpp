#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

TrialSession::TrialSession(StericExclusionForceImpl& force, ContextImpl& context,
                           CalcStericExclusionForceKernel& kernel, Limits limits) :
    force(force),
    context(context), kernel(kernel), limits(limits), ownsTrial(false), contextIsBehind(false),
    velocitiesAreBehind(false)
{
    force.takeNoticeOfPositions(context);
    force.bringUpToDate(kernel);
    if (limits == ApplyTrialSpheres && !force.trialSpheresAreFree())
        this->limits = IgnoreLimits;
}

TrialSession::~TrialSession()
{
    try {
        end();
    }
    catch (...) {
        // An exception is under way, or a Context that cannot be told positions has said so. Nothing is lost: the force
        // takes its state from the Context if the two do not agree.
    }
}

void TrialSession::end()
{
    if (ownsTrial)
        reject();
    if (contextIsBehind) {
        contextIsBehind = false;
        force.showState(context, kernel);
    }
    if (velocitiesAreBehind) {
        velocitiesAreBehind = false;
        force.velocities->end(context, kernel);
    }
}

void TrialSession::leaveOpen()
{
    ownsTrial = false;
}

/**
 * Bring limits up to date, if they apply. They start from the state before the trial.
 */
void TrialSession::updateLimits()
{
    if (limits == ApplyLimits)
        force.limits.update();
}

/**
 * Take notice that a trial was opened, of which nobody knows whether it is free.
 */
void TrialSession::ownTrial()
{
    ownsTrial = true;
    force.proposalIsFree = false;
    if (&kernel != force.engine)
        force.engine->rejectProposal(); // that of a user
}

void TrialSession::proposeTorsions(const vector<int>& torsions, const vector<double>& changes)
{
    updateLimits();
    kernel.proposeTorsions(torsions, changes);
    ownTrial();
}

void TrialSession::proposeBallRotations(const vector<int>& ballJoints, const vector<Vec3>& rotations)
{
    updateLimits();
    kernel.proposeBallRotations(ballJoints, rotations);
    ownTrial();
}

void TrialSession::proposeRigidMotion(int molecule, const Vec3& rotation, const Vec3& translation)
{
    updateLimits();
    kernel.proposeRigidMotion(molecule, rotation, translation);
    ownTrial();
}

bool TrialSession::isFree()
{
    force.proposalIsFree = limits == IgnoreLimits || kernel.isProposalFree();
    return force.proposalIsFree;
}

void TrialSession::accept()
{
    if (!velocitiesAreBehind)
        force.velocities->begin(context, kernel);
    velocitiesAreBehind = true;
    kernel.acceptProposal();
    ownsTrial = false;
    contextIsBehind = true;
    const bool spheresAreFree = (limits == ApplyTrialSpheres && force.proposalIsFree);
    force.stateWasChanged(kernel);
    force.trialSpheresWereFree = spheresAreFree;
    if (limits == ApplyLimits && !force.proposalIsFree)
        force.limits.restart();
}

void TrialSession::reject()
{
    kernel.rejectProposal();
    ownsTrial = false;
}

double TrialSession::computeSoftEnergy()
{
    vector<Vec3> forces(context.getSystem().getNumParticles());
    return kernel.computeEnergy(forces);
}

double TrialSession::computeOtherEnergy(int groups)
{
    return force.computeOtherEnergy(context, groups);
}

void TrialSession::showProposal()
{
    contextIsBehind = true;
    force.setContextPositions(context, kernel.followProposal());
}

void TrialSession::showState()
{
    if (!contextIsBehind)
        return;
    contextIsBehind = false;
    force.showState(context, kernel);
}

void TrialSession::keepState()
{
    // Limits start from the state before the first trial.

    updateLimits();
    kernel.keepState();
}

void TrialSession::takeBackState()
{
    kernel.takeBackState();
    ownsTrial = false;
    contextIsBehind = true;
}
