#include "openmmchaintree/StericExclusionForce.h"
#include "openmm/internal/AssertionUtilities.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/ContextLock.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void checkParticleParameters(int index, double radius, StericExclusionForce::HydrogenBondRole hydrogenBondRole)
{
    checkNotNegative(radius, "StericExclusionForce: the radius of particle " + to_string(index));
    if (hydrogenBondRole < StericExclusionForce::NoHydrogenBond ||
        hydrogenBondRole > StericExclusionForce::DonorAndAcceptor)
        throw OpenMMException("StericExclusionForce: the hydrogen bond role of particle " + to_string(index) +
                              " must be NoHydrogenBond, Donor, Acceptor or DonorAndAcceptor, but is " +
                              to_string((int)hydrogenBondRole));
}

/**
 * A call of the user on a Context. No other thread uses the Context meanwhile.
 */
class StericExclusionForce::Call {
public:
    Call(const StericExclusionForce& force, Context& context) :
        impl(dynamic_cast<StericExclusionForceImpl&>(force.getImplInContext(context))),
        context(force.getContextImpl(context)), use(impl.getLock(), ContextLock::User)
    {
        impl.requireInitialized();
    }
    StericExclusionForceImpl* operator->()
    {
        return &impl;
    }
    Scene& queryState()
    {
        return impl.queryState(context);
    }
    Scene& queryTrial()
    {
        return impl.queryTrial(context);
    }

private:
    StericExclusionForceImpl& impl;
    ContextImpl& context;
    const ContextUse use;
};

StericExclusionForce::StericExclusionForce() :
    overlapTolerance(0.04), hydrogenBondAllowance(0.06), forceConstant(1e5), usesPeriodic(false)
{
    setName("StericExclusionForce");
}

int StericExclusionForce::getNumParticles() const
{
    return particles.size();
}

int StericExclusionForce::getNumBonds() const
{
    return bonds.size();
}

int StericExclusionForce::getNumTorsions() const
{
    return torsions.size();
}

int StericExclusionForce::getNumBallJoints() const
{
    return ballJoints.size();
}

int StericExclusionForce::getNumClosures() const
{
    return closures.size();
}

int StericExclusionForce::getNumExclusions() const
{
    return exclusions.size();
}

int StericExclusionForce::addParticle(double radius, HydrogenBondRole hydrogenBondRole)
{
    checkParticleParameters(particles.size(), radius, hydrogenBondRole);
    particles.push_back({radius, hydrogenBondRole});
    return particles.size() - 1;
}

void StericExclusionForce::getParticleParameters(int index, double& radius, HydrogenBondRole& hydrogenBondRole) const
{
    ASSERT_VALID_INDEX(index, particles);
    radius = particles[index].radius;
    hydrogenBondRole = particles[index].role;
}

void StericExclusionForce::setParticleParameters(int index, double radius, HydrogenBondRole hydrogenBondRole)
{
    ASSERT_VALID_INDEX(index, particles);
    checkParticleParameters(index, radius, hydrogenBondRole);
    particles[index] = {radius, hydrogenBondRole};
}

int StericExclusionForce::addBond(int particle1, int particle2)
{
    bonds.push_back(make_pair(particle1, particle2));
    return bonds.size() - 1;
}

void StericExclusionForce::getBondParticles(int index, int& particle1, int& particle2) const
{
    ASSERT_VALID_INDEX(index, bonds);
    particle1 = bonds[index].first;
    particle2 = bonds[index].second;
}

int StericExclusionForce::addTorsion(int particle1, int particle2, int particle3, int particle4)
{
    torsions.push_back({{particle1, particle2, particle3, particle4}});
    return torsions.size() - 1;
}

void StericExclusionForce::getTorsionParticles(int index, int& particle1, int& particle2, int& particle3,
                                               int& particle4) const
{
    ASSERT_VALID_INDEX(index, torsions);
    particle1 = torsions[index][0];
    particle2 = torsions[index][1];
    particle3 = torsions[index][2];
    particle4 = torsions[index][3];
}

int StericExclusionForce::addBallJoint(int particle1, int particle2)
{
    ballJoints.push_back(make_pair(particle1, particle2));
    return ballJoints.size() - 1;
}

void StericExclusionForce::getBallJointParticles(int index, int& particle1, int& particle2) const
{
    ASSERT_VALID_INDEX(index, ballJoints);
    particle1 = ballJoints[index].first;
    particle2 = ballJoints[index].second;
}

