/* The queries of a Scene: clashes, near pairs and distances of the state, and pairs that the open trial changes. */

#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/EngineArrays.h"
#include "openmmchaintree/internal/Scene.h"
#include <algorithm>
#include <new>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Collects results of the engine, which come in any order, and sorts them. Value is one number or two.
 */
template <typename Key, typename Value>
class Collector {
public:
    Collector() : outOfMemory(false)
    {
    }
    /**
     * Add a result. This is called from C, so it throws no exception. Returns false if there is no memory.
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
     * Get the results by ascending key. No key comes twice.
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

// ---- The state ----

double Scene::computeEnergy(vector<Vec3>& forces)
{
    fill(forces.begin(), forces.end(), Vec3());
    double softEnergy;
    check(
        ctComputeEnergy(tree.get(), definition.parameters.forceConstant, &softEnergy, coordinatesOf(forces), &counts));
    numQueries++;
    return softEnergy;
}

double Scene::computeSoftEnergy(ctChainTree& tree)
{
    double softEnergy;
    check(ctComputeEnergy(&tree, definition.parameters.forceConstant, &softEnergy, NULL, &counts), &tree);
    numQueries++;
    return softEnergy;
}

bool Scene::hasClash()
{
    bool clash;
    check(ctHasClash(tree.get(), &clash, NULL, &counts));
    numQueries++;
    return clash;
}

void Scene::getClashes(vector<pair<int, int>>& pairs, vector<double>& overlaps)
{
    PairCollector collector;
    check(ctForEachClash(tree.get(), addPair, &collector, &counts));
    numQueries++;
    split(collector, pairs, overlaps);
}

void Scene::getNeighborPairs(double cutoff, vector<pair<int, int>>& pairs, vector<double>& distances)
{
    // The size of the last list is usually enough.

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

/**
 * Prepare a set of particles, unless it was prepared last.
 */
ctSelection* Scene::prepare(const vector<int>& particles, PreparedSet& set) const
{
    if (!set.selection || set.particles != particles) {
        PreparedSet made = {particles, nullptr};
        ctSelection* selection;
        check(ctSelect(tree.get(), particles.size(), particles.data(), &selection));
        made.selection.reset(selection);
        set = std::move(made);
    }
    return set.selection.get();
}

double Scene::getMinimumDistance(const vector<int>& particles1, const vector<int>& particles2, int& particle1,
                                 int& particle2)
{
    double distance;
    int pair[2];
    ctSelection *selection1 = prepare(particles1, set1), *selection2 = prepare(particles2, set2);
    check(ctGetMinimumDistance(tree.get(), selection1, selection2, &distance, pair, &counts));
    numQueries++;
    particle1 = pair[0];
    particle2 = pair[1];
    return distance;
}

void Scene::getClashesWith(const Vec3& position, double radius, vector<int>& particles, vector<double>& overlaps)
{
    const double center[3] = {position[0], position[1], position[2]};
    ParticleCollector collector;
    check(ctForEachClashWith(tree.get(), center, radius, addParticle, &collector, &counts));
    numQueries++;
    split(collector, particles, overlaps);
}

void Scene::addTraversalStatistics(long long& queries, long long& volumeTests, long long& particleTests,
                                   long long& nodesUpdated) const
{
    queries += numQueries;
    volumeTests += counts.volumeTests;
    particleTests += counts.particleTests;
    nodesUpdated += counts.nodesUpdated;
}

void Scene::resetTraversalStatistics()
{
    counts = ctCounts();
    numQueries = 0;
}

// ---- The open trial ----

namespace {

/**
 * Collects the changes of (overlap - tolerance)^2 of the pairs that clash before the trial or in it.
 */
class SoftTerms {
public:
    explicit SoftTerms(const SceneDefinition::Parameters& parameters) : parameters(parameters)
    {
    }
    /**
     * Get the largest distance at which particles clash; 0 or less if none do.
     */
    double getReach() const
    {
        const vector<double>& radii = parameters.radii;
        const double largest = radii.empty() ? 0 : *max_element(radii.begin(), radii.end());
        return 2 * largest - parameters.overlapTolerance;
    }
    static bool add(void* terms, int particle1, int particle2, double before, double after)
    {
        return static_cast<SoftTerms*>(terms)->add(particle1, particle2, before, after);
    }
    /**
     * Get the sum. Pairs come in any order, on which the sum must not depend.
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
    const SceneDefinition::Parameters& parameters;
    PairCollector collector;
};

} // namespace

double Scene::computeSoftEnergyChange()
{
    if (isScaled)
        return computeSoftEnergy(*other) - computeSoftEnergy(*tree);
    SoftTerms terms(definition.parameters);
    if (!(terms.getReach() > 0))
        return 0;
    check(ctForEachChangedPair(tree.get(), terms.getReach(), SoftTerms::add, &terms, &counts));
    numQueries++;
    return 0.5 * definition.parameters.forceConstant * terms.sum();
}

void Scene::getChangedNeighborPairs(double cutoff, vector<pair<int, int>>& pairs, vector<double>& before,
                                    vector<double>& after)
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
