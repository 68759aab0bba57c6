#ifndef OPENMM_CHAINTREE_LOOPGROWTH_H_
#define OPENMM_CHAINTREE_LOOPGROWTH_H_

#include "openmm/System.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "openmmchaintree/TorsionDensity.h"
#include <memory>
#include <vector>

namespace ChainTreePlugin {

/**
 * Grows conformations of a loop between two fixed ends, each independent of all others and of the present one, with a
 * weight. Torsions of the loop are drawn from densities, set by set, from both ends; sets that clash are drawn again;
 * in the middle, phi and psi of three residues close the loop exactly.
 *
 * With a weight Z for each conformation, weighted means over independent conformations are means over the target: the
 * product of the densities of all sets, divided by the determinant of the closing torsions (ctgrowth.h), for loops
 * without clashes. For uniform densities this is the distribution that TorsionMonteCarloIntegrator samples with hard
 * spheres alone. To get means over another distribution exp(-U/kT) of torsions, multiply each weight by exp(-U/kT) and
 * divide it by the density that grow() returns. What is neither loop nor fixed keeps its place, too.
 */
class OPENMM_EXPORT_CHAINTREE LoopGrowth {
public:
    /**
     * Prepare growth, which takes some tenths of a second. It is an error if the force has not exactly one closure
     * between links of fixed molecules, uses periodic boundary conditions, or has a ball joint in the loop; if sets
     * share torsions or have torsions of both the backbone and a side chain, or of several residues' side chains; or if
     * no three residues can close the loop.
     *
     * @param system     the System, whose particles of mass 0 are fixed
     * @param force      the spheres, torsions and the closure of the loop
     * @param positions  a conformation in which the loop is closed, which gives all bond lengths and angles, in nm
     * @param torsions   sets of torsions to be drawn; those outside the loop are ignored. Torsions in no set keep their
     *                   present values.
     * @param densities  the density of each set
     */
    LoopGrowth(const OpenMM::System& system, const StericExclusionForce& force,
               const std::vector<OpenMM::Vec3>& positions, const std::vector<std::vector<int>>& torsions,
               const std::vector<TorsionDensity>& densities);
    ~LoopGrowth();
    LoopGrowth(const LoopGrowth&) = delete;
    LoopGrowth& operator=(const LoopGrowth&) = delete;
    /**
     * Get the number of torsions of the loop that are drawn.
     */
    int getNumDrawnTorsions() const;
    /**
     * Grow a conformation. Calls with the same arguments give the same one. Several threads may call this.
     *
     * @param seed           the random number seed, at least 1
     * @param population     the number of loops that grow together, of which one is drawn. More take longer, and make
     *                       weights more equal.
     * @param backboneDraws  how often a set of backbone torsions is drawn in each step of each loop
     * @param sideDraws      how often a side chain is drawn for each free draw of the backbone
     * @param[out] positions   the positions of all particles, in nm; those before if no loop was left
     * @param[out] logWeight   the logarithm of the weight Z; -infinity if no loop was left
     * @param[out] logDensity  the logarithm of the product of the densities of all sets, per radian of each torsion
     */
    void grow(int seed, int population, int backboneDraws, int sideDraws, std::vector<OpenMM::Vec3>& positions,
              double& logWeight, double& logDensity) const;

private:
    class Contents;
    std::unique_ptr<Contents> contents;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_LOOPGROWTH_H_*/
