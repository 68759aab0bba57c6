#include "ReferenceChainTreeKernels.h"
#include "openmm/OpenMMException.h"
#include <algorithm>
#include <new>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static_assert(sizeof(Vec3) == 3 * sizeof(double), "the engine takes a Vec3 for three numbers");

static const double* coordinates(const vector<Vec3>& vectors)
{
    return reinterpret_cast<const double*>(vectors.data());
}

static double* coordinates(vector<Vec3>& vectors)
{
    return reinterpret_cast<double*>(vectors.data());
}

template <size_t N>
static const int (*rows(const vector<array<int, N>>& arrays))[N]
{
    return reinterpret_cast<const int(*)[N]>(arrays.data());
}

/**
 * Collects what the engine finds, in any order, and hands it out sorted. Value is one number, or an array of them.
 */
template <typename Key, typename Value>
class Collector {
public:
    Collector() : outOfMemory(false)
    {
    }
    /**
     * Take one more. This is called from C, which no exception may cross.
     */
    bool add(const Key& key, const Value& value)
    {
        try {
            found.push_back(make_pair(key, value));
        }
        catch (const bad_alloc&) {
            outOfMemory = true;
        }
        return !outOfMemory;
    }
    /**
     * Get what was found, by ascending key. No key comes twice.
     */
    const vector<pair<Key, Value>>& sort()
    {
        if (outOfMemory)
            throw OpenMMException("StericExclusionForce: out of memory");
        std::sort(found.begin(), found.end(), [](const pair<Key, Value>& a, const pair<Key, Value>& b) {
            return a.first < b.first;
        });
        return found;
    }

private:
    vector<pair<Key, Value>> found;
    bool outOfMemory;
};

typedef pair<int, int> ParticlePair;
typedef Collector<ParticlePair, double> PairCollector;
typedef Collector<ParticlePair, pair<double, double>> ChangedPairCollector;
typedef Collector<int, double> ParticleCollector;

static bool addPair(void* collector, int particle1, int particle2, double value)
{
    return static_cast<PairCollector*>(collector)->add(ParticlePair(particle1, particle2), value);
}

static bool addChangedPair(void* collector, int particle1, int particle2, double before, double after)
{
    return static_cast<ChangedPairCollector*>(collector)->add(ParticlePair(particle1, particle2),
                                                              make_pair(before, after));
}

static bool addParticle(void* collector, int particle, double overlap)
{
    return static_cast<ParticleCollector*>(collector)->add(particle, overlap);
}

/**
 * Split sorted keys and values into two arrays.
 */
template <typename Key>
static void split(Collector<Key, double>& collector, vector<Key>& keys, vector<double>& values)
{
    auto& found = collector.sort();
    keys.resize(found.size());
    values.resize(found.size());
    for (size_t i = 0; i < found.size(); i++) {
        keys[i] = found[i].first;
        values[i] = found[i].second;
    }
}

ReferenceCalcStericExclusionForceKernel::ReferenceCalcStericExclusionForceKernel(string name,
                                                                                 const Platform& platform) :
    CalcStericExclusionForceKernel(name, platform),
    parameters(), counts(), numQueries(0)
{
}

// ---- Life ----

void ReferenceCalcStericExclusionForceKernel::initialize(const StericExclusionForce& force,
                                                         const LinkStructure& structure)
{
    particleLinks = structure.getParticleLinks();
    torsionLinks = structure.getTorsionLinks();
    ballJointLinks = structure.getBallJointLinks();
    for (const LinkStructure::Molecule& molecule : structure.getMolecules())
        moleculeRoots.push_back(molecule.root);
    for (const LinkStructure::Link& link : structure.getLinks()) {
        array<int, 4> torsion = {{CT_NULL, CT_NULL, CT_NULL, CT_NULL}};
        uint8_t joint = structure.getMolecules()[link.molecule].fixed ? ctFixedJoint : ctFreeJoint;
        if (link.torsion != -1) {
            force.getTorsionParticles(link.torsion, torsion[0], torsion[1], torsion[2], torsion[3]);
            joint = ctTorsionJoint;
        }
        else if (link.ballJoint != -1) {
            force.getBallJointParticles(link.ballJoint, torsion[1], torsion[2]);
            joint = ctBallJoint;
        }
        linkParents.push_back(link.parent);
        linkJoints.push_back(joint);
        linkTorsions.push_back(torsion);
    }
    exclusions.resize(force.getNumExclusions());
    for (int i = 0; i < force.getNumExclusions(); i++)
        force.getExclusionParticles(i, exclusions[i][0], exclusions[i][1]);
    changes.resize(max(torsionLinks.size(), ballJointLinks.size()));
    parameters = readParameters(force);
}

