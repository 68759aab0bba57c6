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
 * A joint of a link and its parent: a torsion, or a ball joint, which turns about the first of its particles.
 */
class LinkStructure::Joint {
public:
    Joint(const string& kind, int index, const vector<int>& particles) :
        name(kind + " " + to_string(index)), particles(particles)
    {
    }
    bool isBall() const
    {
        return particles.size() == 2;
    }
    /**
     * Get the two particles of its bond.
     */
    pair<int, int> getBond() const
    {
        return isBall() ? make_pair(particles[0], particles[1]) : make_pair(particles[1], particles[2]);
    }
    /**
     * Get whether a particle keeps its place relative to both sides.
     */
    bool leavesInPlace(int particle) const
    {
        return particle == getBond().first || (!isBall() && particle == getBond().second);
    }
    /**
     * Name it as "torsion 3 (4-5-6-7)".
     */
    string describe() const
    {
        stringstream text;
        text << name << " (" << particles[0];
        for (size_t i = 1; i < particles.size(); i++)
            text << "-" << particles[i];
        text << ")";
        return text.str();
    }
    string name;
    vector<int> particles;
};

/**
 * The graph of bonds, and of virtual sites with the particles that define them.
 */
class LinkStructure::BondGraph {
public:
    BondGraph(const StericExclusionForce& force) : neighbors(force.getNumParticles())
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
    }
    void tie(int particle1, int particle2)
    {
        neighbors[particle1].push_back(particle2);
        neighbors[particle2].push_back(particle1);
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
     * Find a shortest path from one particle to another; empty if there is none.
     *
     * @param isDetour  whether it may not use the tie between the two
     */
    vector<int> findWay(int from, int to, bool isDetour) const
    {
        vector<int> previous(neighbors.size(), -1);
        vector<int> reached(1, from);
        previous[from] = from;
        for (size_t i = 0; i < reached.size() && previous[to] == -1; i++)
            for (int next : neighbors[reached[i]])
                if (previous[next] == -1 && !(isDetour && reached[i] == from && next == to)) {
                    previous[next] = reached[i];
                    reached.push_back(next);
                }
        if (previous[to] == -1)
            return vector<int>();
        vector<int> way(1, to);
        while (way.back() != from)
            way.push_back(previous[way.back()]);
        reverse(way.begin(), way.end());
        return way;
    }

private:
    vector<vector<int>> neighbors;
    set<pair<int, int>> bonds;
};

LinkStructure::LinkStructure(const System& system, const StericExclusionForce& force, bool isFlexible) :
    periodic(force.usesPeriodicBoundaryConditions()), particleLinks(force.getNumParticles(), -1),
    torsionLinks(force.getNumTorsions(), -1), ballJointLinks(force.getNumBallJoints(), -1)
{
    BondGraph graph(force);
    listJoints(graph, force);
    checkDihedrals();
    tieVirtualSites(system, graph);
    particleLinks = findParts(graph);
    const int numLinks = particleLinks.empty() ? 0 : *max_element(particleLinks.begin(), particleLinks.end()) + 1;
    links.assign(numLinks, {-1, -1, -1, -1});
    vector<vector<int>> linkJoints = joinLinks(graph);
    vector<int> anchors = findAnchors(system);
    for (int link = 0; link < (int)links.size(); link++)
        if (links[link].molecule == -1)
            growMolecule(link, anchors, linkJoints);
    orderLinks();
    findClosures(graph, force);
    if (isFlexible)
        atomGroups = make_shared<AtomGroups>(system, force, *this);
}

LinkStructure::~LinkStructure()
{
}

/**
 * Check that joints lie in bonds, and list them.
 */
