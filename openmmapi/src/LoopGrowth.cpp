#include "openmmchaintree/LoopGrowth.h"
#include "ctgrowth.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/EngineArrays.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include <array>
#include <cmath>
#include <limits>
#include <new>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static_assert(StericExclusionForce::Donor == CT_GROWTH_DONOR && StericExclusionForce::Acceptor == CT_GROWTH_ACCEPTOR,
              "the library and the API have the same roles");

static void fail(const string& message)
{
    throw OpenMMException("LoopGrowth: " + message);
}

/**
 * The loop in the library's terms. See ctgrowth.h.
 */
class LoopGrowth::Contents {
public:
    Contents(const System& system, const StericExclusionForce& force, const vector<Vec3>& positions,
             const vector<vector<int>>& torsions, const vector<TorsionDensity>& densities);
    ~Contents()
    {
        ctDestroyGrowth(growth);
    }
    vector<Vec3> positions;
    /** The index of each moving particle, and the number of joints and of drawn ones. */
    vector<int> moving;
    int numJoints, numDrawn;
    ctGrowth* growth;

private:
    void findPieces(const LinkStructure& structure);
    void addParticles(const LinkStructure& structure, const StericExclusionForce& force);
    void addExclusions(const StericExclusionForce& force);
    void addSets(const vector<vector<int>>& torsions, const vector<TorsionDensity>& densities);
    ctGrowth* create(const StericExclusionForce& force) const;
    vector<TorsionDensity> densities;
    int pathCount;
    /** The torsion of each joint, and the joint of each torsion or -1. */
    vector<int> jointTorsions, torsionJoints;
    /** The piece of each link, and the piece on which each side joint's piece hangs. */
    vector<int> linkPieces, parents;
    /** The index of each particle among those that move, or among the others. */
    vector<int> places;
    vector<bool> isMoving;
    vector<array<array<double, 3>, 4>> jointPositions;
    vector<Vec3> movingPositions, fixedPositions;
    vector<double> movingRadii, fixedRadii;
    vector<uint8_t> movingRoles, fixedRoles;
    vector<int> pieces;
    vector<array<int, 2>> exclusions, fixedExclusions;
    vector<int> setSizes, setJoints;
    vector<const ctDensity*> setDensities;
};

/**
 * Find the links of the loop, from the root to the link that the closure holds.
 */
static vector<int> findLoop(const LinkStructure& structure)
{
    vector<vector<int>> loops;
    for (auto& ends : structure.getClosures()) {
        const auto path = structure.findPath(ends.first, ends.second);
        const bool isFixed = structure.getMolecules()[structure.getLinks()[ends.first].molecule].fixed &&
                             structure.getMolecules()[structure.getLinks()[ends.second].molecule].fixed;
        if (isFixed && path.first.empty() != path.second.empty()) {
            const vector<int>& links = path.first.empty() ? path.second : path.first;
            loops.push_back(vector<int>(links.rbegin(), links.rend()));
        }
    }
    if (loops.size() != 1)
        fail("the StericExclusionForce must have one closure that ends a loop between fixed parts, but has " +
             to_string(loops.size()) + "; see closures=\"loops\" of createStericExclusionForce()");
    return loops[0];
}