ReferenceCalcStericExclusionForceKernel::Parameters
ReferenceCalcStericExclusionForceKernel::readParameters(const StericExclusionForce& force)
{
    Parameters read;
    read.radii.resize(force.getNumParticles());
    read.roles.resize(force.getNumParticles());
    for (int i = 0; i < force.getNumParticles(); i++) {
        StericExclusionForce::HydrogenBondRole role;
        force.getParticleParameters(i, read.radii[i], role);
        read.roles[i] = role;
    }
    read.overlapTolerance = force.getOverlapTolerance();
    read.hydrogenBondAllowance = force.getHydrogenBondAllowance();
    read.forceConstant = force.getForceConstant();
    return read;
}

double ReferenceCalcStericExclusionForceKernel::Parameters::getTolerance(int particle1, int particle2) const
{
    const int role1 = roles[particle1], role2 = roles[particle2];
    const bool mayBond = ((role1 & ctDonor) && (role2 & ctAcceptor)) || ((role1 & ctAcceptor) && (role2 & ctDonor));
    return overlapTolerance + (mayBond ? hydrogenBondAllowance : 0);
}

void ReferenceCalcStericExclusionForceKernel::copyParameters(const StericExclusionForce& force)
{
    // The engine checks parameters when it makes a scene. Before there are positions, any will do for that.

    Parameters read = readParameters(force);
    vector<Vec3> positions(read.radii.size());
    if (tree)
        getPositions(positions);
    Tree created = createTree(read, positions);
    if (tree) {
        copyLimits(created.get());
        setTree(std::move(created), std::move(positions));
    }
    parameters = std::move(read);
}

/**
 * Give a scene made anew the limits of the present one.
 */
void ReferenceCalcStericExclusionForceKernel::copyLimits(ctChainTree* created)
{
    vector<array<int, 2>> pairs(getNumLimits());
    vector<double> limits(pairs.size());
    ctGetLimits(tree.get(), pairs.size(), reinterpret_cast<int(*)[2]>(pairs.data()), limits.data());
    if (ctSetLimits(created, pairs.size(), rows(pairs), limits.data()) != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + ctGetErrorText(created));
}

/**
 * Describe the scene in arrays that belong to this object or the caller.
 */
ctDefinition ReferenceCalcStericExclusionForceKernel::describe(const Parameters& parameters,
                                                               const vector<Vec3>& positions) const
{
    ctDefinition definition = {};
    definition.particleCount = parameters.radii.size();
    definition.positions = coordinates(positions);
    definition.radii = parameters.radii.data();
    definition.hydrogenBondRoles = parameters.roles.data();
    definition.particleLinks = particleLinks.data();
    definition.listed = listed.empty() ? NULL : listed.data();
    definition.linkCount = linkParents.size();
    definition.linkParents = linkParents.data();
    definition.linkJoints = linkJoints.data();
    definition.linkTorsions = rows(linkTorsions);
    definition.exclusionCount = exclusions.size();
    definition.exclusions = rows(exclusions);
    definition.overlapTolerance = parameters.overlapTolerance;
    definition.hydrogenBondAllowance = parameters.hydrogenBondAllowance;
    return definition;
}

ReferenceCalcStericExclusionForceKernel::Tree
ReferenceCalcStericExclusionForceKernel::createTree(const Parameters& parameters, const vector<Vec3>& positions) const
{
    ctDefinition definition = describe(parameters, positions);
    ctChainTree* created;
    char errorText[256];
    if (ctCreate(&definition, &created, errorText, sizeof(errorText)) != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + errorText);
    return Tree(created);
}

void ReferenceCalcStericExclusionForceKernel::setTree(Tree created, vector<Vec3> positions)
{
    energy.reset();
    kept.exists = false;
    arrangement = std::move(positions);
    tree = std::move(created);
    followed.clear();
    selection1 = KeptSelection();
    selection2 = KeptSelection();
}

void ReferenceCalcStericExclusionForceKernel::check(ctStatus status) const
{
    if (status != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + ctGetErrorText(tree.get()));
}

// ---- State ----

void ReferenceCalcStericExclusionForceKernel::setPositions(const vector<Vec3>& positions)
{
    if (tree)
        check(ctSetPositions(tree.get(), coordinates(positions)));
    else
        setTree(createTree(parameters, positions), positions);
}

