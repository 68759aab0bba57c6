#include "openmmchaintree/internal/LinkStructure.h"
#include "openmm/OpenMMException.h"
#include "openmm/VirtualSite.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void fail(const string& message)
{
    throw OpenMMException("StericExclusionForce: " + message);
}

/**
 * Name a torsion as "torsion 3 (4-5-6-7)".
 */
static string describeTorsion(const StericExclusionForce& force, int torsion)
{
    int p1, p2, p3, p4;
    force.getTorsionParticles(torsion, p1, p2, p3, p4);
    stringstream text;
    text << "torsion " << torsion << " (" << p1 << "-" << p2 << "-" << p3 << "-" << p4 << ")";
    return text.str();
}

/**
 * What is tied together: bonds, and virtual sites with the particles that define them.
 */
class LinkStructure::BondGraph {
public:
    BondGraph(const System& system, const StericExclusionForce& force) : neighbors(force.getNumParticles())
    {
        for (int i = 0; i < force.getNumBonds(); i++) {
            int particle1, particle2;
            force.getBondParticles(i, particle1, particle2);
            string name = "bond " + to_string(i);
            checkIndex(particle1, neighbors.size(), "particle", "StericExclusionForce: " + name);
            checkIndex(particle2, neighbors.size(), "particle", "StericExclusionForce: " + name);
            if (particle1 == particle2)
                fail(name + " ties particle " + to_string(particle1) + " to itself");
            tie(particle1, particle2);
            bonds.insert(minmax(particle1, particle2));
        }
        for (int i = 0; i < system.getNumParticles(); i++)
            if (system.isVirtualSite(i)) {
                const VirtualSite& site = system.getVirtualSite(i);
                for (int j = 0; j < site.getNumParticles(); j++)
                    tie(i, site.getParticle(j));
            }
    }
    bool hasBond(int particle1, int particle2) const
    {
        return bonds.find(minmax(particle1, particle2)) != bonds.end();
    }
    const vector<int>& getNeighbors(int particle) const
    {
        return neighbors[particle];
    }
    /**
     * Find a shortest way from one particle to another that does not use the tie between the two.
     */
    vector<int> findDetour(int from, int to) const
    {
        vector<int> previous(neighbors.size(), -1);
        vector<int> reached(1, from);
        previous[from] = from;
        for (size_t i = 0; i < reached.size() && previous[to] == -1; i++)
            for (int next : neighbors[reached[i]])
                if (previous[next] == -1 && !(reached[i] == from && next == to)) {
                    previous[next] = reached[i];
                    reached.push_back(next);
                }
        vector<int> way(1, to);
        while (way.back() != from)
            way.push_back(previous[way.back()]);
        reverse(way.begin(), way.end());
        return way;
    }

private:
    void tie(int particle1, int particle2)
    {
        neighbors[particle1].push_back(particle2);
        neighbors[particle2].push_back(particle1);
    }
    vector<vector<int>> neighbors;
    set<pair<int, int>> bonds;
};

LinkStructure::LinkStructure(const System& system, const StericExclusionForce& force) :
    particleLinks(force.getNumParticles(), -1), torsionLinks(force.getNumTorsions(), -1)
{
    BondGraph graph(system, force);
    checkTorsions(graph, force);
    findLinks(graph);
    vector<vector<int>> linkTorsions = joinLinks(graph, force);
    vector<int> anchors = findAnchors(system);
    for (int link = 0; link < (int)links.size(); link++)
        if (links[link].molecule == -1)
            growMolecule(link, anchors, linkTorsions, force);
}

/**
 * Record the particles of each torsion, having checked that they are bonded in a row.
 */
void LinkStructure::checkTorsions(const BondGraph& graph, const StericExclusionForce& force)
{
    map<pair<int, int>, int> torsionAbout;
    for (int i = 0; i < force.getNumTorsions(); i++) {
        string name = describeTorsion(force, i);
        int p[4];
        force.getTorsionParticles(i, p[0], p[1], p[2], p[3]);
        for (int particle : p)
            checkIndex(particle, force.getNumParticles(), "particle", "StericExclusionForce: " + name);
        if (set<int>(p, p + 4).size() < 4)
            fail(name + " names a particle twice");
        for (int j = 0; j < 3; j++)
            if (!graph.hasBond(p[j], p[j + 1]))
                fail("the particles of " + name + " must be bonded in a row, but there is no bond between particles " +
                     to_string(p[j]) + " and " + to_string(p[j + 1]));
        auto added = torsionAbout.insert(make_pair(minmax(p[1], p[2]), i));
        if (!added.second)
            fail(describeTorsion(force, added.first->second) + " and " + name + " are about the same bond");
        torsionParticles.push_back({{p[0], p[1], p[2], p[3]}});
    }
}

/**
 * Collect what hangs together without crossing the axis of a torsion.
 */
void LinkStructure::findLinks(const BondGraph& graph)
{
    set<pair<int, int>> axes;
    for (auto& p : torsionParticles)
        axes.insert(minmax(p[1], p[2]));
    for (int start = 0; start < (int)particleLinks.size(); start++) {
        if (particleLinks[start] != -1)
            continue;
        int link = links.size();
        links.push_back({-1, -1, -1});
        particleLinks[start] = link;
        vector<int> pending(1, start);
        while (!pending.empty()) {
            int particle = pending.back();
            pending.pop_back();
            for (int next : graph.getNeighbors(particle))
                if (particleLinks[next] == -1 && axes.find(minmax(particle, next)) == axes.end()) {
                    particleLinks[next] = link;
                    pending.push_back(next);
                }
        }
    }
}

