#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmm/NonbondedForce.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <typeindex>
#if __has_include(<cxxabi.h>)
#include <cxxabi.h>
#define HAS_MANGLED_NAMES
#endif

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

// ---- Kinds ----

/**
 * Get all kinds by their classes. They are registered before main() begins, in undefined order.
 */
static map<type_index, const NativeForceKind*>& knownKinds()
{
    static map<type_index, const NativeForceKind*> kinds;
    return kinds;
}

void NativeForceKind::add(const type_info& type)
{
    knownKinds()[type] = this;
}

const NativeForceKind* NativeForceKind::find(const Force& force)
{
    auto found = knownKinds().find(typeid(force));
    return found == knownKinds().end() ? NULL : found->second;
}

// ---- Sets of terms ----

EnergyTerms::TermSet ChainTreePlugin::createTermSet(int force, ctTermKind kind, int particlesPerTerm,
                                                    int parametersPerTerm)
{
    EnergyTerms::TermSet set;
    set.force = force;
    set.kind = kind;
    set.particlesPerTerm = particlesPerTerm;
    set.parametersPerTerm = parametersPerTerm;
    return set;
}

void ChainTreePlugin::addTerm(EnergyTerms::TermSet& set, const vector<int>& particles, const vector<double>& parameters)
{
    set.particles.insert(set.particles.end(), particles.begin(), particles.end());
    set.parameters.insert(set.parameters.end(), parameters.begin(), parameters.end());
}

string ChainTreePlugin::checkBornPartners(const EnergyTerms& terms)
{
    if (terms.nonbonded.empty())
        return "it needs a NonbondedForce that openmm-chaintree evaluates, too";
    if (terms.nonbonded[0].ewaldAlpha > 0)
        return "it needs a NonbondedForce without Ewald summation";
    if (!terms.born.empty())
        return "openmm-chaintree has code for one Force of generalized Born, and there is another before it";
    return "";
}

// ---- Checks that a Context has made, but that a Force may fail since then ----

static const char NO_NUMBER[] = "one of its parameters is infinite or not a number";
static const char WRONG_COUNT[] = "it has not as many particles as the System";

static bool areFinite(const vector<double>& values)
{
    return all_of(values.begin(), values.end(), [](double value) {
        return isfinite(value);
    });
}

/**
 * Check a set of terms. Returns an empty text, or else why it has no energy.
 */
static string check(const EnergyTerms::TermSet& set, int numParticles)
{
    const size_t numTerms = set.particlesPerTerm < 1 ? 0 : set.particles.size() / set.particlesPerTerm;
    if (numTerms == 0 && !set.particles.empty())
        return "its terms have no particles";
    if (set.particles.size() != numTerms * set.particlesPerTerm ||
        set.parameters.size() != numTerms * set.parametersPerTerm)
        return "one of its terms has a wrong number of particles or parameters";
    for (int particle : set.particles)
        if (particle < 0 || particle >= numParticles)
            return "there is no particle " + to_string(particle);
    bool isFinite = areFinite(set.parameters);
    for (const EnergyTerms::Map& map : set.maps)
        isFinite = isFinite && areFinite(map.coefficients);
    for (const ctOperation& operation : set.operations)
        isFinite = isFinite && isfinite(operation.constant);
    if (!isFinite)
        return NO_NUMBER;
    if (set.kind == ctTorsionMapTerm)
        for (double map : set.parameters)
            if (map < 0 || map >= set.maps.size())
                return "one of its torsions has no map";
    return "";
}

static string check(const vector<array<int, 2>>& exclusions, int numParticles)
{
    for (const array<int, 2>& exclusion : exclusions)
        for (int particle : exclusion)
            if (particle < 0 || particle >= numParticles)
                return "there is no particle " + to_string(particle);
    return "";
}

static string check(const EnergyTerms::Nonbonded& nonbonded, int numParticles)
{
    if ((int)nonbonded.charges.size() != numParticles)
        return WRONG_COUNT;
    if (!areFinite(nonbonded.charges) || !areFinite(nonbonded.sigmas) || !areFinite(nonbonded.epsilons))
        return NO_NUMBER;
    return check(nonbonded.exclusions, numParticles);
}

static string check(const EnergyTerms::PairSet& set, int numParticles)
{
    if (set.parameters.size() != (size_t)numParticles * set.parametersPerParticle)
        return WRONG_COUNT;
    bool isFinite = areFinite(set.parameters);
    for (const ctOperation& operation : set.operations)
        isFinite = isFinite && isfinite(operation.constant);
    for (const EnergyTerms::TableFunction& table : set.tables)
        isFinite = isFinite && areFinite(table.values);
    if (!isFinite)
        return NO_NUMBER;
    for (const EnergyTerms::InteractionGroup& group : set.groups)
        for (const vector<int>& particles : group)
            for (int particle : particles)
                if (particle < 0 || particle >= numParticles)
                    return "there is no particle " + to_string(particle);
    return check(set.exclusions, numParticles);
}

static string check(const EnergyTerms::Born& born, int numParticles)
{
    if ((int)born.charges.size() != numParticles)
        return WRONG_COUNT;
    for (const vector<double>& values : {born.charges, born.radii, born.offsetRadii, born.scaledRadii, born.alphas,
                                         born.betas, born.gammas, born.neckHeights, born.neckDistances})
        if (!areFinite(values))
            return NO_NUMBER;
    for (const vector<double>& radii : {born.radii, born.offsetRadii})
        for (double radius : radii)
            if (radius <= 0)
                return "one of its radii is not positive";
    const double numbers = born.neckScale + born.neckCut + born.coulomb + born.soluteDielectric +
                           born.solventDielectric + born.kappa + born.surfaceEnergy + born.probeRadius + born.shift;
    if (!isfinite(numbers))
        return NO_NUMBER;
    if (!(born.soluteDielectric > 0 && born.solventDielectric > 0 && born.kappa >= 0 && born.coulomb >= 0))
        return "its dielectrics or its screening make no sense";
    return born.cutoff > 0 ? "" : "its cutoff makes no sense";
}