void ReferenceCalcStericExclusionForceKernel::getPositions(vector<Vec3>& positions)
{
    positions.resize(parameters.radii.size());
    ctGetPositions(tree.get(), coordinates(positions));
}

void ReferenceCalcStericExclusionForceKernel::getPositionsOf(const vector<int>& particles, vector<Vec3>& positions)
{
    positions.resize(particles.size());
    check(ctGetPositionsOf(tree.get(), false, particles.size(), particles.data(), coordinates(positions)));
}

// Scenes that were arranged by other positions agree only up to rounding, so the arrangement is part of the state.

void ReferenceCalcStericExclusionForceKernel::getState(vector<double>& state)
{
    state.clear();
    if (!tree)
        return;
    state.resize(3 * arrangement.size() + ctGetStateSize(tree.get()));
    copy_n(coordinates(arrangement), 3 * arrangement.size(), state.begin());
    ctGetState(tree.get(), &state[3 * arrangement.size()]);

    // A run that goes on has the bits of one that begins with these numbers.

    ctRenew(tree.get());
}

void ReferenceCalcStericExclusionForceKernel::setState(const vector<double>& state)
{
    if (state.empty()) {
        setTree(Tree(), {});
        return;
    }
    vector<Vec3> positions(parameters.radii.size());
    size_t split = 3 * positions.size();
    if (state.size() < split)
        throw OpenMMException("StericExclusionForce: the state is of another structure");
    copy_n(state.begin(), split, coordinates(positions));
    Tree created = createTree(parameters, positions);
    if (state.size() != split + ctGetStateSize(created.get()))
        throw OpenMMException("StericExclusionForce: the state is of another structure");
    if (ctSetState(created.get(), &state[split]) != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + ctGetErrorText(created.get()));
    setTree(std::move(created), std::move(positions));
}

double ReferenceCalcStericExclusionForceKernel::getTorsionAngle(int torsion)
{
    double angle;
    if (ctGetTorsionAngle(tree.get(), torsionLinks[torsion], &angle) != ctSuccess)
        throw OpenMMException("StericExclusionForce: torsion " + to_string(torsion) +
                              " has no value: " + ctGetErrorText(tree.get()));
    return angle;
}

void ReferenceCalcStericExclusionForceKernel::getOrientations(vector<array<double, 9>>& orientations)
{
    orientations.resize(linkParents.size());
    ctGetOrientations(tree.get(), reinterpret_cast<double(*)[9]>(orientations.data()));
}

// ---- Energy and queries ----

double ReferenceCalcStericExclusionForceKernel::computeEnergy(vector<Vec3>& forces)
{
    fill(forces.begin(), forces.end(), Vec3());
    double energy;
    check(ctComputeEnergy(tree.get(), parameters.forceConstant, &energy, coordinates(forces), &counts));
    numQueries++;
    return energy;
}

bool ReferenceCalcStericExclusionForceKernel::hasClash()
{
    bool clash;
    check(ctHasClash(tree.get(), &clash, NULL, &counts));
    numQueries++;
    return clash;
}

void ReferenceCalcStericExclusionForceKernel::getClashes(vector<pair<int, int>>& pairs, vector<double>& overlaps)
{
    PairCollector collector;
    check(ctForEachClash(tree.get(), addPair, &collector, &counts));
    numQueries++;
    split(collector, pairs, overlaps);
}

void ReferenceCalcStericExclusionForceKernel::getNeighborPairs(double cutoff, vector<pair<int, int>>& pairs,
                                                               vector<double>& distances)
{
    // What was enough the last time will mostly be so again.
    size_t count = neighbors1.size();
    do {
        neighbors1.resize(count);
        neighbors2.resize(count);
        distances.resize(count);
        check(ctGetNeighborPairs(tree.get(), cutoff, true, neighbors1.size(), neighbors1.data(), neighbors2.data(),
                                 distances.data(), &count, &counts));
    } while (count > neighbors1.size());
    numQueries++;
    distances.resize(count);
    pairs.resize(count);
    for (size_t i = 0; i < count; i++)
        pairs[i] = make_pair(neighbors1[i], neighbors2[i]);
}

ctSelection* ReferenceCalcStericExclusionForceKernel::select(const vector<int>& particles, KeptSelection& kept) const
{
    if (!kept.selection || kept.particles != particles) {
        KeptSelection made = {particles, nullptr};
        ctSelection* selection;
        check(ctSelect(tree.get(), particles.size(), particles.data(), &selection));
        made.selection.reset(selection);
        kept = std::move(made);
    }
    return kept.selection.get();
}

