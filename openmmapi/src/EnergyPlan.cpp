#include "openmmchaintree/internal/EnergyPlan.h"
#include "openmm/AndersenThermostat.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/Force.h"
#include "openmm/NonbondedForce.h"
#include "openmm/System.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/SceneEnergy.h"
#include "openmmchaintree/internal/SystemChecks.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <algorithm>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static bool hasReciprocalSpace(const NonbondedForce& force)
{
    const NonbondedForce::NonbondedMethod method = force.getNonbondedMethod();
    return method != NonbondedForce::NoCutoff && method != NonbondedForce::CutoffNonPeriodic &&
           method != NonbondedForce::CutoffPeriodic;
}

/**
 * Get the force group in which the reciprocal space of a Force is evaluated, as a bit mask; 0 if it has none.
 */
static int findReciprocalGroup(const Force& force)
{
    const NonbondedForce* nonbonded = dynamic_cast<const NonbondedForce*>(&force);
    if (nonbonded == NULL || !hasReciprocalSpace(*nonbonded))
        return 0;
    const int group = nonbonded->getReciprocalSpaceForceGroup();
    return (int)(1u << (group >= 0 ? group : force.getForceGroup()));
}

static string plural(long long count, const string& noun)
{
    return to_string(count) + " " + noun + (count == 1 ? "" : "s");
}

/**
 * Get whether a Force has an energy of pairs that includes all particles with a radius in the StericExclusionForce.
 */
static bool holdsParticlesOf(const Force& force, const StericExclusionForce& steric)
{
    if (dynamic_cast<const NonbondedForce*>(&force) != NULL)
        return true;
    const CustomNonbondedForce* custom = dynamic_cast<const CustomNonbondedForce*>(&force);
    if (custom == NULL)
        return false;
    if (custom->getNumInteractionGroups() == 0)
        return true;
    set<int> held;
    for (int i = 0; i < custom->getNumInteractionGroups(); i++) {
        set<int> set1, set2;
        custom->getInteractionGroupParameters(i, set1, set2);
        held.insert(set1.begin(), set1.end());
        held.insert(set2.begin(), set2.end());
    }
    for (int i = 0; i < steric.getNumParticles(); i++) {
        double radius;
        StericExclusionForce::HydrogenBondRole role;
        steric.getParticleParameters(i, radius, role);
        if (radius > 0 && held.count(i) == 0)
            return false;
    }
    return true;
}

EnergyPlan::EnergyPlan(const ContextImpl& context) : context(context), isPeriodic(false)
{
    const System& system = context.getSystem();
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force& force = system.getForce(i);
        forces.push_back(&force);
        classNames.push_back(getClassName(force));
        isSteric.push_back(dynamic_cast<const StericExclusionForce*>(&force) != NULL);
        isPeriodic = isPeriodic || (isSteric.back() && force.usesPeriodicBoundaryConditions());
        hasNoEnergy.push_back(dynamic_cast<const CMMotionRemover*>(&force) != NULL ||
                              dynamic_cast<const AndersenThermostat*>(&force) != NULL || isBarostat(force));
        const int reciprocal = findReciprocalGroup(force);
        entries.push_back({force.getName(), (int)(1u << force.getForceGroup()) | reciprocal, reciprocal, None, ""});
    }
    copies.resize(forces.size());
    replacesSpheres.resize(forces.size());
    copyForces();
}

void EnergyPlan::copyForces()
{
    // The Context keeps a Force that was removed from the System.

    const StericExclusionForce* steric = NULL;
    for (size_t i = 0; i < forces.size(); i++)
        if (isSteric[i])
            steric = dynamic_cast<const StericExclusionForce*>(findForce(i));
    for (size_t i = 0; i < forces.size(); i++) {
        const Force* force = findForce(i);
        if (force == NULL)
            continue;
        if (const NativeForceKind* kind = NativeForceKind::find(*force))
            copies[i].reset(kind->copy(*force));
        if (steric != NULL)
            replacesSpheres[i] = holdsParticlesOf(*force, *steric);
    }
}

const Force* EnergyPlan::findForce(int index) const
{
    const System& system = context.getSystem();
    for (int i = 0; i < system.getNumForces(); i++)
        if (&system.getForce(i) == forces[index])
            return forces[index];
    return NULL;
}

// ---- Spheres ----

/**
 * Get the first Force of these groups whose energy of pairs replaces spheres, or -1 if there is none.
 */
int EnergyPlan::findReplacement(int groups) const
{
    for (size_t i = 0; i < entries.size(); i++)
        if (replacesSpheres[i] && (entries[i].groups & groups) != 0)
            return i;
    return -1;
}

