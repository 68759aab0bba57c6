#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmm/OpenMMException.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
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

/** OpenMM's energy is compared again after this number of trials, which take much longer than one evaluation. */
static const long long TRIALS_BETWEEN_CHECKS = 1000000;

/** The same after a comparison of huge energies, which proves little. It doubles each time. */
static const long long TRIALS_AFTER_VAGUE_CHECK = 1000;

/** Overlapping cores exceed this energy, in kT: such states are never sampled. */
static const double CORE_ENERGY = 60;

/**
 * The temperatures for which cores are made: this one, in Kelvin, times powers of 2. So a replica that exchanges
 * temperatures keeps its cores.
 */
static const double LOWEST_CORE_TEMPERATURE = 500;

/** The default number of trials per outer test: a whole energy then takes little of the time. */
static const int USUAL_TRIALS_PER_OUTER_TEST = 400;

/** This number of trials of atom moves counts as one trial here. In proteins of 582 to 2,489 atoms (GBn2), 85 to 95
 *  percent of the tests after 2,000 atom moves pass, and 83 percent of those after 400 trials of torsions. */
static const int ATOM_MOVES_PER_TRIAL = 5;

NativeEnergy::NativeEnergy(const TorsionMonteCarloIntegrator& integrator, StericExclusionForceImpl& force,
                           ContextImpl& context) :
    integrator(integrator),
    force(force), context(context), plan(context), check(context, plan,
                                                         [&force] {
                                                             return force.createScene();
                                                         }),
    choice(getChoice()), forcesWereChanged(false), parametersWereChanged(true), energyIsOld(true),
    termsCanChange(false), pairsCanChange(false), valuesCanChange(false), foreign(context), trialsToCheck(0),
    checkInterval(TRIALS_AFTER_VAGUE_CHECK), numComputed(0), computedChange(0), nearChange(0), standInCutoff(0),
    standInIsSet(false), whole({false, 0, 0}), savedWhole({false, 0, 0}), values({false, {}}), savedValues({false, {}})
{
    // Terms of more particles require another tree, so the scene gets the terms before it has a tree.

    updatePlan();
}

NativeEnergy::Choice NativeEnergy::getChoice() const
{
    EnergyTerms::StandIn standIn;
    integrator.getStandInCutoffs(standIn.bornCutoff, standIn.pairCutoff);
    standIn.gridWidth = integrator.getStandInGridWidth();
    double coreTemperature = LOWEST_CORE_TEMPERATURE;
    while (coreTemperature < integrator.getTemperature())
        coreTemperature *= 2;
    return {integrator.getIntegrationForceGroups(), integrator.getNativeEnergies(), integrator.getStericMode(),
            CORE_ENERGY * BOLTZ * coreTemperature, standIn};
}

SceneEnergy& NativeEnergy::getEnergy() const
{
    return force.getTrialScene().getEnergy();
}

// ---- The plan ----

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
        setTerms();
}

void NativeEnergy::setTerms()
{
    standInIsSet = whole.isCurrent = values.isCurrent = false;
    force.setTrialSpheres(cores);
    force.setEnergyTerms(plan.getTerms(), this);
}

void NativeEnergy::translate()
{
    plan.setStandIn(choice.standIn);
    plan.translate(choice.groups, choice.native, choice.stericMode);
    const bool isOff = (getStericMode() == TorsionMonteCarloIntegrator::Off);
    cores = isOff ? plan.findCoreSpheres(choice.groups, choice.coreEnergy) : CoreSpheres();
    trialsToCheck = 0;
    checkInterval = TRIALS_AFTER_VAGUE_CHECK;
    setTerms();
    const LinkStructure& structure = force.getLinkStructure();
    auto& molecules = structure.getMolecules();
    const bool somethingMoves = structure.hasJoints() ||
                                any_of(molecules.begin(), molecules.end(), [](const LinkStructure::Molecule& molecule) {
                                    return !molecule.fixed;
                                });
    vector<int> counts;
    if (!plan.getTerms().termSets.empty())
        getEnergy().countChangeableTerms(counts);
    plan.setChangeableTerms(counts, somethingMoves);
    termsCanChange = any_of(counts.begin(), counts.end(), [](int count) {
        return count > 0;
    });
    pairsCanChange = !(plan.getTerms().nonbonded.empty() && plan.getTerms().pairSets.empty()) && somethingMoves;
    valuesCanChange = !plan.getTerms().valueEnergies.empty() && somethingMoves;
    foreign.setForces(plan, choice.groups, choice.native, forcesWereChanged);
}

/**
 * Describe when an energy is evaluated, given the trials per outer test; 0 if it is not left to tests.
 */
