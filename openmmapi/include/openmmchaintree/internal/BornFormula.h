#ifndef OPENMM_CHAINTREE_BORNFORMULA_H_
#define OPENMM_CHAINTREE_BORNFORMULA_H_

#include "openmmchaintree/internal/EnergyTerms.h"

namespace ChainTreePlugin {

/**
 * Computes the formulas of ctBorn for one particle or pair in double precision, to compare a Force with its
 * translation.
 */
class BornFormula {
public:
    explicit BornFormula(const EnergyTerms::Born& born) : born(born)
    {
    }
    /**
     * Get the contribution of particle j to the Born sum of particle i at a distance.
     */
    double computePairSum(int i, int j, double distance) const;
    double computeRadius(int i, double sum) const;
    /**
     * Get the energy of a particle that has this Born radius, surface energy included.
     */
    double computeSelfEnergy(int i, double radius) const;
    double computePairEnergy(int i, int j, double distance, double radius1, double radius2) const;

private:
    double screen(double distance) const;
    const EnergyTerms::Born& born;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_BORNFORMULA_H_*/
