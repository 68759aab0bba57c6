#ifndef OPENMM_CHAINTREE_SAMPLINGSUPPORT_H_
#define OPENMM_CHAINTREE_SAMPLINGSUPPORT_H_

/**
 * Common code of the tests of TorsionMonteCarloIntegrator: counts of moves, and a force with a given energy.
 */

#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/ForceImpl.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <functional>
#include <map>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** The energy of thermal motion at 300 K, in kJ/mol. */
const double THERMAL = 0.00831446261815324 * 300;

class Statistics {
public:
    Statistics(const TorsionMonteCarloIntegrator& integrator, int move)
    {
        integrator.getMoveStatistics(move, attempted, clashed, rejectedByEnergy, accepted);
        ASSERT_EQUAL(attempted, clashed + rejectedByEnergy + accepted);
    }
    long long attempted, clashed, rejectedByEnergy, accepted;
};

/**
 * A force that says what its energy is.
 */
class Probe : public Force {
public:
    bool usesPeriodicBoundaryConditions() const
    {
        return false;
    }
    /** Called for each evaluation with the Context's positions. */
    function<double(const vector<Vec3>&)> energy;

protected:
    ForceImpl* createImpl() const;
};

class ProbeImpl : public ForceImpl {
public:
    explicit ProbeImpl(const Probe& owner) : owner(owner)
    {
    }
    void initialize(ContextImpl&)
    {
    }
    const Probe& getOwner() const
    {
        return owner;
    }
    void updateContextState(ContextImpl&, bool&)
    {
    }
    double calcForcesAndEnergy(ContextImpl& context, bool, bool, int groups)
    {
        if ((groups & (1 << owner.getForceGroup())) == 0)
            return 0;
        vector<Vec3> positions;
        context.getPositions(positions);
        return owner.energy(positions);
    }
    map<string, double> getDefaultParameters()
    {
        return {};
    }
    vector<string> getKernelNames()
    {
        return {};
    }

private:
    const Probe& owner;
};

inline ForceImpl* Probe::createImpl() const
{
    return new ProbeImpl(*this);
}

#endif /*OPENMM_CHAINTREE_SAMPLINGSUPPORT_H_*/