EnergyPlan::StericMode EnergyPlan::resolve(StericMode mode, int groups) const
{
    if (mode != TorsionMonteCarloIntegrator::Automatic)
        return mode;
    return findReplacement(groups) >= 0 ? TorsionMonteCarloIntegrator::Off : TorsionMonteCarloIntegrator::Hard;
}

/**
 * Describe the part of the StericExclusionForce in U, and why.
 */
string EnergyPlan::describeStericPart(StericMode mode, int groups) const
{
    const int replacement = findReplacement(groups);
    switch (mode) {
    case TorsionMonteCarloIntegrator::Soft:
        return "its soft spheres are a part of the energy";
    case TorsionMonteCarloIntegrator::Hard:
        return "its spheres are hard, so that they have no energy";
    case TorsionMonteCarloIntegrator::Off:
        return "the steric mode is Off: its spheres have no effect";
    default:
        if (replacement < 0)
            return "no sampled Force has an energy of pairs of all its particles, so its spheres are hard";
        return "its spheres have no effect: force " + to_string(replacement) + ", " + entries[replacement].name +
               ", has an energy of all pairs";
    }
}

CoreSpheres EnergyPlan::findCoreSpheres(int groups, double energy) const
{
    // Another energy of pairs could compensate a high energy of Lennard-Jones and Coulomb.

    int index = -1;
    for (size_t i = 0; i < entries.size(); i++) {
        if ((entries[i].groups & groups) == 0 || isSteric[i] || hasNoEnergy[i])
            continue;
        const bool isNonbonded = dynamic_cast<const NonbondedForce*>(copies[i].get()) != NULL;
        if (isNonbonded ? index >= 0 : entries[i].kind == Foreign)
            return CoreSpheres();
        if (isNonbonded)
            index = i;
    }
    if (index < 0 || !terms.pairSets.empty() || !terms.valueEnergies.empty())
        return CoreSpheres();

    // Without images in the energy, images may overlap.

    for (size_t i = 0; i < entries.size(); i++)
        if (isSteric[i] && forces[i]->usesPeriodicBoundaryConditions() &&
            !copies[index]->usesPeriodicBoundaryConditions())
            return CoreSpheres();

    // The cutoff and periodic images do not matter at such short distances.

    unique_ptr<Force> copy(NativeForceKind::find(*copies[index])->copy(*copies[index]));
    NonbondedForce& force = dynamic_cast<NonbondedForce&>(*copy);
    if (force.getNonbondedMethod() != NonbondedForce::CutoffNonPeriodic)
        force.setNonbondedMethod(NonbondedForce::NoCutoff);
    force.setExceptionsUsePeriodicBoundaryConditions(false);
    EnergyTerms pairs;
    if (!translateForce(force, index, context.getSystem(), context.getParameters(), pairs).empty())
        return CoreSpheres();
    return CoreSpheres(pairs.nonbonded[0], terms.termSets, energy);
}

// ---- Decisions ----

/**
 * Decide about a Force, and append it to the terms if it is native.
 */
void EnergyPlan::decide(int index, int groupsOfU, bool allowNative)
{
    auto set = [&](Kind kind, const string& reason) {
        entries[index].kind = kind;
        entries[index].reason = reason;
    };
    if (hasNoEnergy[index])
        return set(None, "it has no energy");
    if ((entries[index].groups & groupsOfU) == 0)
        return set(None, "its force group is not an integration force group");
    if (!allowNative)
        return set(Foreign, "native energies are switched off");
    if (!copies[index])
        return set(Foreign, "openmm-chaintree has no code for a " + classNames[index]);
    if (isPeriodic && (entries[index].groups & ~groupsOfU) != 0)
        return set(Foreign, "one of its two force groups is not an integration force group");
    const string reason =
        translateForce(*copies[index], index, context.getSystem(), context.getParameters(), terms, isPeriodic);
    if (!reason.empty())
        return set(Foreign, reason);
    set(Native, "openmm-chaintree evaluates it");
}

void EnergyPlan::translate(int groups, bool allowNative, StericMode mode)
{
    terms = EnergyTerms();
    terms.standIn = standIn;
    auto needsPairs = [&](size_t i) {
        return copies[i] && NativeForceKind::find(*copies[i])->needsPairs;
    };
    for (bool second : {false, true})
        for (size_t i = 0; i < entries.size(); i++)
            if (needsPairs(i) == second && !isSteric[i])
                decide(i, groups, allowNative);
    for (size_t i = 0; i < entries.size(); i++)
        if (isSteric[i]) {
            entries[i].kind = mode == TorsionMonteCarloIntegrator::Soft ? Native : None;
            entries[i].reason = describeStericPart(mode, groups);
        }
}

/**
 * Get whether a Force has some of these parts of the terms.
 */
