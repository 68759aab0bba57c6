#ifndef OPENMM_CHAINTREE_ENERGYPLAN_H_
#define OPENMM_CHAINTREE_ENERGYPLAN_H_

#include "openmm/Force.h"
#include "openmm/internal/ContextImpl.h"
#include "openmmchaintree/internal/CoreSpheres.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace ChainTreePlugin {

class SceneEnergy;

/**
 * Who evaluates the energy of each Force of a Context, and why.
 *
 * A plan is made with the Context. Like OpenMM, it uses the force groups of that time, and copies of the Forces of that
 * time or of the last copyForces(). translate() turns these copies into terms; setChangeableTerms() says which of them
 * moves can change.
 */
class OPENMM_EXPORT_CHAINTREE EnergyPlan {
public:
    enum Kind {
        /** It has no part in U. */
        None,
        /** The scene evaluates it once, since no move can change it. */
        Constant,
        /** The scene evaluates its change in each trial. */
        Native,
        /** OpenMM evaluates it. */
        Foreign
    };
    class Entry {
    public:
        std::string name;
        /** Its force groups, as a bit mask: one, or two if its reciprocal space has another group. */
        int groups;
        /** The group of its reciprocal space, as a bit mask; 0 if it has none. */
        int reciprocalGroup;
        Kind kind;
        /** A clause that says why. NativeEnergy::describePlan() also says how often it is evaluated. */
        std::string reason;
    };
    explicit EnergyPlan(const OpenMM::ContextImpl& context);
    /**
     * Set the parameters of the stand-in for the next translation.
     */
    void setStandIn(const EnergyTerms::StandIn& choice)
    {
        standIn = choice;
    }
    /**
     * Copy the Forces again: the parameters of some Force were copied to the Context.
     */
    void copyForces();
    typedef TorsionMonteCarloIntegrator::StericMode StericMode;
    /**
     * Get the meaning of a steric mode for these force groups: Automatic becomes Off or Hard.
     */
    StericMode resolve(StericMode mode, int groups) const;
    /**
     * Make the plan for the present values of the Context's parameters. Until setChangeableTerms() is called, nothing
     * counts as constant.
     *
     * @param groups       the force groups that have a part in U, as a bit mask
     * @param allowNative  whether anything but OpenMM may evaluate a Force
     * @param mode         the part that the StericExclusionForce has in U
     */
    void translate(int groups, bool allowNative, StericMode mode);
    /**
     * Get the spheres that test trials with the steric mode Off; none if every overlap may have a low energy.
     *
     * @param groups  the force groups that have a part in U, as a bit mask
     * @param energy  exceeded by every pair whose spheres overlap, in kJ/mol
     */
    CoreSpheres findCoreSpheres(int groups, double energy) const;
    /**
     * Get the terms of all native and constant Forces, for SceneEnergy::setTerms().
     */
    const EnergyTerms& getTerms() const
    {
        return terms;
    }
    /**
     * Take notice of the result of SceneEnergy::countChangeableTerms().
     *
     * @param counts         for each set of terms, how many of them some move could change
     * @param somethingMoves whether moves can change anything
     */
    void setChangeableTerms(const std::vector<int>& counts, bool somethingMoves);
    /**
     * Get the decision about each Force, by its index in the System.
     */
    const std::vector<Entry>& getEntries() const
    {
        return entries;
    }
    /**
     * Get the native Force whose reciprocal space OpenMM evaluates, or -1 if there is none.
     */
    int findEwaldForce() const;
    /**
     * Get whether trials use a stand-in for a Force, and whether its energy is one of values.
     */
    bool hasStandIn(int index) const;
    bool isOfValues(int index) const;
    /**
     * Get the force groups that have a Force of this kind, as a bit mask. A group may have Forces of several kinds.
     */
    int getGroups(Kind kind) const;
    /**
     * Get the indices of the native and constant Forces that the scene evaluates.
     */
    std::set<int> getTranslatedForces() const;
    /**
     * Get the force groups of U with native or constant Forces only, whose energies in OpenMM and in the scene are
     * equal.
     */
    int getWhollyNativeGroups() const;
    /**
     * Sum results of getEnergies(), computeWhole() and computeValues() of SceneEnergy by Force. Returns the energy of
     * each Force by its index in the System, 0 for a Force that the scene does not evaluate.
     */
    std::vector<double> sumByForce(double nonbonded, double born, const std::vector<double>& pairSets,
                                   const std::vector<double>& termSets, const std::vector<double>& valueEnergies) const;
    /**
     * Compute the same from a scene whose energy has these terms, after SceneEnergy::update().
     */
    std::vector<double> computeByForce(SceneEnergy& energy) const;

    /**
     * Get a Force of the System; NULL if it has been removed.
     */
    const OpenMM::Force* findForce(int index) const;
    /**
     * Get the copy of a Force that is native or constant.
     */
    const OpenMM::Force& getCopy(int index) const
    {
        return *copies[index];
    }

private:
    std::string describePairs(int index) const;
    void decide(int index, int groupsOfU, bool allowNative);
    std::string describeStericPart(StericMode mode, int groups) const;
    int findReplacement(int groups) const;
    const OpenMM::ContextImpl& context;
    /** Whether the StericExclusionForce was periodic when the plan was made, as the scene is. */
    bool isPeriodic;
    /** The Forces when the plan was made. Some may have been removed since. */
    std::vector<const OpenMM::Force*> forces;
    /** The copies of Forces of native kinds, and the class names of all others. */
    std::vector<std::unique_ptr<OpenMM::Force>> copies;
    std::vector<std::string> classNames;
    /** The steric force, and Forces without an energy, which act on velocities or the box alone. */
    std::vector<bool> isSteric, hasNoEnergy;
    /** Whether a Force has an energy of pairs that holds all particles with a radius. */
    std::vector<bool> replacesSpheres;
    std::vector<Entry> entries;
    EnergyTerms terms;
    EnergyTerms::StandIn standIn;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ENERGYPLAN_H_*/