/**
 * List the torsions at each link. A torsion that joins what is joined already closes a ring.
 */
vector<vector<int>> LinkStructure::joinLinks(const BondGraph& graph, const StericExclusionForce& force) const
{
    vector<vector<int>> linkTorsions(links.size());
    vector<int> representative(links.size());
    for (int link = 0; link < (int)links.size(); link++)
        representative[link] = link;
    auto find = [&](int link) {
        while (representative[link] != link)
            link = representative[link] = representative[representative[link]];
        return link;
    };
    for (int torsion = 0; torsion < (int)torsionParticles.size(); torsion++) {
        int particle1 = torsionParticles[torsion][1], particle2 = torsionParticles[torsion][2];
        int link1 = particleLinks[particle1], link2 = particleLinks[particle2];
        if (find(link1) == find(link2)) {
            stringstream ring;
            for (int particle : graph.findDetour(particle1, particle2))
                ring << particle << "-";
            fail(describeTorsion(force, torsion) + " lies in a ring: " + ring.str() + to_string(particle1));
        }
        representative[find(link1)] = find(link2);
        linkTorsions[link1].push_back(torsion);
        linkTorsions[link2].push_back(torsion);
    }
    return linkTorsions;
}

/**
 * Find a fixed particle of each link, or -1 where there is none.
 */
vector<int> LinkStructure::findAnchors(const System& system) const
{
    vector<int> anchors(links.size(), -1);
    for (int i = particleLinks.size() - 1; i >= 0; i--)
        if (system.getParticleMass(i) == 0 && !system.isVirtualSite(i))
            anchors[particleLinks[i]] = i;
    return anchors;
}

/**
 * Make a molecule of a link and all that torsions join to it.
 */
void LinkStructure::growMolecule(int firstLink, const vector<int>& anchors, const vector<vector<int>>& linkTorsions,
                                 const StericExclusionForce& force)
{
    int molecule = molecules.size();
    int root = firstLink;
    for (int link : hangLinks(firstLink, molecule, linkTorsions))
        if (anchors[link] != -1) {
            root = link;
            break;
        }
    molecules.push_back({root, anchors[root] != -1});
    for (int link : hangLinks(root, molecule, linkTorsions))
        if (link != root && anchors[link] != -1)
            fail(describeTorsion(force, links[link].torsion) + " lies between two fixed parts: particles " +
                 to_string(anchors[root]) + " and " + to_string(anchors[link]) + " both have mass 0");
}

/**
 * Hang all links that torsions join to a root on it, and return them, parents first.
 */
vector<int> LinkStructure::hangLinks(int root, int molecule, const vector<vector<int>>& linkTorsions)
{
    links[root] = {-1, -1, molecule};
    vector<int> hung(1, root);
    for (size_t i = 0; i < hung.size(); i++) {
        int parent = hung[i];
        for (int torsion : linkTorsions[parent])
            if (torsion != links[parent].torsion) {
                int link1 = particleLinks[torsionParticles[torsion][1]];
                int link2 = particleLinks[torsionParticles[torsion][2]];
                int child = (link1 == parent ? link2 : link1);
                links[child] = {parent, torsion, molecule};
                torsionLinks[torsion] = child;
                hung.push_back(child);
            }
    }
    return hung;
}

array<int, 4> LinkStructure::getTorsionParticles(int torsion) const
{
    array<int, 4> particles = torsionParticles[torsion];
    if (particleLinks[particles[2]] != torsionLinks[torsion])
        reverse(particles.begin(), particles.end());
    return particles;
}

int LinkStructure::findTorsionBetween(int particle1, int particle2) const
{
    auto findRootward = [&](int link) {
        vector<int> torsions;
        for (; links[link].parent != -1; link = links[link].parent)
            torsions.push_back(links[link].torsion);
        return torsions;
    };
    vector<int> torsions1 = findRootward(particleLinks[particle1]);
    vector<int> torsions2 = findRootward(particleLinks[particle2]);
    while (!torsions1.empty() && !torsions2.empty() && torsions1.back() == torsions2.back()) {
        torsions1.pop_back();
        torsions2.pop_back();
    }
    torsions1.insert(torsions1.end(), torsions2.begin(), torsions2.end());
    for (int torsion : torsions1) {
        const pair<int, int> axis = getAxis(torsion);
        bool onAxis = (particle1 == axis.first || particle1 == axis.second || particle2 == axis.first ||
                       particle2 == axis.second);
        if (!onAxis)
            return torsion;
    }
    return -1;
}

vector<int> LinkStructure::describe() const
{
    vector<int> description = particleLinks;
    for (const Link& link : links) {
        description.push_back(link.parent);
        description.push_back(molecules[link.molecule].fixed);
        if (link.parent != -1) {
            const pair<int, int> axis = getAxis(link.torsion);
            description.push_back(min(axis.first, axis.second));
            description.push_back(max(axis.first, axis.second));
        }
    }
    return description;
}