static string describeTime(int trialsPerTest)
{
    return trialsPerTest == 0
               ? "in each trial"
               : "at each outer test, every " + (trialsPerTest == 1 ? "trial" : to_string(trialsPerTest) + " trials");
}

vector<EnergyPlan::Entry> NativeEnergy::describePlan()
{
    updatePlan();

    // Only a series of trials may change the schedule.

    const OuterSchedule present = schedule;
    beginSchedule();
    const int trials = min(getTrialsPerOuterTest(), integrator.getTrialsPerStep());
    vector<EnergyPlan::Entry> entries = plan.getEntries();
    for (size_t i = 0; i < entries.size(); i++) {
        EnergyPlan::Entry& entry = entries[i];
        if (plan.isOfValues(i) && entry.kind == EnergyPlan::Native)
            entry.reason = "openmm-chaintree evaluates all of it " + describeTime(decidesByValues() ? 0 : trials) +
                           ": " + entry.reason;
        else if (plan.hasStandIn(i) && entry.kind == EnergyPlan::Native && trials > 0)
            entry.reason = "openmm-chaintree evaluates it " + describeTime(trials) + "; " + entry.reason;
        const bool isEvaluated = entry.kind == EnergyPlan::Native || entry.kind == EnergyPlan::Constant;
        if (isEvaluated && (entry.groups & foreign.getWholeGroups()) != 0)
            entry.reason += "; OpenMM evaluates it, too, with the foreign Forces " + describeTime(trials);
    }
    for (size_t i = 0; i < foreign.getParts().size(); i++) {
        const ForeignForces::Part& part = foreign.getParts()[i];
        string how = describeTime(isLeftToTests(i) ? trials : 0);
        if (choosesForeign() && schedule.isMeasuring() && isLeftToTests(i))
            how += " while its spread is measured";
        if (part.copy != -1)
            how += ", by a copy";
        for (int force : part.forces) {
            string& reason = entries[force].reason;
            if (part.isReciprocal)
                reason += "; OpenMM evaluates its reciprocal space " + how;
            else
                reason =
                    (foreign.areMixed() ? "OpenMM evaluates it with all of its force group " : "OpenMM evaluates it ") +
                    how + ": " + reason;
        }
    }
    schedule = present;
    return entries;
}

// ---- Foreign Forces that outer tests decide ----

/**
 * Get whether measurements decide which foreign Forces outer tests evaluate.
 */
bool NativeEnergy::choosesForeign() const
{
    return integrator.getTrialsPerOuterTest() == 0 && integrator.getTemperature() > 0 && choice.native &&
           !foreign.getParts().empty();
}

bool NativeEnergy::isLeftToTests(int part) const
{
    return integrator.getTrialsPerOuterTest() > 0 || (choosesForeign() && schedule.isLeft(part));
}

/**
 * Get the parts that are left to outer tests, or the others.
 */
vector<int> NativeEnergy::selectForeign(bool leftToTests) const
{
    vector<int> parts;
    for (size_t part = 0; part < foreign.getParts().size(); part++)
        if (isLeftToTests(part) == leftToTests)
            parts.push_back(part);
    return parts;
}

void NativeEnergy::beginSchedule()
{
    if (!choosesForeign())
        return;
    vector<int> energies;
    for (const ForeignForces::Part& part : foreign.getParts())
        energies.push_back(part.forces[0]);
    schedule.begin(energies, min(USUAL_TRIALS_PER_OUTER_TEST, integrator.getTrialsPerStep()));
}

void NativeEnergy::takeNoticeOfTest(const Difference& before, const Difference& after)
{
    const double thermal = BOLTZ * integrator.getTemperature();
    if (thermal == 0)
        return;
    auto changeOf = [thermal](double first, double second) {
        return first == second ? 0 : (second - first) / thermal;
    };
    const double change = changeOf(before.whole, after.whole);
    if (!choosesForeign() || !schedule.isMeasuring()) {
        watch.add(change);
        return;
    }
    vector<double> changes;
    for (size_t i = 0; i < before.foreign.size(); i++)
        changes.push_back(changeOf(before.foreign[i], after.foreign[i]));
    schedule.add(changes, change);
}

// ---- The state ----

bool NativeEnergy::isPossible(double energy)
{
    return energy > -numeric_limits<double>::infinity();
}

/**
 * Throw an exception that names the Forces with an impossible energy, if known.
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
 * Throw an exception if a native Force has an impossible energy.
 */
void NativeEnergy::checkNumbers(const vector<double>& energies) const
{
    for (size_t i = 0; i < energies.size(); i++)
        if (!isPossible(energies[i]))
            fail({describe(plan, i)});
}

