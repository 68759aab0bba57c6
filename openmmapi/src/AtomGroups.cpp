#include "openmmchaintree/internal/AtomGroups.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include <algorithm>
#include <cmath>
#include <numeric>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** In amu: heavier than a hydrogen whose mass was repartitioned, 4 at most. */
static const double LEAST_HEAVY_MASS = 4.5;

AtomGroups::AtomGroups(const System& system, const StericExclusionForce& force, const LinkStructure& structure) :
    links(structure.getParticleLinks()), neighbors(links.size()), siteOf(links.size(), NULL), sitesBy(links.size())
{
    vector<bool> canChoose(structure.getMolecules().size(), false);
    for (int i = 0; i < (int)links.size(); i++) {
        double radius;
        StericExclusionForce::HydrogenBondRole role;
        force.getParticleParameters(i, radius, role);
        const int molecule = structure.getParticleMolecule(i);
        if (radius > 0 || links[i] != structure.getMolecules()[molecule].root)
            canChoose[molecule] = true;
        masses.push_back(system.getParticleMass(i));
        if (system.isVirtualSite(i))
            sites.push_back(VirtualPlace(system, i));
    }
    for (int i = 0; i < (int)links.size(); i++) {
        const LinkStructure::Molecule& molecule = structure.getMolecules()[structure.getParticleMolecule(i)];
        isFixed.push_back(molecule.fixed && molecule.root == links[i]);
        isDefault.push_back(canChoose[structure.getParticleMolecule(i)]);
    }
    for (const VirtualPlace& site : sites) {
        siteOf[site.getSite()] = &site;
        for (int particle : site.getParticles())
            sitesBy[particle].push_back(&site);
    }
    auto join = [&](int particle1, int particle2) {
        if (siteOf[particle1] != NULL || siteOf[particle2] != NULL)
            return;
        neighbors[particle1].push_back(particle2);
        neighbors[particle2].push_back(particle1);
    };
    for (int i = 0; i < force.getNumBonds(); i++) {
        int particle1, particle2;
        force.getBondParticles(i, particle1, particle2);
        join(particle1, particle2);
    }
    for (int i = 0; i < force.getNumClosures(); i++) {
        int particle1, particle2, particle3, particle4;
        force.getClosureParticles(i, particle1, particle2, particle3, particle4);
        join(particle2, particle3);
    }
    joinUnits(system);
}

AtomGroups::~AtomGroups()
{
}

/**
 * Make one unit of particles that constraints join.
 */
void AtomGroups::joinUnits(const System& system)
{
    units.resize(masses.size());
    iota(units.begin(), units.end(), 0);
    auto find = [&](int particle) {
        while (units[particle] != particle)
            particle = units[particle] = units[units[particle]];
        return particle;
    };
    vector<pair<int, int>> betweenLinks;
    for (int i = 0; i < system.getNumConstraints(); i++) {
        int particle1, particle2;
        double distance;
        system.getConstraintParameters(i, particle1, particle2, distance);
        units[find(particle1)] = find(particle2);
        if (links[particle1] != links[particle2])
            betweenLinks.push_back(make_pair(particle1, particle2));
    }
    members.resize(masses.size());
    for (int i = 0; i < (int)units.size(); i++) {
        units[i] = find(i);
        members[units[i]].push_back(i);
    }
    for (auto& pair : betweenLinks)
        torn.insert(make_pair(units[pair.first], pair));
}

bool AtomGroups::isHydrogen(int particle) const
{
    return masses[particle] > 0 && masses[particle] < LEAST_HEAVY_MASS && neighbors[particle].size() == 1;
}

vector<int> AtomGroups::findDefaults() const
{
    vector<int> found;
    for (int i = 0; i < (int)units.size(); i++)
        if (siteOf[i] == NULL && isDefault[i] && !isFixed[i])
            found.push_back(i);
    return found;
}

