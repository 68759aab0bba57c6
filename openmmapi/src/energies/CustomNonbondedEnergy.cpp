#include "lepton/ParsedExpression.h"
#include "lepton/Parser.h"
#include "openmm/Context.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/Platform.h"
#include "openmm/System.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include "openmmchaintree/internal/ParticleExpressions.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef map<string, double> Variables;

/**
 * The copy constructor does not copy that tables are periodic. Steps copy Forces, so this does not use OpenMM's XML,
 * which shares memory among threads.
 */
static Force* copyCustomNonbonded(const CustomNonbondedForce& original)
{
    unique_ptr<CustomNonbondedForce> copy(new CustomNonbondedForce(original));
    for (int i = 0; i < original.getNumTabulatedFunctions(); i++)
        restorePeriod(original.getTabulatedFunction(i), copy->getTabulatedFunction(i));
    return copy.release();
}

static Variables getGlobals(const CustomNonbondedForce& force, const NativeForceKind::Parameters& parameters)
{
    Variables globals;
    for (int i = 0; i < force.getNumGlobalParameters(); i++)
        globals[force.getGlobalParameterName(i)] = parameters.at(force.getGlobalParameterName(i));
    return globals;
}

/**
 * Get the names of the parameters of each particle, and of values computed from these.
 */
static vector<string> getNames(const CustomNonbondedForce& force)
{
    vector<string> names;
    for (int i = 0; i < force.getNumPerParticleParameters(); i++)
        names.push_back(force.getPerParticleParameterName(i));
    for (int i = 0; i < force.getNumComputedValues(); i++) {
        string name, expression;
        force.getComputedValueParameters(i, name, expression);
        names.push_back(name);
    }
    return names;
}

static string translateMethod(const CustomNonbondedForce& force, bool isPeriodic, EnergyTerms::PairSet& set)
{
    const CustomNonbondedForce::NonbondedMethod method = force.getNonbondedMethod();
    set.cutoff = set.switchingDistance = numeric_limits<double>::infinity();
    if (method == CustomNonbondedForce::NoCutoff)
        return "";
    set.periodic = isPeriodic && method == CustomNonbondedForce::CutoffPeriodic;
    if (method != CustomNonbondedForce::CutoffNonPeriodic && !set.periodic)
        return "its cutoff is periodic";
    set.cutoff = force.getCutoffDistance();
    set.switchingDistance = force.getUseSwitchingFunction() ? force.getSwitchingDistance() : set.cutoff;
    if (!(set.cutoff > 0 && isfinite(set.cutoff) && isfinite(set.switchingDistance)))
        return "its cutoff or switching distance makes no sense";
    return "";
}

static void translateParticles(const CustomNonbondedForce& force, const Variables& globals,
                               const TabulatedFunctions& functions, EnergyTerms::PairSet& set)
{
    vector<Lepton::ParsedExpression> computedValues;
    for (int i = 0; i < force.getNumComputedValues(); i++) {
        string name, expression;
        force.getComputedValueParameters(i, name, expression);
        computedValues.push_back(Lepton::Parser::parse(expression, functions.get()).optimize(globals));
    }
    set.parametersPerParticle = force.getNumPerParticleParameters() + computedValues.size();
    vector<double> values;
    Variables variables;
    for (int i = 0; i < force.getNumParticles(); i++) {
        force.getParticleParameters(i, values);
        for (int j = 0; j < force.getNumPerParticleParameters(); j++)
            variables[force.getPerParticleParameterName(j)] = values.at(j);
        for (const Lepton::ParsedExpression& computedValue : computedValues)
            values.push_back(computedValue.evaluate(variables));
        set.parameters.insert(set.parameters.end(), values.begin(), values.end());
    }
}

static string translateExpression(const CustomNonbondedForce& force, const Variables& globals,
                                  EnergyTerms::PairSet& set)
{
    ExpressionTranslator translator(set);
    translator.addInput("r", {ctMeasureDistance, {0, 1}});
    const vector<string> names = getNames(force);
    vector<double> low(names.size(), INFINITY), high(names.size(), -INFINITY);
    for (size_t i = 0; i < set.parameters.size(); i++) {
        low[i % names.size()] = min(low[i % names.size()], set.parameters[i]);
        high[i % names.size()] = max(high[i % names.size()], set.parameters[i]);
    }
    for (const char* number : {"1", "2"})
        for (size_t i = 0; i < names.size(); i++)
            translator.addParameter(names[i] + number, low[i], high[i]);
    for (auto& global : globals)
        translator.addConstant(global.first, global.second);
    for (int i = 0; i < force.getNumTabulatedFunctions(); i++)
        translator.addTable(force.getTabulatedFunctionName(i), force.getTabulatedFunction(i));
    return translator.translate(force.getEnergyFunction());
}