void NativeEnergy::refuseState(TrialSession& trials) const
{
    vector<string> forces;
    for (int force : foreign.findImpossible(trials))
        forces.push_back(describe(plan, force));
    fail(forces);
}

/**
 * Update the scene's energy and get it.
 */
const NativeEnergy::HeldEnergy& NativeEnergy::updateHeld()
{
    if (getEnergy().update(energyIsOld))
        whole.isCurrent = values.isCurrent = false;
    energyIsOld = false;
    getEnergy().getEnergies(held.pairs, held.pairSets, held.termSets);
    return held;
}

/**
 * Update the energies that a stand-in replaces. Call this after updateHeld(), which finds out if they are current.
 */
const NativeEnergy::WholeEnergy& NativeEnergy::updateWhole()
{
    if (!whole.isCurrent)
        getEnergy().computeWhole(whole.nonbonded, whole.born);
    whole.isCurrent = true;
    return whole;
}

/**
 * Update the energies of values. Outside of a trial, call this after updateHeld(), too.
 */
const vector<double>& NativeEnergy::updateValues()
{
    if (plan.getTerms().valueEnergies.empty())
        values.energies.clear();
    else if (!values.isCurrent)
        getEnergy().computeValues(false, values.energies);
    values.isCurrent = true;
    return values.energies;
}

/**
 * Update the scene's energy and get the energy of each Force.
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
    force.getTrialScene().getPositions(positions);
    const bool saysMuch = check.check(positions, energies, [&](int groups) {
        return trials.computeOtherEnergy(groups) - foreign.computeReciprocal(groups);
    });
    checkInterval = saysMuch ? TRIALS_BETWEEN_CHECKS : min(2 * checkInterval, TRIALS_BETWEEN_CHECKS);
    trialsToCheck = checkInterval;
}

void NativeEnergy::begin(TrialSession& trials)
{
    forgetTrial();
    beginSchedule();

    // Energies that no move can change are checked once.

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
    double energy = foreign.computeEnergy(trials);
    if (!hasTerms())
        return energy;
    const vector<double> energies = updateEnergies();
    for (size_t i = 0; i < energies.size(); i++)
        if ((plan.getEntries()[i].groups & foreign.getWholeGroups()) == 0)
            energy += energies[i];
    return energy;
}

// ---- Trials ----

bool NativeEnergy::canChange(ctEnergyPart part) const
{
    return part == ctTermsPart ? termsCanChange : pairsCanChange;
}

double NativeEnergy::computeEnergyChange(ctEnergyPart part)
{
    // The scene holds the energy of an accepted trial only if all parts were computed.

    const int end = (part == ctTermsPart && !pairsCanChange) ? CT_ENERGY_PARTS : part + 1;
    if (numComputed == 0)
        trialsToCheck--;
    double change = 0;
    for (; numComputed < end; numComputed++)
        change += getEnergy().computeEnergyChange((ctEnergyPart)numComputed);
    if (part == ctNearPairsPart)
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

double NativeEnergy::computeValueEnergyChange()
{
    if (!termsCanChange && !pairsCanChange)
        trialsToCheck--;
    const double before = sumOf(updateValues());
    getEnergy().computeValues(true, proposedValues);
    const double after = sumOf(proposedValues);
    if (!isPossible(after))
        return numeric_limits<double>::quiet_NaN();
    const double change = after == before ? 0 : after - before;
    computedChange += change;
    return change;
}

void NativeEnergy::forgetTrial()
{
    numComputed = 0;
    computedChange = 0;
}

// ---- The energy of trials, U1 ----

double NativeEnergy::getNearCorrection()
{
    if (!hasStandIn())
        return 0;
    const double changeBack = getEnergy().getNearChangeBack();
    if (changeBack == -nearChange)
        return 0; // also if both are infinite
    if (std::isnan(changeBack))
        return changeBack;
    return max(0.0, changeBack) - max(0.0, -nearChange);
}

/**
 * Get the number of trials to an outer test of the stand-in, unless the user sets it.
 */
int NativeEnergy::getUsualTrials() const
{
    const double share = integrator.getAtomMoveShare();
    return (int)lround(USUAL_TRIALS_PER_OUTER_TEST / (1 - share + share / ATOM_MOVES_PER_TRIAL));
}