void LoopGrowth::Contents::findPieces(const LinkStructure& structure)
{
    const vector<int> path = findLoop(structure);
    const vector<LinkStructure::Link>& links = structure.getLinks();
    pathCount = path.size();
    linkPieces.assign(links.size(), 0);
    torsionJoints.assign(structure.getTorsionLinks().size(), -1);
    auto addJoint = [&](int link) {
        if (links[link].torsion == -1)
            fail("there is a ball joint in the loop");
        torsionJoints[links[link].torsion] = jointTorsions.size();
        jointTorsions.push_back(links[link].torsion);
    };
    for (int i = 0; i < pathCount; i++) {
        addJoint(path[i]);
        if (i + 1 < pathCount)
            linkPieces[path[i]] = i + 1;
    }

    // Links are in no order of the tree.

    for (bool isChanged = true; isChanged;) {
        isChanged = false;
        for (size_t link = 0; link < links.size(); link++) {
            const int parent = links[link].parent;
            if (linkPieces[link] == 0 && parent != -1 && linkPieces[parent] != 0 && (int)link != path.back()) {
                linkPieces[link] = jointTorsions.size();
                parents.push_back(linkPieces[parent]);
                addJoint(link);
                isChanged = true;
            }
        }
    }
    numJoints = jointTorsions.size();
    for (int torsion : jointTorsions) {
        array<array<double, 3>, 4> joint;
        const array<int, 4> particles = structure.getTorsionParticles(torsion);
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 3; k++)
                joint[i][k] = positions[particles[i]][k];
        jointPositions.push_back(joint);
    }
}

void LoopGrowth::Contents::addParticles(const LinkStructure& structure, const StericExclusionForce& force)
{
    for (int i = 0; i < force.getNumParticles(); i++) {
        double radius;
        StericExclusionForce::HydrogenBondRole role;
        force.getParticleParameters(i, radius, role);
        const int piece = linkPieces[structure.getParticleLinks()[i]];
        isMoving.push_back(piece != 0);
        places.push_back(piece != 0 ? movingRadii.size() : fixedRadii.size());
        (piece != 0 ? movingPositions : fixedPositions).push_back(positions[i]);
        (piece != 0 ? movingRadii : fixedRadii).push_back(radius);
        (piece != 0 ? movingRoles : fixedRoles).push_back(role);
        if (piece != 0) {
            moving.push_back(i);
            pieces.push_back(piece);
        }
    }
}

void LoopGrowth::Contents::addExclusions(const StericExclusionForce& force)
{
    for (int i = 0; i < force.getNumExclusions(); i++) {
        int particle1, particle2;
        force.getExclusionParticles(i, particle1, particle2);
        if (!isMoving[particle1])
            swap(particle1, particle2);
        if (isMoving[particle1])
            (isMoving[particle2] ? exclusions : fixedExclusions).push_back({{places[particle1], places[particle2]}});
    }
}

void LoopGrowth::Contents::addSets(const vector<vector<int>>& torsions, const vector<TorsionDensity>& allDensities)
{
    if (torsions.size() != allDensities.size())
        fail("there must be a density for each of " + to_string(torsions.size()) + " sets of torsions, but there are " +
             to_string(allDensities.size()));
    vector<bool> isDrawn(numJoints, false);
    for (size_t set = 0; set < torsions.size(); set++) {
        const string name = "set " + to_string(set);
        if (torsions[set].size() != (size_t)allDensities[set].getNumTorsions())
            fail(name + " has " + to_string(torsions[set].size()) + " torsions, but its density is of " +
                 to_string(allDensities[set].getNumTorsions()));
        size_t inLoop = 0;
        for (int torsion : torsions[set]) {
            checkIndex(torsion, torsionJoints.size(), "torsion", "LoopGrowth: " + name);
            inLoop += torsionJoints[torsion] != -1 ? 1 : 0;
        }
        if (inLoop == 0)
            continue;
        if (inLoop < torsions[set].size())
            fail(name + " has torsions of the loop and others");
        for (int torsion : torsions[set]) {
            const int joint = torsionJoints[torsion];
            if (isDrawn[joint])
                fail("torsion " + to_string(torsion) + " is in more than one set");
            isDrawn[joint] = true;
            setJoints.push_back(joint);
        }
        setSizes.push_back(inLoop);
        densities.push_back(allDensities[set]);
        setDensities.push_back(allDensities[set].getEngine());
    }
    numDrawn = setJoints.size();
}

