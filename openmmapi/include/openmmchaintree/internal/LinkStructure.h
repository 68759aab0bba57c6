#ifndef OPENMM_LINKSTRUCTURE_H_
#define OPENMM_LINKSTRUCTURE_H_

#include "openmm/System.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <array>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class works out which particles are rigid relative to each other, from the bonds and torsions of a
 * StericExclusionForce and the masses and virtual sites of a System.
 *
 * A molecule is a connected component of the bonds, a virtual site being tied to the particles that define it. The
 * torsions cut it into links, which form a tree. Its root is the link with the molecule's fixed particles, else the one
 * with its lowest-numbered particle. Every other link hangs on its parent by one torsion, and that torsion moves it and
 * everything that hangs on it.
 */
class OPENMM_EXPORT_CHAINTREE LinkStructure {
public:
    class Link {
    public:
        /** The link that this one hangs on, or -1 if it is the root of its molecule. */
        int parent;
        /** The torsion between this link and its parent, or -1 if it is the root of its molecule. */
        int torsion;
        /** The molecule that this link belongs to. */
        int molecule;
    };
    class Molecule {
    public:
        /** The link that is placed in space; all others of the molecule hang on it. */
        int root;
        /** Whether the root holds fixed particles, so that it never moves. */
        bool fixed;
    };
    /**
     * Work out the links. Takes O((N + torsions) log N) time for N particles and bonds.
     *
     * Throws an OpenMMException that names the culprit if an index is out of range, a particle is bonded to itself, a
     * torsion's particles are not bonded in a row, there are two torsions about one bond, a torsion lies in a ring, or
     * there are fixed particles on both sides of a torsion.
     */
    LinkStructure(const OpenMM::System& system, const StericExclusionForce& force);
    /**
     * All links, in the order of their lowest-numbered particles.
     */
    const std::vector<Link>& getLinks() const
    {
        return links;
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
     * The link that each torsion moves, together with everything that hangs on it.
     */
    const std::vector<int>& getTorsionLinks() const
    {
        return torsionLinks;
    }
    /**
     * Get the four particles of a torsion, those on the root's side first: as they were given, or the other way round.
     * To add to the torsion's value is to turn what it moves right-handedly about the axis from the second to the
     * third.
     */
    std::array<int, 4> getTorsionParticles(int torsion) const;
    /**
     * The molecule of a particle.
     */
    int getParticleMolecule(int particle) const
    {
        return links[particleLinks[particle]].molecule;
    }
    /**
     * Get a torsion that changes the distance between two particles of one molecule, or -1 if none does. Particles on
     * the axis of a torsion keep their distance to both sides of it.
     */
    int findTorsionBetween(int particle1, int particle2) const;

    /**
     * Get numbers that two structures share if, and only if, they have the same links, hanging on each other in the
     * same way: then a state of the one can be a state of the other.
     */
    std::vector<int> describe() const;

private:
    class BondGraph;
    std::pair<int, int> getAxis(int torsion) const
    {
        return std::make_pair(torsionParticles[torsion][1], torsionParticles[torsion][2]);
    }
    void checkTorsions(const BondGraph& graph, const StericExclusionForce& force);
    void findLinks(const BondGraph& graph);
    std::vector<std::vector<int>> joinLinks(const BondGraph& graph, const StericExclusionForce& force) const;
    std::vector<int> findAnchors(const OpenMM::System& system) const;
    void growMolecule(int firstLink, const std::vector<int>& anchors, const std::vector<std::vector<int>>& linkTorsions,
                      const StericExclusionForce& force);
    std::vector<int> hangLinks(int root, int molecule, const std::vector<std::vector<int>>& linkTorsions);
    std::vector<Link> links;
    std::vector<Molecule> molecules;
    std::vector<int> particleLinks;
    std::vector<int> torsionLinks;
    std::vector<std::array<int, 4>> torsionParticles;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_LINKSTRUCTURE_H_*/
