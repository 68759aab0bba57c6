#ifndef OPENMM_CHAINTREE_BORNFORMULA_H_
#define OPENMM_CHAINTREE_BORNFORMULA_H_

#include "openmmchaintree/internal/EnergyTerms.h"

namespace ChainTreePlugin {

/**
 * What ctBorn computes, one particle or pair at a time in double: to compare a Force with what it was translated to.
 */
class BornFormula {
public:
    explicit BornFormula(const EnergyTerms::Born& born) : born(born)
    {
    }
    /**
     * Get what particle j adds to the Born sum of particle i at a distance.
     */
    double computePairSum(int i, int j, double distance) const;
    double computeRadius(int i, double sum) const;
    /**
     * Get the energy of a particle that has this Born radius, that of its surface among it.
     */
    double computeSelfEnergy(int i, double radius) const;
    double computePairEnergy(int i, int j, double distance, double radius1, double radius2) const;

private:
    double screen(double distance) const;
    const EnergyTerms::Born& born;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_BORNFORMULA_H_*/