int NativeEnergy::getTrialsPerOuterTest() const
{
    // Foreign Forces that are evaluated with native ones in each trial already give the whole native energy.

    const int trials = integrator.getTrialsPerOuterTest();
    const bool foreignIsLeft = !selectForeign(true).empty();
    const bool standInIsLeft = hasStandIn() && (trials > 0 || !foreign.areMixed());
    const bool valuesAreLeft = trials > 0 && valuesCanChange;
    if (!foreignIsLeft && !standInIsLeft && !valuesAreLeft)
        return 0;
    return trials > 0 ? trials : foreignIsLeft ? schedule.getTrialsPerTest() : getUsualTrials();
}

NativeEnergy::Difference NativeEnergy::computeDifference(TrialSession& trials)
{
    Difference difference = computeForeignDifference(trials);
    const bool valuesAreLeft = valuesCanChange && !decidesByValues();
    if (valuesAreLeft && !termsCanChange && !pairsCanChange)
        trialsToCheck -= getTrialsPerOuterTest();
    double& energy = difference.whole;
    const bool isMixed = foreign.areMixed();
    if (!isMixed && !hasStandIn() && !valuesAreLeft)
        return difference;
    updateHeld();
    if (!isMixed && hasStandIn())
        energy += updateWhole().nonbonded + whole.born;
    if (!isMixed && valuesAreLeft)
        energy += sumOf(updateValues());
    if (energy != numeric_limits<double>::infinity())
        energy -= isMixed ? getInnerEnergy() : hasStandIn() ? held.pairs : 0;
    if (isMixed && !difference.foreign.empty())
        difference.foreign = {energy};
    return difference;
}

/**
 * Compute the energy of the foreign Forces that are left to outer tests, and of each part while these are measured.
 */
NativeEnergy::Difference NativeEnergy::computeForeignDifference(TrialSession& trials)
{
    const vector<int> parts = selectForeign(true);
    if (parts.empty())
        return {0, {}};
    trials.showState();
    if (!choosesForeign() || !schedule.isMeasuring())
        return {foreign.computeEnergy(trials, parts), {}};
    Difference difference = {0, vector<double>(foreign.getParts().size(), 0)};
    for (int part : parts) {
        difference.foreign[part] = foreign.computeEnergy(trials, {part});
        difference.whole += difference.foreign[part];
    }
    return difference;
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
 * Give the scene the numbers of the stand-in. The first series of trials computes them.
 */
void NativeEnergy::updateStandIn()
{
    if (!hasStandIn() || standInIsSet)
        return;
    vector<double> present;
    getEnergy().getStandIn(present);
    if (present.size() == standIn.size() && standInCutoff == choice.standIn.bornCutoff)
        getEnergy().setStandIn(standIn);
    else
        computeStandIn();
    standInIsSet = true;
}

/**
 * Compute the numbers of the stand-in for the present state.
 */
void NativeEnergy::computeStandIn()
{
    // The scene's energy becomes current here, so updateHeld() would not reset these.

    getEnergy().renewStandIn();
    whole.isCurrent = values.isCurrent = false;
    getEnergy().getStandIn(standIn);
    standInCutoff = choice.standIn.bornCutoff;
}

void NativeEnergy::renewStandIn()
{
    schedule.restart();
    watch.restart();
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

bool NativeEnergy::isStandIn(const vector<double>& numbers)
{
    return all_of(numbers.begin(), numbers.end(), [](double number) {
        return abs(number) <= numeric_limits<float>::max();
    });
}

static string toText(const vector<double>& numbers)
{
    stringstream stream;
    CheckpointWriter(stream).write(numbers);
    return toHexadecimal(stream.str());
}

static vector<double> fromText(const string& text)
{
    string data;
    if (!fromHexadecimal(text, data))
        throw OpenMMException("TorsionMonteCarloIntegrator: the State is damaged");
    stringstream stream(data);
    return CheckpointReader(stream).readVector<double>();
}

void NativeEnergy::writeStandIn(SerializationNode& node) const
{
    node.setStringProperty("data", toText(standIn));
    if (!getSchedule().empty())
        node.setStringProperty("schedule", toText(getSchedule()));
}

vector<double> NativeEnergy::readStandIn(const SerializationNode& node)
{
    const vector<double> numbers = fromText(node.getStringProperty("data"));
    if (!isStandIn(numbers))
        throw OpenMMException(
            "TorsionMonteCarloIntegrator: the State is damaged: a number of its stand-in is not finite");
    return numbers;
}

vector<double> NativeEnergy::readSchedule(const SerializationNode& node)
{
    return node.hasProperty("schedule") ? fromText(node.getStringProperty("schedule")) : vector<double>();
}

string NativeEnergyStage::getName() const
{
    return part == ctTermsPart ? "bonded terms" : part == ctNearPairsPart ? "near pairs" : "other pairs";
}