int StericExclusionForce::addClosure(int particle1, int particle2, int particle3, int particle4)
{
    closures.push_back({{particle1, particle2, particle3, particle4}});
    return closures.size() - 1;
}

void StericExclusionForce::getClosureParticles(int index, int& particle1, int& particle2, int& particle3,
                                               int& particle4) const
{
    ASSERT_VALID_INDEX(index, closures);
    particle1 = closures[index][0];
    particle2 = closures[index][1];
    particle3 = closures[index][2];
    particle4 = closures[index][3];
}

int StericExclusionForce::addExclusion(int particle1, int particle2)
{
    exclusions.push_back(make_pair(particle1, particle2));
    return exclusions.size() - 1;
}

void StericExclusionForce::getExclusionParticles(int index, int& particle1, int& particle2) const
{
    ASSERT_VALID_INDEX(index, exclusions);
    particle1 = exclusions[index].first;
    particle2 = exclusions[index].second;
}

void StericExclusionForce::createExclusionsFromBonds(int bondCutoff)
{
    if (bondCutoff < 0)
        throw OpenMMException("StericExclusionForce: bondCutoff must be at least 0, but is " + to_string(bondCutoff));
    vector<vector<int>> neighbors(particles.size());
    auto tie = [&](int particle1, int particle2, const string& name) {
        checkIndex(particle1, particles.size(), "particle", "StericExclusionForce: " + name);
        checkIndex(particle2, particles.size(), "particle", "StericExclusionForce: " + name);
        neighbors[particle1].push_back(particle2);
        neighbors[particle2].push_back(particle1);
    };
    for (auto& bond : bonds)
        tie(bond.first, bond.second, "a bond");
    for (auto& closure : closures)
        tie(closure[1], closure[2], "a closure");
    set<pair<int, int>> known;
    for (auto& exclusion : exclusions)
        known.insert(minmax(exclusion.first, exclusion.second));

    // Search breadth first from each particle, and exclude particles with a higher index.

    vector<int> visitedFrom(particles.size(), -1);
    for (int start = 0; start < (int)particles.size(); start++) {
        vector<int> reached(1, start);
        visitedFrom[start] = start;
        size_t shellBegin = 0;
        for (int distance = 1; distance <= bondCutoff && shellBegin < reached.size(); distance++) {
            size_t shellEnd = reached.size();
            for (; shellBegin < shellEnd; shellBegin++)
                for (int neighbor : neighbors[reached[shellBegin]])
                    if (visitedFrom[neighbor] != start) {
                        visitedFrom[neighbor] = start;
                        reached.push_back(neighbor);
                    }
        }
        sort(reached.begin(), reached.end());
        for (int particle : reached)
            if (particle > start && known.find(make_pair(start, particle)) == known.end())
                addExclusion(start, particle);
    }
}

double StericExclusionForce::getOverlapTolerance() const
{
    return overlapTolerance;
}

void StericExclusionForce::setOverlapTolerance(double tolerance)
{
    checkNotNegative(tolerance, "StericExclusionForce: the overlap tolerance");
    overlapTolerance = tolerance;
}

double StericExclusionForce::getHydrogenBondAllowance() const
{
    return hydrogenBondAllowance;
}

void StericExclusionForce::setHydrogenBondAllowance(double allowance)
{
    checkNotNegative(allowance, "StericExclusionForce: the hydrogen bond allowance");
    hydrogenBondAllowance = allowance;
}

double StericExclusionForce::getForceConstant() const
{
    return forceConstant;
}

void StericExclusionForce::setForceConstant(double k)
{
    checkNotNegative(k, "StericExclusionForce: the force constant");
    forceConstant = k;
}

void StericExclusionForce::setUsesPeriodicBoundaryConditions(bool periodic)
{
    usesPeriodic = periodic;
}

bool StericExclusionForce::usesPeriodicBoundaryConditions() const
{
    return usesPeriodic;
}

void StericExclusionForce::updateParametersInContext(Context& context)
{
    Call(*this, context)->updateParametersInContext(getContextImpl(context));
}

bool StericExclusionForce::hasClash(Context& context) const
{
    return Call(*this, context).queryState().hasClash();
}

void StericExclusionForce::getClashes(Context& context, vector<pair<int, int>>& pairs, vector<double>& overlaps) const
{
    Call(*this, context).queryState().getClashes(pairs, overlaps);
}

