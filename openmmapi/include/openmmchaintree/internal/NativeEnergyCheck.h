#ifndef OPENMM_CHAINTREE_NATIVEENERGYCHECK_H_
#define OPENMM_CHAINTREE_NATIVEENERGYCHECK_H_

#include "openmm/internal/ContextImpl.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/EnergyPlan.h"
#include "openmmchaintree/internal/Scene.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <functional>
#include <memory>
#include <vector>

namespace ChainTreePlugin {

/**
 * Compares energies of the Scene with OpenMM's own, Force by Force, so that an error in translation does not go
 * unnoticed. OpenMM evaluates copies of the native Forces in a Context of the Reference Platform. Of Ewald summation it
 * compares direct space.
 */
class OPENMM_EXPORT_CHAINTREE NativeEnergyCheck {
public:
    /**
     * Computes the energy of force groups in the main Context, without the StericExclusionForce and without reciprocal
     * spaces. The Context must have the positions that are compared.
     */
    typedef std::function<double(int groups)> GroupEnergy;
    /**
     * Makes another scene of the same structure, without a state.
     */
    typedef std::function<std::unique_ptr<Scene>()> SceneMaker;
    NativeEnergyCheck(OpenMM::ContextImpl& context, const EnergyPlan& plan, const SceneMaker& makeScene);
    /**
     * Throw an exception if the energy of a Force differs from OpenMM's by more than the accuracy of both.
     *
     * @param positions     the positions of the scene's state
     * @param energies      the energy of each Force in it, from EnergyPlan::sumByForce()
     * @param groupEnergy   the main Context's energy, for groups that are wholly native; empty if it is not compared
     * @return whether the check is meaningful. At huge forces, as between overlapping particles, rounding can hide an
     * error in translation
     */
    bool check(const std::vector<OpenMM::Vec3>& positions, const std::vector<double>& energies,
               const GroupEnergy& groupEnergy) const;

private:
    class Result;
    class Copies;
    std::vector<Result> evaluate(const std::vector<OpenMM::Vec3>& positions) const;
    std::vector<double> recompute(const std::vector<OpenMM::Vec3>& positions) const;
    const Result* findDisagreement(const std::vector<Result>& results, const std::vector<double>& energies,
                                   const std::vector<double>& allowances) const;
    std::vector<double> findAllowances(const std::vector<OpenMM::Vec3>& positions,
                                       const std::vector<Result>& results) const;
    void checkForces(const std::vector<OpenMM::Vec3>& positions, const std::vector<Result>& results,
                     const std::vector<double>& energies) const;
    bool sayMuch(const std::vector<Result>& results) const;
    void checkGroups(const std::vector<Result>& results, const GroupEnergy& groupEnergy) const;
    OpenMM::ContextImpl& context;
    const EnergyPlan& plan;
    const SceneMaker makeScene;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_NATIVEENERGYCHECK_H_*/