double ReferenceCalcStericExclusionForceKernel::getMinimumDistance(const vector<int>& particles1,
                                                                   const vector<int>& particles2, int& particle1,
                                                                   int& particle2)
{
    double distance;
    int pair[2];
    ctSelection *set1 = select(particles1, selection1), *set2 = select(particles2, selection2);
    check(ctGetMinimumDistance(tree.get(), set1, set2, &distance, pair, &counts));
    numQueries++;
    particle1 = pair[0];
    particle2 = pair[1];
    return distance;
}

void ReferenceCalcStericExclusionForceKernel::getClashesWith(const Vec3& position, double radius,
                                                             vector<int>& particles, vector<double>& overlaps)
{
    const double center[3] = {position[0], position[1], position[2]};
    ParticleCollector collector;
    check(ctForEachClashWith(tree.get(), center, radius, addParticle, &collector, &counts));
    numQueries++;
    split(collector, particles, overlaps);
}

void ReferenceCalcStericExclusionForceKernel::getTraversalStatistics(long long& queries, long long& volumeTests,
                                                                     long long& particleTests, long long& nodesUpdated)
{
    queries = numQueries;
    volumeTests = counts.volumeTests;
    particleTests = counts.particleTests;
    nodesUpdated = counts.nodesUpdated;
}

void ReferenceCalcStericExclusionForceKernel::resetTraversalStatistics()
{
    counts = ctCounts();
    numQueries = 0;
}

// ---- Limits ----

void ReferenceCalcStericExclusionForceKernel::clearLimits()
{
    if (tree)
        check(ctSetLimits(tree.get(), 0, NULL, NULL));
}

void ReferenceCalcStericExclusionForceKernel::raiseLimits()
{
    int raised;
    check(ctRaiseLimits(tree.get(), &raised, &counts));
}

int ReferenceCalcStericExclusionForceKernel::getNumLimits()
{
    return tree ? ctGetLimitCount(tree.get()) : 0;
}

void ReferenceCalcStericExclusionForceKernel::readLimits(PairList& pairs, vector<double>& limits)
{
    pairs.resize(getNumLimits());
    limits.resize(pairs.size());
    if (!pairs.empty())
        ctGetLimits(tree.get(), pairs.size(), reinterpret_cast<int(*)[2]>(pairs.data()), limits.data());
}

void ReferenceCalcStericExclusionForceKernel::getLimits(vector<pair<int, int>>& pairs, vector<double>& limits)
{
    PairList found;
    readLimits(found, limits);
    pairs.clear();
    for (const array<int, 2>& pair : found)
        pairs.push_back(make_pair(pair[0], pair[1]));
}

void ReferenceCalcStericExclusionForceKernel::setLimits(const vector<pair<int, int>>& pairs,
                                                        const vector<double>& limits)
{
    vector<array<int, 2>> given;
    given.reserve(pairs.size());
    for (const pair<int, int>& pair : pairs)
        given.push_back({{pair.first, pair.second}});
    check(ctSetLimits(tree.get(), given.size(), rows(given), limits.data()));
}

// ---- Trials ----

void ReferenceCalcStericExclusionForceKernel::proposeTorsions(const vector<int>& torsions, const vector<double>& angles)
{
    for (size_t i = 0; i < torsions.size(); i++) {
        changes[i].link = torsionLinks[torsions[i]];
        changes[i].angle = angles[i];
    }
    check(ctPropose(tree.get(), torsions.size(), changes.data()));
}

void ReferenceCalcStericExclusionForceKernel::proposeBallRotations(const vector<int>& ballJoints,
                                                                   const vector<Vec3>& rotations)
{
    for (size_t i = 0; i < ballJoints.size(); i++) {
        changes[i].link = ballJointLinks[ballJoints[i]];
        for (int j = 0; j < 3; j++)
            changes[i].rotation[j] = rotations[i][j];
    }
    check(ctPropose(tree.get(), ballJoints.size(), changes.data()));
}

void ReferenceCalcStericExclusionForceKernel::proposeRigidMotion(int molecule, const Vec3& rotation,
                                                                 const Vec3& translation)
{
    ctChange change = {};
    change.link = moleculeRoots[molecule];
    check(ctGetCentroid(tree.get(), change.link, change.pivot));
    for (int i = 0; i < 3; i++) {
        change.rotation[i] = rotation[i];
        change.translation[i] = translation[i];
    }
    check(ctPropose(tree.get(), 1, &change));
}

