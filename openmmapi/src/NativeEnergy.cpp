#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/Hexadecimal.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef CalcStericExclusionForceKernel EnergyKernel;

/** After so many trials OpenMM's energy is compared again: an evaluation then costs nothing beside them. */
static const long long TRIALS_BETWEEN_CHECKS = 1000000;

/** The same where the last comparison did not say much, because the energy was huge. It grows with each of these. */
static const long long TRIALS_AFTER_VAGUE_CHECK = 1000;

static const int NUM_PARTS = 3;

/** The number of trials to an outer test if the user does not say it: a whole energy then takes little of the time. */
static const int USUAL_TRIALS_PER_OUTER_TEST = 400;

NativeEnergy::NativeEnergy(const TorsionMonteCarloIntegrator& integrator, StericExclusionForceImpl& force,
                           ContextImpl& context) :
    integrator(integrator),
    force(force), context(context), kernel(force.getKernel()), plan(context),
    check(context, plan,
          [&force, &context] {
              return force.createKernel(context);
          }),
    choice(getChoice()), forcesWereChanged(false), parametersWereChanged(true), energyIsOld(true),
    termsCanChange(false), pairsCanChange(false), valuesCanChange(false), foreignGroups(0),
    foreignGroupsAreShared(false), trialsToCheck(0), checkInterval(TRIALS_AFTER_VAGUE_CHECK), numComputed(0),
    computedChange(0), nearChange(0), standInCutoff(0), standInIsSet(false), whole({false, 0, 0}),
    keptWhole({false, 0, 0}), values({false, {}}), keptValues({false, {}})
{
    // The kernel makes another scene for terms that need more particles, so it learns of them before it has made one.

    updatePlan();
}

NativeEnergy::Choice NativeEnergy::getChoice() const
{
    EnergyTerms::StandIn standIn;
    integrator.getStandInCutoffs(standIn.bornCutoff, standIn.pairCutoff);
    standIn.gridWidth = integrator.getStandInGridWidth();
    return {integrator.getIntegrationForceGroups(), integrator.getNativeEnergies(),
            integrator.getStericMode() == TorsionMonteCarloIntegrator::Soft, standIn};
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
        setKernelTerms();
}

void NativeEnergy::setKernelTerms()
{
    standInIsSet = whole.isCurrent = values.isCurrent = false;
    force.setEnergyTerms(plan.getTerms(), this);
}