vector<int> AtomGroups::findFirstOfUnits(const vector<int>& particles) const
{
    vector<bool> isFound(units.size(), false);
    vector<int> first;
    for (int particle : particles)
        if (!isFound[units[particle]]) {
            isFound[units[particle]] = true;
            first.push_back(particle);
        }
    return first;
}

/**
 * Throw an exception if constraints join particles of two links.
 */
void AtomGroups::checkUnit(int unit, const string& name) const
{
    auto found = torn.find(unit);
    if (found != torn.end())
        throw OpenMMException(name + " cannot displace particles " + to_string(found->second.first) + " and " +
                              to_string(found->second.second) +
                              " as one: a constraint joins them, but a torsion or ball joint is between them; "
                              "build the System with constraints=None");
}

AtomGroups::Group AtomGroups::makeGroup(int particle, bool withHydrogens, const string& name) const
{
    if (siteOf[particle] != NULL)
        throw OpenMMException(name + " names particle " + to_string(particle) +
                              ", a virtual site, which follows the particles that define it; name these");
    if (isFixed[particle])
        throw OpenMMException(name + " names particle " + to_string(particle) +
                              (masses[particle] == 0 ? ", whose mass is 0, so that it is fixed"
                                                     : ", which is in a rigid link with a fixed particle"));
    Group group;
    vector<int> joined(1, units[particle]);
    const vector<int>& unit = members[units[particle]];
    if (withHydrogens && !all_of(unit.begin(), unit.end(), [&](int one) {
            return isHydrogen(one);
        }))
        for (int one : unit)
            for (int neighbor : neighbors[one])
                if (isHydrogen(neighbor) && find(joined.begin(), joined.end(), units[neighbor]) == joined.end())
                    joined.push_back(units[neighbor]);
    for (int one : joined) {
        checkUnit(one, name);
        group.particles.insert(group.particles.end(), members[one].begin(), members[one].end());
    }
    sort(group.particles.begin(), group.particles.end());
    describe(group);
    addSites(group, name);
    for (int one : group.particles)
        if (isFixed[one])
            throw OpenMMException(name + " displaces particle " + to_string(one) + " with particle " +
                                  to_string(particle) + ", but it is in a rigid link with a fixed particle");
    return group;
}

static bool contains(const vector<int>& sorted, int particle)
{
    return binary_search(sorted.begin(), sorted.end(), particle);
}

/**
 * Compute the mass of a group and the number of its bonds to others.
 */
void AtomGroups::describe(Group& group) const
{
    double mass = 0;
    int numBonds = 0;
    for (int one : group.particles) {
        mass += masses[one];
        for (int neighbor : neighbors[one])
            numBonds += !contains(group.particles, neighbor);
    }
    group.stiffness = make_pair((int)lround(mass), numBonds);
}

/**
 * Add the virtual sites that follow the particles of a group.
 */
void AtomGroups::addSites(Group& group, const string& name) const
{
    const vector<int> moved = group.particles;
    vector<const VirtualPlace*> found;
    for (int one : moved)
        for (const VirtualPlace* site : sitesBy[one])
            if (find(found.begin(), found.end(), site) == found.end())
                found.push_back(site);
    for (const VirtualPlace* site : found) {
        const vector<int>& particles = site->getParticles();
        const int index = site->getSite();
        const string problem = !site->isKnown()          ? "is an image by symmetry"
                               : !sitesBy[index].empty() ? "defines another virtual site"
                               : isFixed[index]          ? "is in a rigid link with a fixed particle"
                                                         : "";
        if (!problem.empty())
            throw OpenMMException(name + " displaces particle " + to_string(moved[0]) + ", which virtual site " +
                                  to_string(index) + " follows, but this " + problem + "; leave the particle out");
        if (all_of(particles.begin(), particles.end(), [&](int one) {
                return contains(moved, one);
            }))
            group.particles.push_back(index);
        else
            group.sites.push_back(site);
    }
}
