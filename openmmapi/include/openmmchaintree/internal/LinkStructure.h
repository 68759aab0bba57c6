#ifndef OPENMM_LINKSTRUCTURE_H_
#define OPENMM_LINKSTRUCTURE_H_

#include "openmm/System.h"
#include "openmmchaintree/internal/AtomGroups.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class works out which particles are rigid relative to each other, from the bonds, torsions and ball joints of a
 * StericExclusionForce and the masses and virtual sites of a System.
 *
 * A molecule is a connected component of the bonds, a virtual site being tied to the particles that define it, or to
 * those of one side of a torsion if the others are on its axis. Torsions and ball joints cut it into links, which form
 * a tree. Its root is the link with the molecule's fixed particles, else the one with its lowest-numbered particle.
 * Every other link hangs on its parent by one torsion or ball joint, which moves it and its descendants.
 *
 * A closure fixes two links relative to each other. Its ring consists of the joints on the path from one link to the
 * other: the joints up to their common ancestor or, for links of two fixed molecules, up to the roots.
 */
class OPENMM_EXPORT_CHAINTREE LinkStructure {
public:
    class Link {
    public:
        /** The link that this one hangs on, or -1 if it is the root of its molecule. */
        int parent;
        /** The torsion between this link and its parent, or -1 if it is a root or hangs by a ball joint. */
        int torsion;
        /** The ball joint between this link and its parent, or -1 if it is a root or hangs by a torsion. */
        int ballJoint;
        /** The molecule that this link belongs to. */
        int molecule;
    };
    class Molecule {
    public:
        /** The link that is placed in space; all others of the molecule are its descendants. */
        int root;
        /** Whether the root holds fixed particles, so that it never moves. */
        bool fixed;
    };
    /**
     * Work out the links. Takes O((N + joints) log N) time for N particles and bonds.
     *
     * Throws an OpenMMException that names the culprit if an index is out of range, a particle is bonded to itself, the
     * particles of a torsion or ball joint are not bonded in a row, there are two joints about one bond, a joint lies
     * in a ring, there are fixed particles on both sides of a joint, a ball joint changes the dihedral of a torsion, or
     * a closure cannot be one.
     *
     * @param isFlexible  whether moves may displace particles within their links
     */
    LinkStructure(const OpenMM::System& system, const StericExclusionForce& force, bool isFlexible = false);
    ~LinkStructure();
    /**
     * All links, in the order of their lowest-numbered particles.
     */
    const std::vector<Link>& getLinks() const
    {
        return links;
    }
    /**
     * Whether pairs count in all images of a periodic box.
     */
    bool isPeriodic() const
    {
        return periodic;
    }
    /**
     * Get whether moves may displace particles within their links.
     */
    bool isFlexible() const
    {
        return atomGroups != nullptr;
    }
    /**
     * Get which particles such moves displace together. It is an error to ask unless isFlexible().
     */
    const AtomGroups& getAtomGroups() const
    {
        return *atomGroups;
    }
    /**
     * All molecules, in the order of their lowest-numbered particles.
     */
    const std::vector<Molecule>& getMolecules() const
    {
        return molecules;
    }
    /**
     * The link of each particle.
     */
    const std::vector<int>& getParticleLinks() const
    {
        return particleLinks;
    }
    /**
     * The link that each torsion moves, together with its descendants.
     */
    const std::vector<int>& getTorsionLinks() const
    {
        return torsionLinks;
    }
    /**
     * Get the four particles of a torsion, those on the root's side first: as they were given, or the other way round.
     * An increase of the torsion's value turns the moved links right-handedly about the axis from the second to the
     * third.
     */
    std::array<int, 4> getTorsionParticles(int torsion) const;
    /**
     * The link that each ball joint moves, together with its descendants.
     */
    const std::vector<int>& getBallJointLinks() const
    {
        return ballJointLinks;
    }
    /**
     * Get the particle about which a ball joint turns.
     */
    int getBallJointParticle(int ballJoint) const;
    /**
     * Whether there is a torsion or a ball joint.
     */
    bool hasJoints() const
    {
        return !(torsionLinks.empty() && ballJointLinks.empty());
    }
    /**
     * Get the two links that each closure keeps together.
     */
    const std::vector<std::pair<int, int>>& getClosures() const
    {
        return closures;
    }
    /**
     * Get a closure whose ring contains a link's joint to its parent, or -1 if there is none. Only moves that keep the
     * closure may turn such a joint.
     */
    int getLinkClosure(int link) const
    {
        return linkClosures[link];
    }
    /**
     * Get the links whose joints lie on the path between two links: from each of the two towards the root, without
     * their common ancestors.
     */
    std::pair<std::vector<int>, std::vector<int>> findPath(int link1, int link2) const;
    /**
     * Throw an exception if a link's joint lies in the ring of a closure.
     *
     * @param name  who names the joint, for the message
     */
    void checkNoClosure(int link, const std::string& name) const;
    /**
     * Get whether closures fix two particles relative to each other, as if they were in one link.
     */
    bool areKeptTogether(int particle1, int particle2) const
    {
        return keptWith[particleLinks[particle1]] == keptWith[particleLinks[particle2]];
    }
    /**
     * Get whether a torsion moves a link.
     */
    bool moves(int torsion, int link) const
    {
        const int first = torsionLinks[torsion];
        return order[link] >= order[first] && order[link] < ends[first];
    }
    /**
     * The molecule of a particle.
     */
    int getParticleMolecule(int particle) const
    {
        return links[particleLinks[particle]].molecule;
    }
    /**
     * Get the name of a torsion or ball joint that changes the distance between two particles of one molecule, as
     * "torsion 3", or an empty text if none does. A particle on the axis of a torsion keeps its distance to both sides,
     * and so does the particle about which a ball joint turns.
     */
    std::string findJointBetween(int particle1, int particle2) const;
    /**
     * The same for a joint that turns the line between two particles relative to one of their links: any joint between
     * them except a torsion about that line.
     */
    std::string findJointTurning(int particle1, int particle2) const;