void NativeEnergy::translate()
{
    plan.setStandIn(choice.standIn);
    plan.translate(choice.groups, choice.native, choice.soft);
    trialsToCheck = 0;
    checkInterval = TRIALS_AFTER_VAGUE_CHECK;
    setKernelTerms();
    const LinkStructure& structure = force.getLinkStructure();
    auto& molecules = structure.getMolecules();
    const bool somethingMoves = structure.hasJoints() ||
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
    valuesCanChange = !plan.getTerms().valueEnergies.empty() && somethingMoves;

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

bool NativeEnergy::isPossible(double energy)
{
    return energy > -numeric_limits<double>::infinity();
}

/**
 * Throw an exception about an energy that no state can have. The Forces that have it come after a colon, if any.
 */
[[noreturn]] static void fail(const vector<string>& forces)
{
    string message = "TorsionMonteCarloIntegrator: the energy of the integration force groups is not a number";
    for (size_t i = 0; i < forces.size(); i++)
        message += (i > 0 ? "; " : forces.size() > 1 ? ": that of one of " : ": that of ") + forces[i];
    throw OpenMMException(message);
}

static string describe(const EnergyPlan& plan, size_t force)
{
    return "force " + to_string(force) + ", " + plan.getEntries()[force].name;
}

/**
 * Throw an exception if a native Force has an energy that no state can have.
 */
void NativeEnergy::checkNumbers(const vector<double>& energies) const
{
    for (size_t i = 0; i < energies.size(); i++)
        if (!isPossible(energies[i]))
            fail({describe(plan, i)});
}

void NativeEnergy::refuseState(TrialSession& trials) const
{
    int failing = 0;
    for (int group = 0; group < numeric_limits<unsigned int>::digits; group++) {
        const int mask = foreignGroups & (int)(1u << group);
        if (mask != 0 && !isPossible(trials.computeOtherEnergyOfState(mask)))
            failing |= mask;
    }
    if (failing == 0)
        failing = foreignGroups; // infinite energies of different signs
    vector<string> forces;
    for (size_t i = 0; i < plan.getEntries().size(); i++)
        if (plan.getEntries()[i].kind == EnergyPlan::Foreign && (plan.getEntries()[i].groups & failing) != 0)
            forces.push_back(describe(plan, i));
    fail(forces);
}

/**
 * Bring the kernel's energy up to date and get what it holds.
 */
const NativeEnergy::HeldEnergy& NativeEnergy::updateHeld()
{
    if (kernel.updateEnergy(energyIsOld))
        whole.isCurrent = values.isCurrent = false;
    energyIsOld = false;
    kernel.getEnergies(held.pairs, held.pairSets, held.termSets);
    return held;
}

/**
 * Bring up to date what a stand-in stands for. This comes after updateHeld(), which finds out whether it is.
 */
const NativeEnergy::WholeEnergy& NativeEnergy::updateWhole()
{
    if (!whole.isCurrent)
        kernel.computeWholeEnergy(whole.nonbonded, whole.born);
    whole.isCurrent = true;
    return whole;
}

/**
 * Bring the energies of values up to date. This comes after updateHeld(), too, if it is not within a trial.
 */
const vector<double>& NativeEnergy::updateValues()
{
    if (plan.getTerms().valueEnergies.empty())
        values.energies.clear();
    else if (!values.isCurrent)
        kernel.computeValueEnergies(false, values.energies);
    values.isCurrent = true;
    return values.energies;
}

/**
 * Bring the kernel's energy up to date and get that of each Force.
 */
vector<double> NativeEnergy::updateEnergies()
{
    updateHeld();
    updateValues();
    if (plan.getTerms().born.empty())
        return plan.sumByForce(held.pairs, 0, held.pairSets, held.termSets, values.energies);
    updateWhole();
    return plan.sumByForce(whole.nonbonded, whole.born, held.pairSets, held.termSets, values.energies);
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

    if (!hasTerms() || !(termsCanChange || pairsCanChange || valuesCanChange || trialsToCheck <= 0))
        return;
    updateStandIn();
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
    if (part == EnergyKernel::NearPairsPart)
        nearChange = change;
    computedChange += change;
    return change;
}

/**
 * Add up energies of which one may be infinite.
 */
static double sumOf(const vector<double>& energies)
{
    double sum = 0;
    for (double energy : energies)
        sum += energy;
    return sum;
}

double NativeEnergy::computeValuesChange()
{
    if (!termsCanChange && !pairsCanChange)
        trialsToCheck--;
    const double before = sumOf(updateValues());
    kernel.computeValueEnergies(true, proposedValues);
    const double after = sumOf(proposedValues);
    if (!isPossible(after))
        return numeric_limits<double>::quiet_NaN();
    const double change = after == before ? 0 : after - before;
    computedChange += change;
    return change;
}

void NativeEnergy::endTrial()
{
    numComputed = 0;
    computedChange = 0;
}

// ---- What trials see ----

double NativeEnergy::getNearCorrection()
{
    if (!hasStandIn())
        return 0;
    const double changeBack = kernel.getNearChangeBack();
    if (changeBack == -nearChange)
        return 0; // also if both are infinite
    if (std::isnan(changeBack))
        return changeBack;
    return max(0.0, changeBack) - max(0.0, -nearChange);
}

int NativeEnergy::getTrialsPerOuterTest() const
{
    // Foreign Forces that are asked at each trial bring the whole energy of all native ones if they share a group.

    const int trials = integrator.getTrialsPerOuterTest();
    const bool foreignIsLeft = trials > 0 && foreignGroups != 0;
    const bool standInIsLeft = hasStandIn() && (trials > 0 || !foreignGroupsAreShared);
    const bool valuesAreLeft = trials > 0 && valuesCanChange;
    if (!foreignIsLeft && !standInIsLeft && !valuesAreLeft)
        return 0;
    return trials > 0 ? trials : USUAL_TRIALS_PER_OUTER_TEST;
}

double NativeEnergy::computeDifference(TrialSession& trials)
{
    const bool foreignIsLeft = leavesForeignToOuterTest() && foreignGroups != 0;
    double energy = foreignIsLeft ? trials.computeOtherEnergyOfState(foreignGroups) : 0;
    const bool valuesAreLeft = valuesCanChange && !decidesByValues();
    if (valuesAreLeft && !termsCanChange && !pairsCanChange)
        trialsToCheck -= getTrialsPerOuterTest();
    if (!foreignGroupsAreShared && !hasStandIn() && !valuesAreLeft)
        return energy;
    updateHeld();
    if (!foreignGroupsAreShared && hasStandIn())
        energy += updateWhole().nonbonded + whole.born;
    if (!foreignGroupsAreShared && valuesAreLeft)
        energy += sumOf(updateValues());
    if (energy == numeric_limits<double>::infinity())
        return energy;
    return energy - (foreignGroupsAreShared ? getInnerEnergy() : hasStandIn() ? held.pairs : 0);
}

double NativeEnergy::getInnerEnergy()
{
    if (!termsCanChange && !pairsCanChange && !decidesByValues())
        return 0;
    updateHeld();
    double energy = 0;
    vector<double> ofValues(plan.getTerms().valueEnergies.size());
    if (decidesByValues())
        ofValues = updateValues();
    const vector<double> energies = plan.sumByForce(held.pairs, 0, held.pairSets, held.termSets, ofValues);
    for (size_t i = 0; i < energies.size(); i++)
        if (plan.getEntries()[i].kind == EnergyPlan::Native)
            energy += energies[i];
    return energy;
}

/**
 * See to it that the kernel has the numbers of the stand-in. The first series of trials makes them.
 */
void NativeEnergy::updateStandIn()
{
    if (!hasStandIn() || standInIsSet)
        return;
    vector<double> present;
    kernel.getStandIn(present);
    if (present.size() == standIn.size() && standInCutoff == choice.standIn.bornCutoff)
        kernel.setStandIn(standIn);
    else
        computeStandIn();
    standInIsSet = true;
}

/**
 * Make the numbers of the stand-in those of the present state.
 */
void NativeEnergy::computeStandIn()
{
    // The kernel looks at new positions here, so that updateHeld() will not find any.

    kernel.renewStandIn();
    whole.isCurrent = values.isCurrent = false;
    kernel.getStandIn(standIn);
    standInCutoff = choice.standIn.bornCutoff;
}

void NativeEnergy::renewStandIn()
{
    updatePlan();
    if (!hasStandIn())
        return;
    computeStandIn();
    standInIsSet = true;
}

void NativeEnergy::setStandIn(const vector<double>& numbers)
{
    standIn = numbers;
    standInCutoff = getChoice().standIn.bornCutoff;
    standInIsSet = false;
    energyIsOld = true;
}

void NativeEnergy::writeStandIn(SerializationNode& node) const
{
    stringstream stream;
    CheckpointWriter(stream).write(standIn);
    node.setStringProperty("data", toHexadecimal(stream.str()));
}

vector<double> NativeEnergy::readStandIn(const SerializationNode& node)
{
    string data;
    if (!fromHexadecimal(node.getStringProperty("data"), data))
        throw OpenMMException("TorsionMonteCarloIntegrator: the State is damaged");
    stringstream stream(data);
    return CheckpointReader(stream).readVector<double>();
}

string NativeEnergyStage::getName() const
{
    return part == EnergyKernel::BondedPart      ? "bonded terms"
           : part == EnergyKernel::NearPairsPart ? "near pairs"
                                                 : "other pairs";
}