bool ReferenceCalcStericExclusionForceKernel::hasProposal()
{
    return ctHasTrial(tree.get());
}

bool ReferenceCalcStericExclusionForceKernel::isProposalFree()
{
    bool clash;
    check(ctTestTrial(tree.get(), &clash, NULL, &counts));
    numQueries++;
    return !clash;
}

void ReferenceCalcStericExclusionForceKernel::getProposedPositions(vector<Vec3>& positions)
{
    positions.resize(parameters.radii.size());
    check(ctGetTrialPositions(tree.get(), coordinates(positions)));
}

void ReferenceCalcStericExclusionForceKernel::getProposedPositionsOf(const vector<int>& particles,
                                                                     vector<Vec3>& positions)
{
    positions.resize(particles.size());
    check(ctGetPositionsOf(tree.get(), true, particles.size(), particles.data(), coordinates(positions)));
}

const vector<Vec3>& ReferenceCalcStericExclusionForceKernel::followProposal()
{
    const bool anew = followed.empty();
    vector<Vec3> made(anew ? parameters.radii.size() : 0);
    check(ctFollowTrialPositions(tree.get(), anew, coordinates(anew ? made : followed)));
    if (anew)
        followed = std::move(made);
    return followed;
}

const vector<Vec3>& ReferenceCalcStericExclusionForceKernel::followState()
{
    const bool anew = followed.empty();
    followed.resize(parameters.radii.size());
    ctFollowPositions(tree.get(), anew, coordinates(followed));
    return followed;
}

/**
 * Collects by how much a trial changes (overlap - tolerance)^2 of the pairs that clash before or in it.
 */
class ReferenceCalcStericExclusionForceKernel::SoftTerms {
public:
    explicit SoftTerms(const Parameters& parameters) : parameters(parameters)
    {
    }
    /**
     * Get the largest distance at which particles clash; 0 or less if none do.
     */
    double getReach() const
    {
        const vector<double>& radii = parameters.radii;
        double largest = radii.empty() ? 0 : *max_element(radii.begin(), radii.end());
        return 2 * largest - parameters.overlapTolerance;
    }
    static bool add(void* terms, int particle1, int particle2, double before, double after)
    {
        return static_cast<SoftTerms*>(terms)->add(particle1, particle2, before, after);
    }
    /**
     * Get the sum. Pairs come in any order, and the sum must not depend on it.
     */
    double sum()
    {
        double total = 0;
        for (auto& term : collector.sort())
            total += term.second;
        return total;
    }

private:
    bool add(int particle1, int particle2, double before, double after)
    {
        const double contact =
            parameters.radii[particle1] + parameters.radii[particle2] - parameters.getTolerance(particle1, particle2);
        const double excessBefore = max(0.0, contact - before), excessAfter = max(0.0, contact - after);
        return excessBefore == excessAfter || collector.add(ParticlePair(particle1, particle2),
                                                            excessAfter * excessAfter - excessBefore * excessBefore);
    }
    const Parameters& parameters;
    PairCollector collector;
};

double ReferenceCalcStericExclusionForceKernel::getProposedEnergyChange()
{
    SoftTerms terms(parameters);
    if (!(terms.getReach() > 0))
        return 0;
    check(ctForEachChangedPair(tree.get(), terms.getReach(), SoftTerms::add, &terms, &counts));
    numQueries++;
    return 0.5 * parameters.forceConstant * terms.sum();
}

void ReferenceCalcStericExclusionForceKernel::getChangedNeighborPairs(double cutoff, vector<pair<int, int>>& pairs,
                                                                      vector<double>& before, vector<double>& after)
{
    ChangedPairCollector collector;
    check(ctForEachChangedPair(tree.get(), cutoff, addChangedPair, &collector, &counts));
    numQueries++;
    auto& found = collector.sort();
    pairs.resize(found.size());
    before.resize(found.size());
    after.resize(found.size());
    for (size_t i = 0; i < found.size(); i++) {
        pairs[i] = found[i].first;
        before[i] = found[i].second.first;
        after[i] = found[i].second.second;
    }
}

// ---- Energies of trials ----

