#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

TrialSession::TrialSession(StericExclusionForceImpl& force, ContextImpl& context, Limits limits) :
    force(force), context(context), kernel(*force.engine), limits(limits), ownsTrial(false), contextIsBehind(false)
{
    force.takeNoticeOfPositions(context);
    if (hasLimits())
        force.limits.update();
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
        force.showState(context);
    }
}

void TrialSession::leaveOpen()
{
    ownsTrial = false;
}

void TrialSession::proposeTorsions(const vector<int>& torsions, const vector<double>& changes)
{
    kernel.proposeTorsions(torsions, changes);
    ownsTrial = true;
    force.proposalIsFree = false;
}

void TrialSession::proposeRigidMotion(int molecule, const Vec3& rotation, const Vec3& translation)
{
    kernel.proposeRigidMotion(molecule, rotation, translation);
    ownsTrial = true;
    force.proposalIsFree = false;
}

bool TrialSession::isFree()
{
    force.proposalIsFree = !hasLimits() || kernel.isProposalFree();
    return force.proposalIsFree;
}

void TrialSession::accept()
{
    kernel.acceptProposal();
    ownsTrial = false;
    contextIsBehind = true;
    if (hasLimits() && !force.proposalIsFree)
        force.limits.restart();
}

void TrialSession::reject()
{
    kernel.rejectProposal();
    ownsTrial = false;
}

double TrialSession::computeOtherEnergy(int groups)
{
    return force.computeOtherEnergy(context, groups);
}

double TrialSession::computeOtherEnergyOfProposal(int groups)
{
    contextIsBehind = true;
    force.setContextPositions(context, kernel.followProposal());
    return force.computeOtherEnergy(context, groups);
}
