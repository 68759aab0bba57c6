#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <algorithm>
#include <limits>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef CalcStericExclusionForceKernel EnergyKernel;

/** After so many trials OpenMM's energy is compared again: an evaluation then costs nothing beside them. */
static const long long TRIALS_BETWEEN_CHECKS = 1000000;

/** The same where the last comparison did not say much, because the energy was huge. It grows with each of these. */
static const long long TRIALS_AFTER_VAGUE_CHECK = 1000;

static const int NUM_PARTS = 3;

NativeEnergy::NativeEnergy(const TorsionMonteCarloIntegrator& integrator, StericExclusionForceImpl& force,
                           ContextImpl& context) :
    integrator(integrator),
    force(force), context(context), kernel(force.getKernel()), plan(context), check(context, plan), choice(getChoice()),
    forcesWereChanged(true), parametersWereChanged(false), energyIsOld(true), termsCanChange(false),
    pairsCanChange(false), foreignGroups(0), foreignGroupsAreShared(false), trialsToCheck(0),
    checkInterval(TRIALS_AFTER_VAGUE_CHECK), numComputed(0), computedChange(0)
{
    // The kernel makes another scene for terms that need more particles, so it learns of them before it has made one.

    updatePlan();
}

NativeEnergy::Choice NativeEnergy::getChoice() const
{
    return {integrator.getIntegrationForceGroups(), integrator.getNativeEnergies(),
            integrator.getStericMode() == TorsionMonteCarloIntegrator::Soft};
}

// ---- The plan ----

/**
 * Translate the Forces anew if anything was changed, and see to it that the kernel has their terms: another integrator
 * of a CompoundIntegrator may have given it its own.
 */
void NativeEnergy::updatePlan()
{
    const Choice present = getChoice();
    if (forcesWereChanged || parametersWereChanged || !(present == choice)) {
        choice = present;
        if (forcesWereChanged)
            plan.copyForces();
        translate();
        forcesWereChanged = parametersWereChanged = false;
    }
    else if (force.getOwnerOfEnergyTerms() != this)
        force.setEnergyTerms(plan.getTerms(), this);
}

void NativeEnergy::translate()
{
    plan.translate(choice.groups, choice.native, choice.soft);
    trialsToCheck = 0;
    checkInterval = TRIALS_AFTER_VAGUE_CHECK;
    force.setEnergyTerms(plan.getTerms(), this);
    const LinkStructure& structure = force.getLinkStructure();
    auto& molecules = structure.getMolecules();
    const bool somethingMoves = !structure.getTorsionLinks().empty() ||
                                any_of(molecules.begin(), molecules.end(), [](const LinkStructure::Molecule& molecule) {
                                    return !molecule.fixed;
                                });
    vector<int> counts;
    if (!plan.getTerms().termSets.empty())
        kernel.countChangeableTerms(counts);
    plan.setChangeableTerms(counts, somethingMoves);
    termsCanChange = any_of(counts.begin(), counts.end(), [](int count) {
        return count > 0;
    });
    pairsCanChange = !(plan.getTerms().nonbonded.empty() && plan.getTerms().pairSets.empty()) && somethingMoves;

    // Foreign Forces that share a group with native ones are evaluated with all native ones, whose change is known.

    foreignGroups = plan.getGroups(EnergyPlan::Foreign) & choice.groups;
    foreignGroupsAreShared = (foreignGroups & plan.getGroups(EnergyPlan::Native)) != 0;
    if (foreignGroupsAreShared)
        foreignGroups |= plan.getGroups(EnergyPlan::Native) & choice.groups;
}

const EnergyPlan& NativeEnergy::getPlan()
{
    updatePlan();
    return plan;
}

// ---- The state ----

/**
 * Throw an exception if a Force has an energy that no state can have: NaN, or minus infinity.
 */
void NativeEnergy::checkNumbers(const vector<double>& energies) const
{
    for (size_t i = 0; i < energies.size(); i++)
        if (!(energies[i] > -numeric_limits<double>::infinity()))
            throw OpenMMException("TorsionMonteCarloIntegrator: the energy of the integration force groups is not a "
                                  "number: that of force " +
                                  to_string(i) + ", " + plan.getEntries()[i].name);
}

/**
 * Bring the kernel's energy up to date and get that of each Force.
 */
vector<double> NativeEnergy::updateEnergies()
{
    double nonbonded, born = 0;
    vector<double> pairSets, termSets;
    kernel.updateEnergy(energyIsOld);
    energyIsOld = false;
    kernel.getEnergies(nonbonded, pairSets, termSets);
    if (!plan.getTerms().born.empty())
        kernel.computeWholeEnergy(nonbonded, born);
    return plan.sumByForce(nonbonded, born, pairSets, termSets);
}

void NativeEnergy::compareWithOpenMM(TrialSession& trials, const vector<double>& energies)
{
    vector<Vec3> positions;
    kernel.getPositions(positions);
    const bool saysMuch = check.check(positions, energies, [&](int groups) {
        return trials.computeOtherEnergy(groups);
    });
    checkInterval = saysMuch ? TRIALS_BETWEEN_CHECKS : min(2 * checkInterval, TRIALS_BETWEEN_CHECKS);
    trialsToCheck = checkInterval;
}

void NativeEnergy::begin(TrialSession& trials)
{
    endTrial();
    updatePlan();

    // What no move can change is looked at once.

    if (!hasTerms() || !(termsCanChange || pairsCanChange || trialsToCheck <= 0))
        return;
    const vector<double> energies = updateEnergies();
    checkNumbers(energies);
    if (trialsToCheck <= 0)
        compareWithOpenMM(trials, energies);
}

double NativeEnergy::computeEnergy(TrialSession& trials)
{
    updatePlan();
    double energy = foreignGroups == 0 ? 0 : trials.computeOtherEnergy(foreignGroups);
    if (!hasTerms())
        return energy;
    const vector<double> energies = updateEnergies();
    for (size_t i = 0; i < energies.size(); i++)
        if ((plan.getEntries()[i].groups & foreignGroups) == 0)
            energy += energies[i];
    return energy;
}

// ---- Trials ----

bool NativeEnergy::canChange(EnergyKernel::EnergyPart part) const
{
    return part == EnergyKernel::BondedPart ? termsCanChange : pairsCanChange;
}

double NativeEnergy::computeChange(EnergyKernel::EnergyPart part)
{
    // The kernel takes over what it has computed for an accepted trial only if it was asked for all parts.

    const int end = (part == EnergyKernel::BondedPart && !pairsCanChange) ? NUM_PARTS : part + 1;
    if (numComputed == 0)
        trialsToCheck--;
    double change = 0;
    for (; numComputed < end; numComputed++)
        change += kernel.getProposedEnergyChange((EnergyKernel::EnergyPart)numComputed);
    computedChange += change;
    return change;
}

void NativeEnergy::endTrial()
{
    numComputed = 0;
    computedChange = 0;
}

string NativeEnergyStage::getName() const
{
    return part == EnergyKernel::BondedPart      ? "bonded terms"
           : part == EnergyKernel::NearPairsPart ? "near pairs"
                                                 : "other pairs";
}