ctGrowth* LoopGrowth::Contents::create(const StericExclusionForce& force) const
{
    ctGrowthDefinition definition = {};
    definition.pathCount = pathCount;
    definition.jointCount = numJoints;
    definition.jointPositions = reinterpret_cast<const double(*)[4][3]>(jointPositions.data());
    definition.parents = parents.data();
    definition.particleCount = movingRadii.size();
    definition.positions = reinterpret_cast<const double(*)[3]>(movingPositions.data());
    definition.radii = movingRadii.data();
    definition.roles = movingRoles.data();
    definition.pieces = pieces.data();
    definition.fixedCount = fixedRadii.size();
    definition.fixedPositions = reinterpret_cast<const double(*)[3]>(fixedPositions.data());
    definition.fixedRadii = fixedRadii.data();
    definition.fixedRoles = fixedRoles.data();
    definition.exclusionCount = exclusions.size();
    definition.exclusions = rowsOf(exclusions);
    definition.fixedExclusionCount = fixedExclusions.size();
    definition.fixedExclusions = rowsOf(fixedExclusions);
    definition.tolerance = force.getOverlapTolerance();
    definition.allowance = force.getHydrogenBondAllowance();
    definition.setCount = setSizes.size();
    definition.setSizes = setSizes.data();
    definition.setJoints = setJoints.data();
    definition.densities = setDensities.data();
    const char* problem;
    ctGrowth* created = ctCreateGrowth(&definition, &problem);
    if (created == NULL)
        fail(string("the loop cannot grow: ") + problem);
    return created;
}

LoopGrowth::Contents::Contents(const System& system, const StericExclusionForce& force, const vector<Vec3>& positions,
                               const vector<vector<int>>& torsions, const vector<TorsionDensity>& densities) :
    positions(positions),
    growth(NULL)
{
    if ((int)positions.size() != force.getNumParticles())
        fail("there are " + to_string(positions.size()) + " positions, but the StericExclusionForce has " +
             to_string(force.getNumParticles()) + " particles");
    if (force.usesPeriodicBoundaryConditions())
        fail("periodic boundary conditions are not supported");
    const LinkStructure structure(system, force);
    findPieces(structure);
    addParticles(structure, force);
    addExclusions(force);
    addSets(torsions, densities);
    growth = create(force);
}

LoopGrowth::LoopGrowth(const System& system, const StericExclusionForce& force, const vector<Vec3>& positions,
                       const vector<vector<int>>& torsions, const vector<TorsionDensity>& densities) :
    contents(make_unique<Contents>(system, force, positions, torsions, densities))
{
}

LoopGrowth::~LoopGrowth()
{
}

int LoopGrowth::getNumDrawnTorsions() const
{
    return contents->numDrawn;
}

void LoopGrowth::grow(int seed, int population, int backboneDraws, int sideDraws, vector<Vec3>& positions,
                      double& logWeight, double& logDensity) const
{
    if (seed < 1 || population < 1 || backboneDraws < 1 || sideDraws < 1)
        fail("seed, population, backboneDraws and sideDraws must be above 0");
    RandomNumberGenerator random(seed);
    ctGrowthRun run = {};
    run.population = population;
    run.backboneDraws = backboneDraws;
    run.sideDraws = sideDraws;
    run.uniform = [](void* context) {
        return static_cast<RandomNumberGenerator*>(context)->drawUniform();
    };
    run.context = &random;
    vector<array<double, 3>> grown(contents->moving.size() + 1);
    vector<double> angles(contents->numJoints);
    bool hasMemory;
    positions = contents->positions;
    const bool isGrown = ctGrow(contents->growth, &run, reinterpret_cast<double(*)[3]>(grown.data()), angles.data(),
                                &logWeight, &logDensity, &hasMemory);
    if (!hasMemory)
        throw bad_alloc();
    if (!isGrown) {
        logWeight = -numeric_limits<double>::infinity();
        logDensity = 0;
        return;
    }
    for (size_t i = 0; i < contents->moving.size(); i++)
        positions[contents->moving[i]] = Vec3(grown[i][0], grown[i][1], grown[i][2]);
}
