#ifndef OPENMM_CHAINTREE_CORESPHERES_H_
#define OPENMM_CHAINTREE_CORESPHERES_H_

#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>
#include <vector>

namespace ChainTreePlugin {

/**
 * Spheres whose overlap a force field all but forbids. With the steric mode Off they replace the radii of the
 * StericExclusionForce in tests of trials, so that hopeless trials need no energy.
 *
 * If two spheres overlap, the Lennard-Jones repulsion of their particles exceeds their Coulomb attraction by more than
 * a given energy. Coulomb repulsion is ignored. For each pair of Lennard-Jones types, the charges that attract each
 * other most are taken.
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
     * @param energy     exceeded by every pair whose spheres overlap, in kJ/mol
     */
    CoreSpheres(const EnergyTerms::Nonbonded& nonbonded, const std::vector<EnergyTerms::TermSet>& termSets,
                double energy);
    bool operator==(const CoreSpheres& other) const
    {
        return radii == other.radii && exclusions == other.exclusions;
    }
    /** For each particle, in nm; 0 if it has no sphere. Empty if trials are not tested. */
    std::vector<double> radii;
    /** Pairs that may overlap: bonded ones, which have other energy terms. */
    std::vector<std::array<int, 2>> exclusions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CORESPHERES_H_*/