void LinkStructure::listJoints(const BondGraph& graph, const StericExclusionForce& force)
{
    for (int i = 0; i < force.getNumTorsions(); i++) {
        vector<int> p(4);
        force.getTorsionParticles(i, p[0], p[1], p[2], p[3]);
        joints.push_back(Joint("torsion", i, p));
    }
    for (int i = 0; i < force.getNumBallJoints(); i++) {
        vector<int> p(2);
        force.getBallJointParticles(i, p[0], p[1]);
        joints.push_back(Joint("ball joint", i, p));
    }
    map<pair<int, int>, int> jointAbout;
    for (int i = 0; i < (int)joints.size(); i++) {
        const vector<int>& p = joints[i].particles;
        string name = joints[i].describe();
        for (int particle : p)
            checkIndex(particle, force.getNumParticles(), "particle", "StericExclusionForce: " + name);
        if (set<int>(p.begin(), p.end()).size() < p.size())
            fail(name + " names a particle twice");
        for (size_t j = 0; j + 1 < p.size(); j++)
            if (!graph.hasBond(p[j], p[j + 1]))
                fail("the particles of " + name + " must be bonded" + (joints[i].isBall() ? "" : " in a row") +
                     ", but there is no bond between particles " + to_string(p[j]) + " and " + to_string(p[j + 1]));
        auto added = jointAbout.insert(make_pair(minmax(joints[i].getBond().first, joints[i].getBond().second), i));
        if (!added.second)
            fail(joints[added.first->second].describe() + " and " + name + " are about the same bond");
    }
}

/**
 * Throw an exception if a ball joint moves an outer particle of a torsion about the torsion's axis: the value of the
 * torsion would not be the sum of its changes.
 */
void LinkStructure::checkDihedrals() const
{
    map<pair<int, int>, int> ballAt; // by the particle that it turns about and the other one
    for (int i = 0; i < (int)joints.size(); i++)
        if (joints[i].isBall())
            ballAt[joints[i].getBond()] = i;
    for (const Joint& torsion : joints) {
        if (torsion.isBall())
            break;
        for (int side = 0; side < 2; side++) {
            const vector<int>& p = torsion.particles;
            const int inner = side == 0 ? p[1] : p[2], outer = side == 0 ? p[0] : p[3];
            auto found = ballAt.find(make_pair(inner, outer));
            if (found != ballAt.end())
                fail(joints[found->second].describe() + " changes the dihedral of " + torsion.describe() +
                     "; name another particle bonded to particle " + to_string(inner) + " in the torsion, or leave " +
                     "the torsion out");
        }
    }
}

/**
 * Number the parts that are connected without crossing the bond of a joint, in the order of their first particles.
 */
vector<int> LinkStructure::findParts(const BondGraph& graph) const
{
    set<pair<int, int>> cuts;
    for (const Joint& joint : joints)
        cuts.insert(minmax(joint.getBond().first, joint.getBond().second));
    vector<int> parts(particleLinks.size(), -1);
    int numParts = 0;
    for (int start = 0; start < (int)parts.size(); start++) {
        if (parts[start] != -1)
            continue;
        parts[start] = numParts;
        vector<int> pending(1, start);
        while (!pending.empty()) {
            int particle = pending.back();
            pending.pop_back();
            for (int next : graph.getNeighbors(particle))
                if (parts[next] == -1 && cuts.find(minmax(particle, next)) == cuts.end()) {
                    parts[next] = numParts;
                    pending.push_back(next);
                }
        }
        numParts++;
    }
    return parts;
}

/**
 * Tie each virtual site to the particles of one part that define it. Its other particles must keep their place relative
 * to that part, like particles on the axis of a torsion, or be of another molecule.
 */
