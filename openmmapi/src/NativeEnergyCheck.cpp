#include "openmmchaintree/internal/NativeEnergyCheck.h"
#include "openmm/Context.h"
#include "openmm/Force.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/NonbondedForce.h"
#include "openmm/OpenMMException.h"
#include "openmm/Platform.h"
#include "openmm/System.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <random>
#include <set>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NUM_GROUPS = 32;

/** The force group of reciprocal spaces in Contexts of copies, which is not evaluated. */
static const int IGNORED_GROUP = NUM_GROUPS - 1;

// Tolerances. The scene's terms are in double precision. Its pairs are in single precision: the distance of two
// particles is rounded by some 1e-7 nm, since leaves are some nm wide. Forces give the resulting error of an energy,
// also where parts of it cancel, and where particles overlap.

/** The accuracy of the library of energies, kJ/mol and relative. */
static const double ABSOLUTE = 5e-3, RELATIVE = 1e-6;
/** The rounding of positions, nm: twice the usual value. */
static const double ROUNDING = 4e-7;
/** The rounding of the energy of one pair, kJ/mol. For the pairs of N particles it is about N times as large. */
static const double PAIR_ROUNDING = 1e-6;
/**
 * The loss per pair where an expression adds a small term to a large one, kJ/mol. It does not average out: without a
 * cutoff most pairs are far apart and lose their dispersion. In two boxes of water, of 5,000 and 12,000 particles, the
 * loss was 2e-9 to 1.1e-8.
 */
static const double PAIR_LOSS = 3e-8;
/** Beyond this, kJ/mol, single precision may overflow. */
static const double HUGE_ENERGY = 1e30;
/** The largest random displacement in each direction, nm: much larger than rounding, and too small for overlaps. */
static const double SHAKE = 1e-3;
/** The error of a held energy, as a multiple of the error of a recomputed one. */
static const double KEPT = 4;
/** A mean force on particles, kJ/mol/nm, above which overlaps hide all other errors. */
static const double LARGE_FORCE = 25000;

// The same for the Context that is sampled, whose Platform may use single precision for everything.

static const double CONTEXT_ABSOLUTE = 0.5, CONTEXT_RELATIVE = 1e-4;
static const double CONTEXT_ROUNDING = 1e-6, CONTEXT_HUGE_ENERGY = 1e15;

static bool isRectangular(const BoxVectors& box)
{
    return box[1][0] == 0 && box[2][0] == 0 && box[2][1] == 0;
}

/**
 * Get the Platform that evaluates periodic pairs, or NULL if there is none. In boxes that are not rectangular, lists of
 * neighbors of OpenMM's Reference platform lack pairs (seen with OpenMM 8).
 */
static Platform* findPairPlatform(const BoxVectors& box)
{
    const string name = isRectangular(box) ? "Reference" : "CPU";
    for (int i = 0; i < Platform::getNumPlatforms(); i++)
        if (Platform::getPlatform(i).getName() == name)
            return &Platform::getPlatform(i);
    return NULL;
}

/** OpenMM's energy of a Force. */
class NativeEnergyCheck::Result {
public:
    /** The index of the Force in the System that is sampled. */
    int force;
    /** Whether the Platform may have used single precision. */
    bool isSingle;
    double energy;
    /** The square root of the sum of all squared forces, kJ/mol/nm. */
    double gradient;
};

/**
 * A Context that evaluates copies of some Forces, each in its own group. All positions are set, so the System needs
 * neither virtual sites nor constraints.
 */