    /**
     * Get numbers that are equal for two structures if and only if they have the same tree of links, so that they share
     * states.
     */
    std::vector<int> describe() const;

private:
    class BondGraph;
    class Joint;
    void listJoints(const BondGraph& graph, const StericExclusionForce& force);
    void checkDihedrals() const;
    std::vector<int> findParts(const BondGraph& graph) const;
    void tieVirtualSites(const OpenMM::System& system, BondGraph& graph) const;
    void checkNoJointParts(const BondGraph& graph, int site, int particle1, int particle2) const;
    std::vector<std::vector<int>> joinLinks(const BondGraph& graph) const;
    std::vector<int> findAnchors(const OpenMM::System& system) const;
    void growMolecule(int firstLink, const std::vector<int>& anchors, const std::vector<std::vector<int>>& linkJoints);
    std::vector<int> hangLinks(int root, int molecule, const std::vector<std::vector<int>>& linkJoints);
    int findJointOf(const Link& link) const;
    std::vector<int> findJointsBetween(int particle1, int particle2) const;
    void orderLinks();
    void findClosures(const BondGraph& graph, const StericExclusionForce& force);
    std::vector<int> findRootward(int link) const;
    bool periodic;
    std::shared_ptr<const AtomGroups> atomGroups;
    std::vector<Link> links;
    std::vector<Molecule> molecules;
    std::vector<int> particleLinks;
    std::vector<int> torsionLinks, ballJointLinks;
    /** All joints: first the torsions, then the ball joints. */
    std::vector<Joint> joints;
    /** The particles of the bonds of closures, the lower first, and the links that they keep together. */
    std::vector<std::pair<int, int>> closureBonds, closures;
    std::vector<int> linkClosures;
    /** One representative of the links that closures fix to this one. */
    std::vector<int> keptWith;
    /** The place of each link in depth-first order; its descendants follow it, up to the place in `ends`. */
    std::vector<int> order, ends;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_LINKSTRUCTURE_H_*/