void LinkStructure::tieVirtualSites(const System& system, BondGraph& graph) const
{
    const vector<int> parts = findParts(graph);
    set<pair<int, int>> kept; // particles, and parts beside their own in which they keep their place
    for (const Joint& joint : joints) {
        const pair<int, int> bond = joint.getBond();
        kept.insert(make_pair(bond.first, parts[bond.second]));
        if (!joint.isBall())
            kept.insert(make_pair(bond.second, parts[bond.first]));
    }
    const BondGraph bonded = graph;
    for (int i = 0; i < system.getNumParticles(); i++) {
        if (!system.isVirtualSite(i))
            continue;
        const VirtualSite& site = system.getVirtualSite(i);
        vector<int> particles(1, i);
        for (int j = 0; j < site.getNumParticles(); j++)
            particles.push_back(site.getParticle(j));
        auto isPlacedBy = [&](int part) {
            return all_of(particles.begin() + 1, particles.end(), [&](int particle) {
                return parts[particle] == part || kept.find(make_pair(particle, part)) != kept.end();
            });
        };
        auto found = find_if(particles.begin(), particles.end(), [&](int particle) {
            return isPlacedBy(parts[particle]);
        });
        for (size_t j = 1; j < particles.size(); j++) {
            if (found == particles.end())
                checkNoJointParts(bonded, i, particles[1], particles[j]);
            if (found == particles.end() || parts[particles[j]] == parts[*found])
                graph.tie(i, particles[j]);
        }
    }
}

/**
 * Throw an exception if a joint moves two particles, which define a virtual site, relative to each other.
 */
void LinkStructure::checkNoJointParts(const BondGraph& graph, int site, int particle1, int particle2) const
{
    const vector<int> way = graph.findWay(particle1, particle2, false);
    for (size_t i = 1; i < way.size(); i++)
        for (const Joint& joint : joints)
            if (minmax(joint.getBond().first, joint.getBond().second) == minmax(way[i - 1], way[i]) &&
                !joint.leavesInPlace(particle1) && !joint.leavesInPlace(particle2))
                fail("virtual site " + to_string(site) + " is defined by particles " + to_string(particle1) + " and " +
                     to_string(particle2) + ", which " + joint.describe() +
                     " would move relative to each other; leave that out");
}

/**
 * List the joints at each link. A joint between links that are connected already closes a ring, which is an error.
 */
