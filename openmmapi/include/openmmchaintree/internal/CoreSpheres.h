#ifndef OPENMM_CHAINTREE_CORESPHERES_H_
#define OPENMM_CHAINTREE_CORESPHERES_H_

#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>
#include <vector>

namespace ChainTreePlugin {

/**
 * Spheres whose overlap a force field all but forbids. Trials are tested by them where the radii of the
 * StericExclusionForce count for nothing, so that hopeless trials need no energy.
 *
 * Two particles whose spheres overlap have a Lennard-Jones repulsion that exceeds the Coulomb attraction between them
 * by more than a given energy. Coulomb repulsion counts for nothing. The charges of a pair are those of its
 * Lennard-Jones types that attract each other most.
 *
 * A charged particle without Lennard-Jones, such as the hydrogen of a hydroxyl group in AMBER, gets a sphere of
 * GUARD_RADIUS, for its energy with an opposite charge has no minimum.
 */
class OPENMM_EXPORT_CHAINTREE CoreSpheres {
public:
    /** nm. With the sphere of a partner, whose radius is about 0.1 nm, it keeps opposite charges apart. */
    static constexpr double GUARD_RADIUS = 0.001;
    /** Make no spheres. */
    CoreSpheres() = default;
    /**
     * @param nonbonded  Lennard-Jones and Coulomb of all pairs
     * @param termSets   other terms of the energy; those of two particles exempt their pair
     * @param energy     which a pair exceeds if its spheres overlap, in kJ/mol
     */
    CoreSpheres(const EnergyTerms::Nonbonded& nonbonded, const std::vector<EnergyTerms::TermSet>& termSets,
                double energy);
    bool operator==(const CoreSpheres& other) const
    {
        return radii == other.radii && exclusions == other.exclusions;
    }
    /** For each particle, in nm; 0 if it has no sphere. There are none at all if no trial is to be tested. */
    std::vector<double> radii;
    /** Pairs that may overlap: bonded ones, whose energy is another. */
    std::vector<std::array<int, 2>> exclusions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CORESPHERES_H_*/