class NativeEnergyCheck::Copies {
public:
    Copies(const System& original, const BoxVectors& box, const EnergyPlan& plan, const vector<int>& forces,
           Platform& platform) :
        integrator(0.001)
    {
        system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
        for (int i = 0; i < original.getNumParticles(); i++)
            system.addParticle(original.getParticleMass(i));
        for (int index : forces) {
            Force* copy = NativeForceKind::find(plan.getCopy(index))->copy(plan.getCopy(index));
            copy->setForceGroup(system.addForce(copy));
            if (NonbondedForce* nonbonded = dynamic_cast<NonbondedForce*>(copy))
                nonbonded->setReciprocalSpaceForceGroup(IGNORED_GROUP);
            results.push_back({index, platform.getName() != "Reference", 0, 0});
        }
        context.reset(new Context(system, integrator, platform));
    }
    void compute(const vector<Vec3>& positions, const map<string, double>& parameters)
    {
        context->setPositions(positions);
        for (auto& parameter : map<string, double>(context->getParameters()))
            context->setParameter(parameter.first, parameters.at(parameter.first));
        for (size_t group = 0; group < results.size(); group++) {
            State state = context->getState(State::Energy | State::Forces, false, 1u << group);
            double sum = 0;
            for (const Vec3& force : state.getForces())
                sum += force.dot(force);
            results[group].energy = state.getPotentialEnergy();
            results[group].gradient = sqrt(sum);
        }
    }
    vector<Result> results;

private:
    System system;
    VerletIntegrator integrator;
    unique_ptr<Context> context;
};

// ---- Messages ----

static string toText(double energy)
{
    stringstream text;
    text.imbue(locale::classic());
    text.precision(10);
    text << energy << " kJ/mol";
    return text.str();
}

static string describe(const EnergyPlan& plan, int force)
{
    return "force " + to_string(force) + " (" + plan.getEntries()[force].name + ")";
}

static void failOfForce(const EnergyPlan& plan, int force, double energy, double ofOpenMM)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: openmm-chaintree and OpenMM do not agree about the energy of " +
                          describe(plan, force) + ": " + toText(energy) + " and " + toText(ofOpenMM) +
                          ". Please report this; setNativeEnergies(False) lets OpenMM evaluate every Force");
}

static void failOfGroup(const EnergyPlan& plan, int group, const vector<int>& forces, double energy, double ofContext)
{
    string list;
    for (int force : forces)
        list += (list.empty() ? "" : ", ") + describe(plan, force);
    throw OpenMMException("TorsionMonteCarloIntegrator: the Context's energy of force group " + to_string(group) +
                          " is " + toText(ofContext) + ", but by its Forces it is " + toText(energy) +
                          ". Probably one of them was edited after the Context was made, without "
                          "updateParametersInContext() or in values that it does not copy: " +
                          list +
                          ". Reinitialize the Context. Otherwise please report this; setNativeEnergies(False) lets "
                          "OpenMM evaluate every Force");
}

// ---- Comparison ----

/**
 * Get whether two energies agree within a tolerance. If one of them is infinite or not a number, the other must be so,
 * too, or be huge.
 */
static bool agree(double energy1, double energy2, double tolerance, double hugeEnergy)
{
    if (isfinite(energy1) && isfinite(energy2))
        return abs(energy1 - energy2) <= tolerance;
    return (!isfinite(energy1) || abs(energy1) > hugeEnergy) && (!isfinite(energy2) || abs(energy2) > hugeEnergy);
}

NativeEnergyCheck::NativeEnergyCheck(ContextImpl& context, const EnergyPlan& plan, const SceneMaker& makeScene) :
    context(context), plan(plan), makeScene(makeScene)
{
}

/**
 * Find the Forces with energies of pairs.
 */
static set<int> findPairForces(const EnergyTerms& terms)
{
    set<int> forces;
    for (const EnergyTerms::Nonbonded& nonbonded : terms.nonbonded)
        forces.insert(nonbonded.force);
    for (const EnergyTerms::Born& born : terms.born)
        forces.insert(born.force);
    for (const EnergyTerms::PairSet& pairs : terms.pairSets)
        forces.insert(pairs.force);
    for (const EnergyTerms::ValueEnergy& energy : terms.valueEnergies)
        forces.insert(energy.force);
    return forces;
}

/**
 * Find the Forces with periodic pairs that the Reference platform takes from its lists of neighbors. A GBSAOBCForce has
 * none there.
 */