void ReferenceCalcStericExclusionForceKernel::setEnergyTerms(const EnergyTerms& terms)
{
    vector<uint8_t> needed = TrialEnergy::findListed(terms, parameters.radii.size());
    bool sceneIsOld = false;
    for (size_t i = 0; i < needed.size(); i++) {
        needed[i] = needed[i] && parameters.radii[i] == 0;
        sceneIsOld |= needed[i] != (listed.empty() ? 0 : listed[i]);
    }
    energy.reset();
    kept.exists = false;
    energyTerms = terms;
    standIn.clear();
    if (!sceneIsOld)
        return;
    listed.swap(needed);
    if (!tree)
        return;
    vector<double> state(ctGetStateSize(tree.get()));
    ctGetState(tree.get(), state.data());
    Tree created = createTree(parameters, arrangement);
    if (ctSetState(created.get(), state.data()) != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + ctGetErrorText(created.get()));
    copyLimits(created.get());
    setTree(std::move(created), vector<Vec3>(arrangement));
}

TrialEnergy& ReferenceCalcStericExclusionForceKernel::requireEnergy()
{
    if (!energy) {
        unique_ptr<TrialEnergy> made(new TrialEnergy(tree.get(), describe(parameters, arrangement), energyTerms));
        if (!standIn.empty())
            made->setStandIn(standIn);
        energy = std::move(made);
    }
    return *energy;
}

bool ReferenceCalcStericExclusionForceKernel::updateEnergy(bool force)
{
    return requireEnergy().update(force, counts);
}

void ReferenceCalcStericExclusionForceKernel::getEnergies(double& pairs, vector<double>& pairSets,
                                                          vector<double>& termSets)
{
    requireEnergy().getEnergies(pairs, pairSets, termSets);
}

void ReferenceCalcStericExclusionForceKernel::countChangeableTerms(vector<int>& counts)
{
    if (tree) {
        requireEnergy().countChangeableTerms(counts);
        return;
    }
    vector<Vec3> positions(parameters.radii.size());
    Tree created = createTree(parameters, positions);
    TrialEnergy(created.get(), describe(parameters, positions), energyTerms).countChangeableTerms(counts);
}

double ReferenceCalcStericExclusionForceKernel::getProposedEnergyChange(EnergyPart part)
{
    return requireEnergy().computeChange((ctEnergyPart)part, counts);
}

double ReferenceCalcStericExclusionForceKernel::getNearChangeBack()
{
    return requireEnergy().getNearChangeBack();
}

void ReferenceCalcStericExclusionForceKernel::computeWholeEnergy(double& nonbonded, double& born)
{
    requireEnergy().computeWhole(nonbonded, born, counts);
}

void ReferenceCalcStericExclusionForceKernel::computeValueEnergies(bool inTrial, vector<double>& energies)
{
    requireEnergy().computeValues(inTrial, energies);
}

void ReferenceCalcStericExclusionForceKernel::renewStandIn()
{
    requireEnergy().renewStandIn(counts);
    energy->getStandIn(standIn);
}

void ReferenceCalcStericExclusionForceKernel::getStandIn(vector<double>& numbers)
{
    requireEnergy().getStandIn(numbers);
}

void ReferenceCalcStericExclusionForceKernel::setStandIn(const vector<double>& numbers)
{
    requireEnergy().setStandIn(numbers);
    standIn = numbers;
}

void ReferenceCalcStericExclusionForceKernel::keepState()
{
    kept.exists = false;
    kept.numbers.resize(ctGetStateSize(tree.get()));
    ctGetState(tree.get(), kept.numbers.data());
    readLimits(kept.limitedPairs, kept.limits);
    kept.hasEnergy = (bool)energy;
    if (energy)
        energy->keep();
    kept.exists = true;
}

void ReferenceCalcStericExclusionForceKernel::takeBackState()
{
    if (!kept.exists)
        throw OpenMMException("StericExclusionForce: no state was kept");
    check(ctSetState(tree.get(), kept.numbers.data()));
    PairList pairs;
    vector<double> limits;
    readLimits(pairs, limits);
    if (pairs != kept.limitedPairs || limits != kept.limits)
        check(ctSetLimits(tree.get(), kept.limits.size(), rows(kept.limitedPairs), kept.limits.data()));
    if (kept.hasEnergy)
        energy->takeBack();
    else
        energy.reset();
}

void ReferenceCalcStericExclusionForceKernel::acceptProposal()
{
    check(ctAccept(tree.get(), &counts));
    if (energy)
        energy->accept();
}

void ReferenceCalcStericExclusionForceKernel::rejectProposal()
{
    if (tree)
        ctReject(tree.get());
}
