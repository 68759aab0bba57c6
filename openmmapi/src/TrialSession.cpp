#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

TrialSession::TrialSession(StericExclusionForceImpl& force, ContextImpl& context, Scene& scene, Limits limits) :
    force(force), context(context), scene(scene), limits(limits), ownsTrial(false), contextIsBehind(false),
    velocitiesAreBehind(false)
{
    force.takeNoticeOfPositions(context);
    force.bringUpToDate(scene);
    if (limits == ApplyTrialSpheres && !force.trialSpheresAreFree())
        this->limits = IgnoreLimits;
}

TrialSession::~TrialSession()
{
    try {
        end();
    }
    catch (...) {
        // An exception is being handled, or the Context did not accept positions. Nothing is lost: if the two disagree,
        // the force takes its state from the Context.
    }
}

void TrialSession::end()
{
    if (ownsTrial)
        reject();
    if (contextIsBehind) {
        contextIsBehind = false;
        force.showState(context, scene);
    }
    if (velocitiesAreBehind) {
        velocitiesAreBehind = false;
        force.velocities->end(context, scene);
    }
}

void TrialSession::leaveOpen()
{
    ownsTrial = false;
}

/**
 * Update limits, if they apply. They start from the state before the trial.
 */
void TrialSession::updateLimits()
{
    if (limits == ApplyLimits)
        force.limits.update();
}

bool TrialSession::propose(const Proposal& proposal)
{
    updateLimits();
    if (!force.mayScaleBox(scene, proposal.getBoxFactor()) || !scene.propose(proposal)) {
        force.warnOfNarrowBox();
        return false;
    }
    ownsTrial = true;
    force.proposalIsFree = false;
    if (&scene != force.scene)
        force.scene->reject(); // that of a user
    return true;
}

bool TrialSession::test()
{
    force.proposalIsFree = limits == IgnoreLimits || scene.test();
    return force.proposalIsFree;
}

void TrialSession::accept()
{
    if (!velocitiesAreBehind)
        force.velocities->begin(context, scene);
    velocitiesAreBehind = true;
    scene.accept();
    ownsTrial = false;
    contextIsBehind = true;
    const bool spheresAreFree = (limits == ApplyTrialSpheres && force.proposalIsFree);
    force.stateWasChanged(scene);
    force.trialSpheresWereFree = spheresAreFree;
    if (limits == ApplyLimits && !force.proposalIsFree)
        force.limits.restart();
}

void TrialSession::reject()
{
    scene.reject();
    ownsTrial = false;
}

double TrialSession::computeSoftEnergy()
{
    vector<Vec3> forces(context.getSystem().getNumParticles());
    return scene.computeEnergy(forces);
}

double TrialSession::computeOtherEnergy(int groups)
{
    return force.computeOtherEnergy(context, groups);
}

void TrialSession::showProposal()
{
    contextIsBehind = true;
    force.setContextPositions(context, scene.followTrial(), scene.getTrialBox());
}

void TrialSession::showState()
{
    if (!contextIsBehind)
        return;
    contextIsBehind = false;
    force.showState(context, scene);
}

void TrialSession::save()
{
    // Limits start from the state before the first trial.

    updateLimits();
    scene.save();
}

void TrialSession::restore()
{
    scene.restore();
    ownsTrial = false;
    contextIsBehind = true;
}