vector<vector<int>> LinkStructure::joinLinks(const BondGraph& graph) const
{
    vector<vector<int>> linkJoints(links.size());
    vector<int> representative(links.size());
    for (int link = 0; link < (int)links.size(); link++)
        representative[link] = link;
    auto find = [&](int link) {
        while (representative[link] != link)
            link = representative[link] = representative[representative[link]];
        return link;
    };
    for (int joint = 0; joint < (int)joints.size(); joint++) {
        int particle1 = joints[joint].getBond().first, particle2 = joints[joint].getBond().second;
        int link1 = particleLinks[particle1], link2 = particleLinks[particle2];
        if (find(link1) == find(link2)) {
            stringstream ring;
            for (int particle : graph.findWay(particle1, particle2, true))
                ring << particle << "-";
            fail(joints[joint].describe() + " lies in a ring: " + ring.str() + to_string(particle1));
        }
        representative[find(link1)] = find(link2);
        linkJoints[link1].push_back(joint);
        linkJoints[link2].push_back(joint);
    }
    return linkJoints;
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
 * Make a molecule of all links that joints connect to a link.
 */
void LinkStructure::growMolecule(int firstLink, const vector<int>& anchors, const vector<vector<int>>& linkJoints)
{
    int molecule = molecules.size();
    int root = firstLink;
    for (int link : hangLinks(firstLink, molecule, linkJoints))
        if (anchors[link] != -1) {
            root = link;
            break;
        }
    molecules.push_back({root, anchors[root] != -1});
    for (int link : hangLinks(root, molecule, linkJoints))
        if (link != root && anchors[link] != -1)
            fail(joints[findJointOf(links[link])].describe() + " lies between two fixed parts: particles " +
                 to_string(anchors[root]) + " and " + to_string(anchors[link]) + " both have mass 0");
}

/**
 * Set the parents of all links that joints connect to a root, and return them, parents first.
 */
vector<int> LinkStructure::hangLinks(int root, int molecule, const vector<vector<int>>& linkJoints)
{
    const int numTorsions = torsionLinks.size();
    links[root] = {-1, -1, -1, molecule};
    vector<int> hung(1, root);
    for (size_t i = 0; i < hung.size(); i++) {
        int parent = hung[i];
        for (int joint : linkJoints[parent])
            if (joint != findJointOf(links[parent])) {
                int link1 = particleLinks[joints[joint].getBond().first];
                int link2 = particleLinks[joints[joint].getBond().second];
                int child = (link1 == parent ? link2 : link1);
                if (joints[joint].isBall()) {
                    links[child] = {parent, -1, joint - numTorsions, molecule};
                    ballJointLinks[joint - numTorsions] = child;
                }
                else {
                    links[child] = {parent, joint, -1, molecule};
                    torsionLinks[joint] = child;
                }
                hung.push_back(child);
            }
    }
    return hung;
}

/**
 * Number all links in depth-first order.
 */
void LinkStructure::orderLinks()
{
    vector<vector<int>> children(links.size());
    for (int link = 0; link < (int)links.size(); link++)
        if (links[link].parent != -1)
            children[links[link].parent].push_back(link);
    order.resize(links.size());
    ends.resize(links.size());
    vector<int> sorted;
    for (const Molecule& molecule : molecules) {
        vector<int> pending(1, molecule.root);
        while (!pending.empty()) {
            const int link = pending.back();
            pending.pop_back();
            order[link] = sorted.size();
            sorted.push_back(link);
            pending.insert(pending.end(), children[link].begin(), children[link].end());
        }
    }
    for (int i = sorted.size() - 1; i >= 0; i--) {
        const int link = sorted[i];
        ends[link] = i + 1;
        for (int child : children[link])
            ends[link] = max(ends[link], ends[child]);
    }
}

/**
 * List a link and its ancestors, without the root.
 */
vector<int> LinkStructure::findRootward(int link) const
{
    vector<int> way;
    for (; links[link].parent != -1; link = links[link].parent)
        way.push_back(link);
    return way;
}

pair<vector<int>, vector<int>> LinkStructure::findPath(int link1, int link2) const
{
    vector<int> side1 = findRootward(link1), side2 = findRootward(link2);
    while (!side1.empty() && !side2.empty() && side1.back() == side2.back()) {
        side1.pop_back();
        side2.pop_back();
    }
    return {side1, side2};
}

/**
 * Check each closure, and record the links that it fixes to each other and the joints of its ring.
 */
void LinkStructure::findClosures(const BondGraph& graph, const StericExclusionForce& force)
{
    linkClosures.assign(links.size(), -1);
    keptWith.resize(links.size());
    for (int link = 0; link < (int)links.size(); link++)
        keptWith[link] = link;
    for (int i = 0; i < force.getNumClosures(); i++) {
        int p[4];
        force.getClosureParticles(i, p[0], p[1], p[2], p[3]);
        stringstream text;
        text << "closure " << i << " (" << p[0] << "-" << p[1] << "-" << p[2] << "-" << p[3] << ")";
        const string name = text.str();
        for (int particle : p)
            checkIndex(particle, force.getNumParticles(), "particle", "StericExclusionForce: " + name);
        for (int j = 0; j < 4; j += 2)
            if (!graph.hasBond(p[j], p[j + 1]))
                fail("the first two particles of " + name + " must be bonded, and the last two, but there is no bond " +
                     "between particles " + to_string(p[j]) + " and " + to_string(p[j + 1]));
        if (p[1] == p[2] || graph.hasBond(p[1], p[2]))
            fail("the bond of " + name + ", between particles " + to_string(p[1]) + " and " + to_string(p[2]) +
                 ", must not be among the bonds");
        const pair<int, int> bond = minmax(p[1], p[2]);
        if (find(closureBonds.begin(), closureBonds.end(), bond) != closureBonds.end())
            fail("the bond of " + name + " has a closure already");
        const int link1 = particleLinks[p[1]], link2 = particleLinks[p[2]];
        const int molecule1 = links[link1].molecule, molecule2 = links[link2].molecule;
        if (molecule1 != molecule2 && !(molecules[molecule1].fixed && molecules[molecule2].fixed))
            fail(name + " closes nothing: particles " + to_string(p[1]) + " and " + to_string(p[2]) +
                 " belong to different molecules, and not both of these have fixed particles; add a bond instead");
        closureBonds.push_back(bond);
        closures.push_back(make_pair(link1, link2));
        const auto path = findPath(link1, link2);
        for (const vector<int>& side : {path.first, path.second})
            for (int link : side)
                if (linkClosures[link] == -1)
                    linkClosures[link] = i;
        const int kept = keptWith[link1], joined = keptWith[link2];
        replace(keptWith.begin(), keptWith.end(), joined, kept);
    }
}

void LinkStructure::checkNoClosure(int link, const string& name) const
{
    const int closure = linkClosures[link];
    if (closure != -1)
        throw OpenMMException(name + " names " + joints[findJointOf(links[link])].name +
                              ", which lies in the ring of closure " + to_string(closure) + "; " +
                              (links[link].torsion == -1 ? "no move turns it" : "only closed moves turn it"));
}

array<int, 4> LinkStructure::getTorsionParticles(int torsion) const
{
    const vector<int>& given = joints[torsion].particles;
    array<int, 4> particles = {{given[0], given[1], given[2], given[3]}};
    if (particleLinks[particles[2]] != torsionLinks[torsion])
        reverse(particles.begin(), particles.end());
    return particles;
}

int LinkStructure::getBallJointParticle(int ballJoint) const
{
    return joints[torsionLinks.size() + ballJoint].particles[0];
}

/**
 * Get the joint by which a link hangs on its parent, or -1 if it is a root.
 */
int LinkStructure::findJointOf(const Link& link) const
{
    return link.ballJoint == -1 ? link.torsion : (int)torsionLinks.size() + link.ballJoint;
}

/**
 * Get the joints on the path from one particle to another of the same molecule.
 */
vector<int> LinkStructure::findJointsBetween(int particle1, int particle2) const
{
    const auto path = findPath(particleLinks[particle1], particleLinks[particle2]);
    vector<int> between;
    for (const vector<int>& side : {path.first, path.second})
        for (int link : side)
            between.push_back(findJointOf(links[link]));
    return between;
}

string LinkStructure::findJointBetween(int particle1, int particle2) const
{
    for (int joint : findJointsBetween(particle1, particle2))
        if (!joints[joint].leavesInPlace(particle1) && !joints[joint].leavesInPlace(particle2))
            return joints[joint].name;
    return "";
}

string LinkStructure::findJointTurning(int particle1, int particle2) const
{
    for (int joint : findJointsBetween(particle1, particle2))
        if (!joints[joint].leavesInPlace(particle1) || !joints[joint].leavesInPlace(particle2))
            return joints[joint].name;
    return "";
}

vector<int> LinkStructure::describe() const
{
    vector<int> description = particleLinks;
    for (const Link& link : links) {
        description.push_back(link.parent);
        description.push_back(molecules[link.molecule].fixed);
        if (link.parent != -1) {
            // A ball joint is written as its particle twice, which distinguishes it from a torsion.

            auto bond = joints[findJointOf(link)].getBond();
            if (link.ballJoint != -1)
                bond.second = bond.first;
            description.push_back(min(bond.first, bond.second));
            description.push_back(max(bond.first, bond.second));
        }
    }
    vector<pair<int, int>> bonds = closureBonds;
    sort(bonds.begin(), bonds.end());
    for (auto& bond : bonds) {
        description.push_back(bond.first);
        description.push_back(bond.second);
    }
    return description;
}