static bool areFinite(const vector<EnergyTerms::ValueExpression>& expressions)
{
    for (const EnergyTerms::ValueExpression& expression : expressions) {
        for (const ctOperation& operation : expression.operations)
            if (!isfinite(operation.constant))
                return false;
        for (const EnergyTerms::TableFunction& table : expression.tables)
            if (!areFinite(table.values))
                return false;
    }
    return true;
}

static string check(const EnergyTerms::ValueEnergy& energy, int numParticles)
{
    if (energy.parameters.size() != (size_t)numParticles * energy.parametersPerParticle)
        return WRONG_COUNT;
    if (!areFinite(energy.parameters) || !areFinite(energy.values) || !areFinite(energy.terms))
        return NO_NUMBER;
    if (!(energy.cutoff > 0))
        return "its cutoff makes no sense";
    return check(energy.exclusions, numParticles);
}

// ---- Forces ----

namespace {

/**
 * The numbers of terms of each kind.
 */
class Size {
public:
    explicit Size(const EnergyTerms& terms) :
        nonbonded(terms.nonbonded.size()), born(terms.born.size()), pairSets(terms.pairSets.size()),
        termSets(terms.termSets.size()), valueEnergies(terms.valueEnergies.size())
    {
    }
    /**
     * Remove terms that were appended since.
     */
    void restore(EnergyTerms& terms) const
    {
        terms.nonbonded.resize(nonbonded);
        terms.born.resize(born);
        terms.pairSets.resize(pairSets);
        terms.termSets.resize(termSets);
        terms.valueEnergies.resize(valueEnergies);
    }
    /**
     * Check that pairs that were appended since are of a periodic scene. Returns an empty text, or else why not.
     */
    string checkImages(const EnergyTerms& terms) const
    {
        bool arePeriodic = true;
        for (size_t i = born; i < terms.born.size(); i++)
            arePeriodic = arePeriodic && terms.born[i].periodic;
        for (size_t i = nonbonded; i < terms.nonbonded.size(); i++)
            arePeriodic = arePeriodic && terms.nonbonded[i].periodic;
        for (size_t i = pairSets; i < terms.pairSets.size(); i++)
            arePeriodic = arePeriodic && terms.pairSets[i].periodic;
        for (size_t i = valueEnergies; i < terms.valueEnergies.size(); i++)
            arePeriodic = arePeriodic && terms.valueEnergies[i].periodic;
        return arePeriodic ? "" : "its pairs have no periodic images, but the StericExclusionForce counts images";
    }
    const size_t nonbonded, born, pairSets, termSets, valueEnergies;
};

} // namespace

string ChainTreePlugin::getClassName(const Force& force)
{
    string name = typeid(force).name();
#ifdef HAS_MANGLED_NAMES
    int status = 0;
    unique_ptr<char, void (*)(void*)> demangled(abi::__cxa_demangle(name.c_str(), NULL, NULL, &status), free);
    if (demangled)
        name = demangled.get();
#endif
    return name.substr(name.rfind(':') + 1);
}

/**
 * Append the energy of a Force to the terms. Returns an empty text, or else why it cannot; then the terms may be
 * incomplete.
 */
static string append(const Force& force, const NativeForceKind::Setting& setting, EnergyTerms& terms)
{
    const System& system = setting.system;
    const NativeForceKind* kind = NativeForceKind::find(force);
    if (kind == NULL)
        return "openmm-chaintree has no code for a " + getClassName(force);
    const Size before(terms);
    string reason = kind->translate(force, setting, terms);
    const bool isPeriodic = force.usesPeriodicBoundaryConditions();
    if (reason.empty() && isPeriodic && !setting.isPeriodic)
        reason = "it uses periodic boundary conditions";
    if (dynamic_cast<const NonbondedForce*>(&force) == NULL) // whose exceptions are periodic or not
        for (size_t i = before.termSets; i < terms.termSets.size(); i++)
            terms.termSets[i].periodic = isPeriodic;
    if (reason.empty() && setting.isPeriodic)
        reason = before.checkImages(terms);
    auto checkNew = [&](auto& parts, size_t first) {
        for (size_t i = first; i < parts.size() && reason.empty(); i++)
            reason = check(parts[i], system.getNumParticles());
    };
    checkNew(terms.nonbonded, before.nonbonded);
    checkNew(terms.born, before.born);
    checkNew(terms.pairSets, before.pairSets);
    checkNew(terms.termSets, before.termSets);
    checkNew(terms.valueEnergies, before.valueEnergies);
    return reason;
}

string ChainTreePlugin::translateForce(const Force& force, int index, const System& system,
                                       const NativeForceKind::Parameters& parameters, EnergyTerms& terms,
                                       bool isPeriodic)
{
    const Size before(terms);
    string reason;
    try {
        reason = append(force, {index, system, parameters, isPeriodic}, terms);
    }
    catch (const bad_alloc&) {
        throw;
    }
    catch (const exception& error) {
        reason = string("it cannot be read (") + error.what() + ")";
    }
    if (!reason.empty())
        before.restore(terms);
    return reason;
}
