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
 * A plan is made when the Context is. Like OpenMM, it goes by the force groups of that time, and by the Forces as they
 * were then or at the last copyForces(), whatever becomes of them. translate() turns these copies into terms;
 * setChangeableTerms() tells which of them moves can change.
 */
class OPENMM_EXPORT_CHAINTREE EnergyPlan {
public:
    enum Kind {
        /** It has no part in U. */
        None,
        /** The scene evaluates it once, since no move can change it. */
        Constant,
        /** The scene evaluates what a trial changes of it. */
        Native,
        /** OpenMM evaluates it. */
        Foreign
    };
    class Entry {
    public:
        std::string name;
        /** Its force groups, as a bit mask: one, or two if its reciprocal space has a group of its own. */
        int groups;
        Kind kind;
        /** A clause that says why. NativeEnergy::describePlan() also says how often it is evaluated. */
        std::string reason;
    };
    explicit EnergyPlan(const OpenMM::ContextImpl& context);
    /**
     * Set how a stand-in is made when the Forces are translated next, if they need one.
     */
    void setStandIn(const EnergyTerms::StandIn& choice)
    {
        standIn = choice;
    }
    /**
     * Take notice that the parameters of some Force were copied to the Context.
     */
    void copyForces();
    typedef TorsionMonteCarloIntegrator::StericMode StericMode;
    /**
     * Get what a steric mode means where these force groups have a part in U: Automatic becomes Off or Hard.
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
     * Get the spheres by which trials are tested with the steric mode Off; none if the Forces give no reason to refuse
     * a trial before its energy is known.
     *
     * @param groups  the force groups that have a part in U, as a bit mask
     * @param energy  which a pair exceeds if its spheres overlap, in kJ/mol
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
     * Take notice of what SceneEnergy::countChangeableTerms() says.
     *
     * @param counts         for each set of terms, how many of them some move could change
     * @param somethingMoves whether there is anything that a move could change
     */
    void setChangeableTerms(const std::vector<int>& counts, bool somethingMoves);
    /**
     * Get what was decided about each Force, by its index in the System.
     */
    const std::vector<Entry>& getEntries() const
    {
        return entries;
    }
    /**
     * Get whether trials see a stand-in for a Force, and whether its energy is one of values.
     */
    bool hasStandIn(int index) const;
    bool isOfValues(int index) const;
    /**
     * Get the force groups that have a Force of this kind, as a bit mask. A group may be among those of several kinds.
     */
    int getGroups(Kind kind) const;
    /**
     * Get the indices of the native and constant Forces that the scene evaluates.
     */
    std::set<int> getTranslatedForces() const;
    /**
     * Get the force groups of U without foreign Forces, but with native or constant ones: there, OpenMM's energy and
     * that of the scene are the same.
     */
    int getWhollyNativeGroups() const;
    /**
     * Sum up energies as getEnergies(), computeWhole() and computeValues() of SceneEnergy give them: the energy of each
     * Force by its index in the System, 0 for a Force that is not evaluated there.
     */
    std::vector<double> sumByForce(double nonbonded, double born, const std::vector<double>& pairSets,
                                   const std::vector<double>& termSets, const std::vector<double>& valueEnergies) const;
    /**
     * Get the same of a scene whose energy has these terms, after SceneEnergy::update().
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
    /** The Forces there were when the plan was made. Some may have been removed since. */
    std::vector<const OpenMM::Force*> forces;
    /** The copies of those of native kinds, and the names of all others' classes. */
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