static set<int> findPeriodicPairs(const EnergyPlan& plan)
{
    const EnergyTerms& terms = plan.getTerms();
    set<int> forces;
    for (const EnergyTerms::Born& born : terms.born)
        if (born.periodic && dynamic_cast<const GBSAOBCForce*>(&plan.getCopy(born.force)) == NULL)
            forces.insert(born.force);
    for (const EnergyTerms::Nonbonded& nonbonded : terms.nonbonded)
        if (nonbonded.periodic)
            forces.insert(nonbonded.force);
    for (const EnergyTerms::PairSet& pairs : terms.pairSets)
        if (pairs.periodic)
            forces.insert(pairs.force);
    for (const EnergyTerms::ValueEnergy& energy : terms.valueEnergies)
        if (energy.periodic)
            forces.insert(energy.force);
    return forces;
}

/**
 * Estimate the error of the energy of a Force by rounding of pairs, kJ/mol, in a System of numParticles particles.
 */
static double roundingOfPairs(const EnergyTerms& terms, int force, double gradient, double numParticles)
{
    double rounding = ROUNDING * gradient + PAIR_ROUNDING * numParticles;
    for (const EnergyTerms::PairSet& pairs : terms.pairSets)
        if (pairs.force == force && !isfinite(pairs.cutoff))
            rounding += PAIR_LOSS * numParticles * numParticles / 2;
    return rounding;
}

/**
 * Find a Force whose energies differ by more than usual rounding and an allowance; NULL if there is none.
 */
const NativeEnergyCheck::Result* NativeEnergyCheck::findDisagreement(const vector<Result>& results,
                                                                     const vector<double>& energies,
                                                                     const vector<double>& allowances) const
{
    const int numParticles = context.getSystem().getNumParticles();
    const set<int> pairForces = findPairForces(plan.getTerms());
    for (const Result& result : results) {
        double tolerance = ABSOLUTE + RELATIVE * abs(result.energy) + allowances[result.force];
        if (pairForces.count(result.force) != 0)
            tolerance += roundingOfPairs(plan.getTerms(), result.force, result.gradient, numParticles);
        if (result.isSingle)
            tolerance += CONTEXT_ABSOLUTE + CONTEXT_RELATIVE * abs(result.energy) + CONTEXT_ROUNDING * result.gradient;
        if (!agree(energies[result.force], result.energy, tolerance, HUGE_ENERGY))
            return &result;
    }
    return NULL;
}

/**
 * Get positions near these, at which no two pairs have the same distance.
 */
static vector<Vec3> shake(vector<Vec3> positions)
{
    mt19937 random(1);
    const auto draw = [&random] {
        return SHAKE * (2.0 * random() / mt19937::max() - 1);
    };
    for (Vec3& position : positions)
        for (int i = 0; i < 3; i++)
            position[i] += draw();
    return positions;
}

/**
 * Compute the energy of each Force in another scene.
 */
vector<double> NativeEnergyCheck::recompute(const vector<Vec3>& positions) const
{
    const unique_ptr<Scene> scene = makeScene();
    scene->getEnergy().setTerms(plan.getTerms());
    scene->setPositions(positions, getBoxVectors(context));
    scene->getEnergy().update(true);
    return plan.computeByForce(scene->getEnergy());
}

/**
 * Find by how much more than usual the energies of Forces may differ at these positions. On a lattice thousands of
 * pairs have the same distance, to the last bit, so their rounding errors are equal and do not average out. If energies
 * agree at positions nearby, this is the reason, and the allowance is the error of a recomputed energy.
 */
vector<double> NativeEnergyCheck::findAllowances(const vector<Vec3>& positions, const vector<Result>& results) const
{
    vector<double> allowances(context.getSystem().getNumForces(), 0);
    const vector<Vec3> shaken = shake(positions);
    if (findDisagreement(evaluate(shaken), recompute(shaken), allowances) != NULL)
        return allowances;
    const set<int> pairForces = findPairForces(plan.getTerms());
    const vector<double> energies = recompute(positions);
    for (const Result& result : results)
        if (pairForces.count(result.force) != 0)
            allowances[result.force] = KEPT * abs(energies[result.force] - result.energy);
    return allowances;
}

/**
 * Compare the energy of each Force.
 */