template <class PART>
static bool hasPart(const vector<PART>& parts, int force)
{
    return any_of(parts.begin(), parts.end(), [force](const PART& part) {
        return part.force == force;
    });
}

int EnergyPlan::findEwaldForce() const
{
    for (const EnergyTerms::Nonbonded& nonbonded : terms.nonbonded)
        if (nonbonded.ewaldAlpha > 0)
            return nonbonded.force;
    return -1;
}

bool EnergyPlan::hasStandIn(int index) const
{
    return hasPart(terms.born, index) || (hasPart(terms.nonbonded, index) && !terms.born.empty());
}

bool EnergyPlan::isOfValues(int index) const
{
    return hasPart(terms.valueEnergies, index);
}

/**
 * Describe how a Force with pairs or values is evaluated; empty for other Forces.
 */
string EnergyPlan::describePairs(int index) const
{
    if (hasStandIn(index))
        return "trials use a stand-in";
    if (hasPart(terms.nonbonded, index) || hasPart(terms.pairSets, index))
        return "openmm-chaintree evaluates the pairs that a trial changes";
    for (const EnergyTerms::ValueEnergy& energy : terms.valueEnergies)
        if (energy.force == index)
            return energy.reason;
    return "";
}

void EnergyPlan::setChangeableTerms(const vector<int>& counts, bool somethingMoves)
{
    for (size_t i = 0; i < entries.size(); i++) {
        long long numTerms = 0, numChangeable = 0;
        const string pairs = describePairs(i);
        bool isTranslated = !pairs.empty();
        for (size_t j = 0; j < terms.termSets.size(); j++) {
            const EnergyTerms::TermSet& set = terms.termSets[j];
            if (set.force != (int)i)
                continue;
            isTranslated = true;
            numTerms += set.particles.size() / max(1, set.particlesPerTerm);
            numChangeable += counts[j];
        }
        if (!isTranslated)
            continue;
        Entry& entry = entries[i];
        const bool canChange = somethingMoves && (!pairs.empty() || numChangeable > 0);
        entry.kind = canChange ? Native : Constant;
        if (!pairs.empty())
            entry.reason = canChange ? pairs : "nothing moves";
        else if (numTerms == 0)
            entry.reason = "it has no terms";
        else if (!canChange)
            entry.reason = "no move can change its " + plural(numTerms, "term");
        else if (numChangeable == numTerms)
            entry.reason =
                "moves can change " + string(numTerms == 1 ? "its one term" : "all of its " + plural(numTerms, "term"));
        else
            entry.reason = "moves can change " + to_string(numChangeable) + " of its " + plural(numTerms, "term") +
                           "; the rest are constant";
    }
}

int EnergyPlan::getGroups(Kind kind) const
{
    int groups = 0;
    for (const Entry& entry : entries)
        if (entry.kind == kind)
            groups |= entry.groups;
    return groups;
}

set<int> EnergyPlan::getTranslatedForces() const
{
    set<int> translated;
    auto add = [&](auto& parts) {
        for (auto& part : parts)
            translated.insert(part.force);
    };
    add(terms.nonbonded);
    add(terms.born);
    add(terms.pairSets);
    add(terms.termSets);
    add(terms.valueEnergies);
    return translated;
}

int EnergyPlan::getWhollyNativeGroups() const
{
    int native = 0;
    for (int force : getTranslatedForces())
        native |= entries[force].groups;
    return native & ~getGroups(Foreign);
}

vector<double> EnergyPlan::sumByForce(double nonbonded, double born, const vector<double>& pairSets,
                                      const vector<double>& termSets, const vector<double>& valueEnergies) const
{
    vector<double> energies(entries.size());
    for (const EnergyTerms::Nonbonded& term : terms.nonbonded)
        energies[term.force] += nonbonded;
    for (const EnergyTerms::Born& term : terms.born)
        energies[term.force] += born;
    for (size_t i = 0; i < terms.pairSets.size(); i++)
        energies[terms.pairSets[i].force] += pairSets[i];
    for (size_t i = 0; i < terms.termSets.size(); i++)
        energies[terms.termSets[i].force] += termSets[i];
    for (size_t i = 0; i < terms.valueEnergies.size(); i++)
        energies[terms.valueEnergies[i].force] += valueEnergies[i];
    return energies;
}

vector<double> EnergyPlan::computeByForce(SceneEnergy& energy) const
{
    double nonbonded, born = 0;
    vector<double> pairSets, termSets, valueEnergies;
    energy.getEnergies(nonbonded, pairSets, termSets);
    if (!terms.born.empty())
        energy.computeWhole(nonbonded, born);
    if (!terms.valueEnergies.empty())
        energy.computeValues(false, valueEnergies);
    return sumByForce(nonbonded, born, pairSets, termSets, valueEnergies);
}
