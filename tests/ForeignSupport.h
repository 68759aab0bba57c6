#ifndef OPENMM_CHAINTREE_FOREIGNSUPPORT_H_
#define OPENMM_CHAINTREE_FOREIGNSUPPORT_H_

/**
 * Common code of the tests of foreign Forces: counting OpenMM's evaluations, and evaluating foreign Forces as on
 * platforms that evaluate only groups of Forces.
 */

#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/ForceImpl.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * Lets Contexts that are made while it lives evaluate foreign Forces by groups, or by copies where that is possible.
 */
class WholeGroups {
public:
    explicit WholeGroups(const char* setting = "groups")
    {
        setenv("CHAINTREE_FOREIGN", setting, 1);
    }
    ~WholeGroups()
    {
        unsetenv("CHAINTREE_FOREIGN");
    }
};

/**
 * Does what another ForceImpl does, and counts how often it evaluates its Force.
 */
class CountingImpl : public OpenMM::ForceImpl {
public:
    CountingImpl(OpenMM::ForceImpl* counted, int group, int& count) : counted(counted), count(count)
    {
        forceGroup = group;
    }
    void initialize(OpenMM::ContextImpl& context)
    {
        counted->initialize(context);
    }
    const OpenMM::Force& getOwner() const
    {
        return counted->getOwner();
    }
    void updateContextState(OpenMM::ContextImpl& context, bool& forcesInvalid)
    {
        counted->updateContextState(context, forcesInvalid);
    }
    double calcForcesAndEnergy(OpenMM::ContextImpl& context, bool includeForces, bool includeEnergy, int groups)
    {
        count += groups >> forceGroup & 1;
        return counted->calcForcesAndEnergy(context, includeForces, includeEnergy, groups);
    }
    std::map<std::string, double> getDefaultParameters()
    {
        return counted->getDefaultParameters();
    }
    std::vector<std::string> getKernelNames()
    {
        return counted->getKernelNames();
    }

private:
    std::unique_ptr<OpenMM::ForceImpl> counted;
    int& count;
};

/**
 * A Force of no energy that comes last in a System, and has the evaluations of all others counted from the beginning of
 * a Context. An integrator is bound after that.
 */
class EvaluationCounter : public OpenMM::Force {
public:
    bool usesPeriodicBoundaryConditions() const
    {
        return false;
    }
    /** The number of evaluations, by the index of the Force in the System. */
    mutable std::vector<int> counts;

protected:
    OpenMM::ForceImpl* createImpl() const;

private:
    class Impl;
};

class EvaluationCounter::Impl : public OpenMM::ForceImpl {
public:
    explicit Impl(const EvaluationCounter& owner) : owner(owner)
    {
    }
    void initialize(OpenMM::ContextImpl& context)
    {
        std::vector<OpenMM::ForceImpl*>& impls = context.getForceImpls();
        owner.counts.assign(impls.size(), 0);
        for (size_t i = 0; i < impls.size(); i++)
            if (impls[i] != this && dynamic_cast<StericExclusionForceImpl*>(impls[i]) == NULL)
                impls[i] = new CountingImpl(impls[i], context.getSystem().getForce(i).getForceGroup(), owner.counts[i]);
    }
    const EvaluationCounter& getOwner() const
    {
        return owner;
    }
    double calcForcesAndEnergy(OpenMM::ContextImpl&, bool, bool, int)
    {
        return 0;
    }
    std::map<std::string, double> getDefaultParameters()
    {
        return {};
    }
    std::vector<std::string> getKernelNames()
    {
        return {};
    }

private:
    const EvaluationCounter& owner;
};

inline OpenMM::ForceImpl* EvaluationCounter::createImpl() const
{
    return new Impl(*this);
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FOREIGNSUPPORT_H_*/