void NativeEnergyCheck::checkForces(const vector<Vec3>& positions, const vector<Result>& results,
                                    const vector<double>& energies) const
{
    const Result* wrong = findDisagreement(results, energies, vector<double>(energies.size(), 0));
    if (wrong != NULL && isfinite(wrong->energy) && isfinite(energies[wrong->force]))
        wrong = findDisagreement(results, energies, findAllowances(positions, results));
    if (wrong == NULL)
        return;
    if (std::isnan(wrong->energy))
        throw OpenMMException("TorsionMonteCarloIntegrator: the energy of the integration force groups is not a "
                              "number: that of " +
                              describe(plan, wrong->force) +
                              " by OpenMM. Probably some particles are at the same place");
    failOfForce(plan, wrong->force, energies[wrong->force], wrong->energy);
}

bool NativeEnergyCheck::sayMuch(const vector<Result>& results) const
{
    const double largeGradient = LARGE_FORCE * sqrt((double)context.getSystem().getNumParticles());
    return all_of(results.begin(), results.end(), [largeGradient](const Result& result) {
        return isfinite(result.energy) && result.gradient <= largeGradient;
    });
}

/**
 * Compare the energy of groups with the Context that is sampled, which may use other parameters than the Forces have
 * now.
 */
void NativeEnergyCheck::checkGroups(const vector<Result>& results, const GroupEnergy& groupEnergy) const
{
    int groups = plan.getWhollyNativeGroups();
    if (!isRectangular(getBoxVectors(context)))
        for (int force : findPeriodicPairs(plan))
            if (context.getPlatform().getName() == "Reference" || findPairPlatform(getBoxVectors(context)) == NULL)
                groups &= ~plan.getEntries()[force].groups;
    for (int group = 0; group < NUM_GROUPS; group++) {
        if ((groups >> group & 1) == 0)
            continue;
        vector<int> forces;
        double energy = 0, tolerance = CONTEXT_ABSOLUTE;
        for (const Result& result : results) {
            const EnergyPlan::Entry& entry = plan.getEntries()[result.force];
            if ((entry.groups >> group & 1) == 0)
                continue;
            forces.push_back(result.force);
            if (entry.groups == entry.reciprocalGroup || (entry.reciprocalGroup >> group & 1) == 0) {
                energy += result.energy;
                tolerance += CONTEXT_RELATIVE * abs(result.energy) + CONTEXT_ROUNDING * result.gradient;
            }
        }
        const double ofContext = groupEnergy(1u << group);
        if (!agree(energy, ofContext, tolerance, CONTEXT_HUGE_ENERGY))
            failOfGroup(plan, group, forces, energy, ofContext);
    }
}

/**
 * Let OpenMM evaluate each native Force. Its Contexts take much more memory than the scene, so each is deleted at once.
 */
vector<NativeEnergyCheck::Result> NativeEnergyCheck::evaluate(const vector<Vec3>& positions) const
{
    const BoxVectors box = getBoxVectors(context);
    Platform* ofPairs = findPairPlatform(box);
    const set<int> periodicPairs = findPeriodicPairs(plan);
    vector<int> onReference, onOther;
    for (int force : plan.getTranslatedForces()) {
        if (isRectangular(box) || periodicPairs.count(force) == 0)
            onReference.push_back(force);
        else if (ofPairs != NULL)
            onOther.push_back(force);
    }
    vector<Result> results;
    auto add = [&](const vector<int>& forces, size_t batchSize, Platform& platform) {
        for (size_t begin = 0; begin < forces.size(); begin += batchSize) {
            const size_t end = min(forces.size(), begin + batchSize);
            const vector<int> batch(forces.begin() + begin, forces.begin() + end);
            Copies copies(context.getSystem(), box, plan, batch, platform);
            copies.compute(positions, context.getParameters());
            results.insert(results.end(), copies.results.begin(), copies.results.end());
        }
    };
    add(onReference, IGNORED_GROUP, Platform::getPlatform("Reference"));

    // Other platforms need equal exclusions of all Forces.

    if (!onOther.empty())
        add(onOther, 1, *ofPairs);
    return results;
}

bool NativeEnergyCheck::check(const vector<Vec3>& positions, const vector<double>& energies,
                              const GroupEnergy& groupEnergy) const
{
    const vector<Result> results = evaluate(positions);
    checkForces(positions, results, energies);
    if (groupEnergy)
        checkGroups(results, groupEnergy);
    return sayMuch(results);
}