void StericExclusionForce::getNeighborPairs(Context& context, double cutoff, vector<pair<int, int>>& pairs,
                                            vector<double>& distances) const
{
    Call(*this, context).queryState().getNeighborPairs(cutoff, pairs, distances);
}

double StericExclusionForce::getMinimumDistance(Context& context, const vector<int>& particles1,
                                                const vector<int>& particles2, int& particle1, int& particle2) const
{
    return Call(*this, context).queryState().getMinimumDistance(particles1, particles2, particle1, particle2);
}

void StericExclusionForce::getClashesWith(Context& context, const Vec3& position, double radius, vector<int>& particles,
                                          vector<double>& overlaps) const
{
    Call(*this, context).queryState().getClashesWith(position, radius, particles, overlaps);
}

bool StericExclusionForce::proposeTorsions(Context& context, const vector<int>& torsions,
                                           const vector<double>& changes) const
{
    return Call(*this, context)->proposeTorsions(getContextImpl(context), torsions, changes);
}

bool StericExclusionForce::proposeBallRotations(Context& context, const vector<int>& ballJoints,
                                                const vector<Vec3>& rotations) const
{
    return Call(*this, context)->proposeBallRotations(getContextImpl(context), ballJoints, rotations);
}

bool StericExclusionForce::proposeRigidMotion(Context& context, int particle, const Vec3& rotation,
                                              const Vec3& translation) const
{
    return Call(*this, context)->proposeRigidMotion(getContextImpl(context), particle, rotation, translation);
}

void StericExclusionForce::getProposedPositions(Context& context, vector<Vec3>& positions) const
{
    Call(*this, context).queryTrial().getTrialPositions(positions);
}

void StericExclusionForce::getChangedNeighborPairs(Context& context, double cutoff, vector<pair<int, int>>& pairs,
                                                   vector<double>& before, vector<double>& after) const
{
    Call(*this, context).queryTrial().getChangedNeighborPairs(cutoff, pairs, before, after);
}

void StericExclusionForce::acceptProposal(Context& context) const
{
    Call(*this, context)->acceptProposal(getContextImpl(context));
}

void StericExclusionForce::rejectProposal(Context& context) const
{
    Call(*this, context)->rejectProposal();
}

void StericExclusionForce::restartLimits(Context& context) const
{
    Call(*this, context)->getLimitPolicy().restart();
}

void StericExclusionForce::getTorsionAngles(Context& context, vector<double>& angles) const
{
    Call(*this, context)->getTorsionAngles(getContextImpl(context), angles);
}

void StericExclusionForce::setTorsionAngles(Context& context, const vector<double>& angles) const
{
    Call(*this, context)->setTorsionAngles(getContextImpl(context), angles);
}

int StericExclusionForce::getNumToleratedClashes(Context& context) const
{
    return Call(*this, context).queryState().getNumLimits();
}

void StericExclusionForce::getTraversalStatistics(Context& context, long long& queries, long long& volumeTests,
                                                  long long& particleTests, long long& nodesUpdated) const
{
    Call(*this, context)->getTraversalStatistics(queries, volumeTests, particleTests, nodesUpdated);
}

void StericExclusionForce::resetTraversalStatistics(Context& context) const
{
    Call(*this, context)->resetTraversalStatistics();
}

/**
 * Get whether two lists have the same pairs, in any order and number.
 */
static bool haveSamePairs(const vector<pair<int, int>>& list1, const vector<pair<int, int>>& list2)
{
    if (list1 == list2)
        return true;
    auto collect = [](const vector<pair<int, int>>& list) {
        set<pair<int, int>> pairs;
        for (auto& particles : list)
            pairs.insert(minmax(particles.first, particles.second));
        return pairs;
    };
    return collect(list1) == collect(list2);
}

/**
 * Compare everything that updateParametersInContext() cannot change.
 */
bool StericExclusionForce::hasStructureOf(const StericExclusionForce& other) const
{
    return particles.size() == other.particles.size() && torsions == other.torsions && ballJoints == other.ballJoints &&
           closures == other.closures && haveSamePairs(bonds, other.bonds) &&
           haveSamePairs(exclusions, other.exclusions);
}

ForceImpl* StericExclusionForce::createImpl() const
{
    return new StericExclusionForceImpl(*this);
}
