#ifndef OPENMM_CHAINTREE_RECIPROCALSPACE_H_
#define OPENMM_CHAINTREE_RECIPROCALSPACE_H_

#include "openmm/Context.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/NonbondedForce.h"
#include "openmm/System.h"
#include "openmm/VerletIntegrator.h"
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * The energy of a NonbondedForce in the reciprocal space of Ewald summation or PME, which OpenMM evaluates in an inner
 * Context that has nothing but its charges. It takes alpha and the grid from the Force in the outer Context.
 *
 * The CPU platform evaluates PME for a Context of the Reference platform, too, if it uses the same grid: it is much
 * faster, and its single precision changes the energy by a millionth. Other Contexts are linked to the outer one. On
 * the CPU platform, equal positions always have the same energy, to the last bit.
 */
class ReciprocalSpace {
public:
    /**
     * @param context  the Context that is sampled
     * @param force    a NonbondedForce of it, or a copy, with Ewald summation or PME
     * @param charges  the charges of all particles
     */
    ReciprocalSpace(OpenMM::ContextImpl& context, const OpenMM::NonbondedForce& force,
                    const std::vector<double>& charges);
    const std::vector<double>& getCharges() const
    {
        return charges;
    }
    /**
     * Compute the energy at the positions of the other Context.
     */
    double computeEnergy();

private:
    void createInner();
    OpenMM::Integrator& createIntegrator();
    bool createOnCPU(const std::string& threads);
    double evaluate();
    OpenMM::ContextImpl& outer;
    const std::vector<double> charges;
    OpenMM::System system;
    /** The Force of the inner Context, which its System owns. */
    OpenMM::NonbondedForce* copy;
    /** Made when they are first needed. */
    std::unique_ptr<OpenMM::VerletIntegrator> integrator;
    std::unique_ptr<OpenMM::Context> inner;
    std::vector<OpenMM::Vec3> positions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_RECIPROCALSPACE_H_*/