static void translatePairs(const CustomNonbondedForce& force, EnergyTerms::PairSet& set)
{
    for (int i = 0; i < force.getNumExclusions(); i++) {
        array<int, 2> exclusion;
        force.getExclusionParticles(i, exclusion[0], exclusion[1]);
        set.exclusions.push_back(exclusion);
    }
    for (int i = 0; i < force.getNumInteractionGroups(); i++) {
        std::set<int> set1, set2;
        force.getInteractionGroupParameters(i, set1, set2);
        set.groups.push_back({vector<int>(set1.begin(), set1.end()), vector<int>(set2.begin(), set2.end())});
    }
}

/**
 * Get the long-range correction times the volume of the box: the energy of particles of which no two are within the
 * cutoff, times the volume of their box.
 */
static double measureLongRangeCorrection(const CustomNonbondedForce& force, const Variables& globals)
{
    const double spacing = 3 * force.getCutoffDistance(), numPerSide = ceil(cbrt(force.getNumParticles()));
    const double width = spacing * numPerSide;
    System system;
    system.setDefaultPeriodicBoxVectors(Vec3(width, 0, 0), Vec3(0, width, 0), Vec3(0, 0, width));
    system.addForce(copyCustomNonbonded(force));
    vector<Vec3> positions;
    for (int i = 0; i < force.getNumParticles(); i++) {
        system.addParticle(1);
        const double row = floor(i / numPerSide), layer = floor(row / numPerSide);
        positions.push_back(Vec3(i - row * numPerSide, row - layer * numPerSide, layer) * spacing);
    }
    VerletIntegrator integrator(0.001);
    Context context(system, integrator, Platform::getPlatform("Reference"));
    context.setPositions(positions);
    for (auto& global : globals)
        context.setParameter(global.first, global.second);
    return context.getState(State::Energy).getPotentialEnergy() * pow(width, 3);
}

// ---- The order of two particles ----

/**
 * Get whether the energy of two particles is the same in either order, as OpenMM requires. This tries pairs of
 * particles with different parameters: all, if there are not too many.
 */
static bool isSymmetric(const CustomNonbondedForce& force, const Variables& globals,
                        const TabulatedFunctions& functions, const EnergyTerms::PairSet& set)
{
    const int size = set.parametersPerParticle;
    std::set<vector<double>> different;
    for (int i = 0; i < force.getNumParticles(); i++)
        different.emplace(set.parameters.begin() + i * size, set.parameters.begin() + (i + 1) * size);
    const vector<vector<double>> particles(different.begin(), different.end());
    const Lepton::ParsedExpression expression =
        Lepton::Parser::parse(force.getEnergyFunction(), functions.get()).optimize(globals);
    const vector<string> names = getNames(force);
    auto compute = [&](const vector<double>& particle1, const vector<double>& particle2, double r) {
        Variables variables = {{"r", r}};
        for (int i = 0; i < size; i++) {
            variables[names[i] + "1"] = particle1[i];
            variables[names[i] + "2"] = particle2[i];
        }
        return expression.evaluate(variables);
    };
    mt19937 random(1);
    uniform_real_distribution<double> distance(0.1, min(set.cutoff, 3.0));
    auto isSame = [&](int i, int j) {
        for (double r : {distance(random), distance(random)})
            if (!areSameInEitherOrder(compute(particles[i], particles[j], r), compute(particles[j], particles[i], r)))
                return false;
        return true;
    };
    const int numParticles = particles.size();
    if ((long long)numParticles * (numParticles - 1) / 2 <= NUM_TRIED_PAIRS) {
        for (int i = 0; i < numParticles; i++)
            for (int j = 0; j < i; j++)
                if (!isSame(i, j))
                    return false;
        return true;
    }
    uniform_int_distribution<int> particle(0, numParticles - 1);
    for (int i = 0; i < NUM_TRIED_PAIRS; i++)
        if (!isSame(particle(random), particle(random)))
            return false;
    return true;
}

static string translateCustomNonbonded(const CustomNonbondedForce& force, const NativeForceKind::Setting& setting,
                                       EnergyTerms& terms)
{
    EnergyTerms::PairSet set;
    set.force = setting.index;
    const Variables globals = getGlobals(force, setting.parameters);
    string reason = translateMethod(force, setting.isPeriodic, set);
    if (!reason.empty())
        return reason;
    const TabulatedFunctions functions(force);
    translateParticles(force, globals, functions, set);
    reason = translateExpression(force, globals, set);
    if (!reason.empty())
        return reason;
    translatePairs(force, set);
    if (!isSymmetric(force, globals, functions, set))
        return "its expression is not the same in either order of two particles";
    if (set.periodic && force.getUseLongRangeCorrection())
        set.longRange = measureLongRangeCorrection(force, globals);
    terms.pairSets.push_back(set);
    return "";
}

static const NativeForceKind CUSTOM_NONBONDED(translateCustomNonbonded, copyCustomNonbonded);
