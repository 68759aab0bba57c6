#ifndef OPENMM_CHAINTREE_FOREIGNFORCES_H_
#define OPENMM_CHAINTREE_FOREIGNFORCES_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/ForceImpl.h"
#include "openmmchaintree/internal/EnergyPlan.h"
#include "openmmchaintree/internal/ForeignCopies.h"
#include "openmmchaintree/internal/ReciprocalSpace.h"
#include "openmmchaintree/internal/TrialSession.h"
#include <map>
#include <memory>
#include <vector>

namespace ChainTreePlugin {

/**
 * Lets OpenMM evaluate the foreign Forces of a Context, without the others where possible, and the reciprocal space of
 * a native NonbondedForce.
 *
 * On the Reference and CPU platforms a ForceImpl evaluates its Force when it is asked to, so the Context is asked for
 * its energy while it has the ForceImpls of foreign Forces only. These are the originals, with the parameters of
 * updateParametersInContext() and any memory that they have.
 *
 * Other platforms evaluate force groups as a whole. Foreign Forces in groups without native ones are then alone, too.
 * Forces that share a group with a native one are copied (ForeignCopies). If one of these cannot be copied, the energy
 * of all native Forces comes with that of the foreign ones.
 */
class ForeignForces {
public:
    explicit ForeignForces(OpenMM::ContextImpl& context);
    /**
     * Find out how the foreign Forces of a plan are evaluated.
     *
     * @param groups       the force groups that have a part in U, as a bit mask
     * @param allowNative  whether anything but OpenMM evaluates a Force. If not, all groups are evaluated at once
     * @param haveChanged  whether some Force was copied to the Context since the last call
     */
    void setForces(const EnergyPlan& plan, int groups, bool allowNative, bool haveChanged);
    /**
     * Forces that are evaluated together.
     */
    class Part {
    public:
        /** The indices of its Forces. */
        std::vector<int> forces;
        /** The force groups that are evaluated as a whole for it, as a bit mask; 0 if it is evaluated without them. */
        int groups;
        /** The index of the copy that is evaluated, or -1. */
        int copy;
        /** Whether it is the reciprocal space of a native Force. */
        bool isReciprocal = false;
    };
    const std::vector<Part>& getParts() const
    {
        return parts;
    }
    /**
     * Get whether native Forces are evaluated with the foreign ones. Then there is one part, with all native Forces.
     */
    bool areMixed() const
    {
        return mixed;
    }
    /**
     * Get the force groups that are evaluated as a whole, as a bit mask.
     */
    int getWholeGroups() const;
    /**
     * Compute the energy of some parts, or of all, at the Context's positions.
     */
    double computeEnergy(TrialSession& trials, const std::vector<int>& chosen) const;
    double computeEnergy(TrialSession& trials) const;
    /**
     * Compute what the reciprocal space of a native Force adds to some force groups, given as a bit mask.
     */
    double computeReciprocal(int groups) const;
    /**
     * Find the Forces whose energy is impossible, or all of them if only their sum is.
     */
    std::vector<int> findImpossible(TrialSession& trials) const;

private:
    void arrange(const EnergyPlan& plan, bool allowNative, bool haveChanged);
    void setReciprocal(const EnergyPlan& plan, bool haveChanged);
    void addToParts(int force, int itsGroups);
    bool makeCopies(const EnergyPlan& plan, const std::vector<int>& forces, bool haveChanged);
    double computeAlone(TrialSession& trials, const std::vector<int>& forces) const;
    OpenMM::ContextImpl& context;
    /** Whether a ForceImpl evaluates its Force when it is asked, and whether copies may do so if not. */
    const bool implsEvaluate, allowCopies;
    /** The ForceImpls by the indices of their Forces. */
    const std::vector<OpenMM::ForceImpl*> impls;
    /** The ForceImpls that the Context has while these Forces are evaluated alone. */
    mutable std::map<std::vector<int>, std::vector<OpenMM::ForceImpl*>> chosenImpls;
    int groups;
    bool mixed;
    std::vector<Part> parts;
    /** The force groups of each Force of the plan, as far as they have a part in U. */
    std::vector<int> forceGroups;
    /** The copies, and the indices of their Forces. */
    std::unique_ptr<ForeignCopies> copies;
    std::vector<int> copied;
    /** The reciprocal space of a native Force, if there is one, and its force group, as a bit mask. */
    std::unique_ptr<ReciprocalSpace> reciprocal;
    int reciprocalGroup;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FOREIGNFORCES_H_*/
