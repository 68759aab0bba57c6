#include "openmmchaintree/internal/ValueTranslation.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ParticleExpressions.h"
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

typedef ParticleExpressions::Variables Variables;

namespace {

/**
 * A value or a term of a CustomGBForce.
 */
class Computation {
public:
    string name, expression;
    CustomGBForce::ComputationType type;
};

/**
 * Translates the expressions of a CustomGBForce.
 */
class ValueTranslator {
public:
    ValueTranslator(const CustomGBForce& force, const NativeForceKind::Parameters& parameters,
                    EnergyTerms::ValueEnergy& energy);
    /**
     * Append all values and terms. Returns an empty text, or else why it cannot.
     */
    string translate();

private:
    string add(const Computation& computation, int numValues, vector<EnergyTerms::ValueExpression>& expressions) const;
    void addNames(ExpressionTranslator& translator, const string& suffix, int numValues) const;
    bool isSymmetric(const string& expression) const;
    const CustomGBForce& force;
    const ParticleExpressions model;
    EnergyTerms::ValueEnergy& energy;
    vector<pair<string, double>> globals;
    vector<Computation> values, terms;
    /** The ranges of parameters. */
    vector<double> low, high;
};

} // namespace

ValueTranslator::ValueTranslator(const CustomGBForce& force, const NativeForceKind::Parameters& parameters,
                                 EnergyTerms::ValueEnergy& energy) :
    force(force),
    model(force, parameters), energy(energy), values(force.getNumComputedValues()), terms(force.getNumEnergyTerms()),
    low(model.getNames().size(), INFINITY), high(model.getNames().size(), -INFINITY)
{
    for (size_t i = 0; i < values.size(); i++)
        force.getComputedValueParameters(i, values[i].name, values[i].expression, values[i].type);
    for (size_t i = 0; i < terms.size(); i++)
        force.getEnergyTermParameters(i, terms[i].expression, terms[i].type);
    for (int i = 0; i < force.getNumGlobalParameters(); i++) {
        const string& name = force.getGlobalParameterName(i);
        globals.push_back(make_pair(name, parameters.at(name)));
    }
    energy.parametersPerParticle = low.size();
    for (int i = 0; i < model.getNumParticles(); i++)
        for (size_t j = 0; j < low.size(); j++) {
            const double value = model.getParameter(i, j);
            energy.parameters.push_back(value);
            low[j] = min(low[j], value);
            high[j] = max(high[j], value);
        }
}

/**
 * Name the parameters of a particle, and its first values.
 */
void ValueTranslator::addNames(ExpressionTranslator& translator, const string& suffix, int numValues) const
{
    for (size_t i = 0; i < low.size(); i++)
        translator.addParameter(model.getNames()[i] + suffix, low[i], high[i]);
    for (int i = 0; i < numValues; i++)
        translator.addParameter(values[i].name + suffix);
    translator.skipParameters(values.size() - numValues);
}

string ValueTranslator::add(const Computation& computation, int numValues,
                            vector<EnergyTerms::ValueExpression>& expressions) const
{
    EnergyTerms::ValueExpression translated;
    ExpressionTranslator translator(translated);
    if (computation.type == CustomGBForce::SingleParticle) {
        translated.extent = ctOfParticles;
        addNames(translator, "", numValues);
        for (const char* coordinate : {"x", "y", "z"})
            translator.addParameter(coordinate);
    }
    else {
        translated.extent = computation.type == CustomGBForce::ParticlePair ? ctOfPairs : ctOfAllPairs;
        translator.addInput("r", {ctMeasureDistance, {0, 1}});
        addNames(translator, "1", numValues);
        addNames(translator, "2", numValues);
    }
    for (auto& global : globals)
        translator.addConstant(global.first, global.second);
    for (int i = 0; i < force.getNumTabulatedFunctions(); i++)
        translator.addTable(force.getTabulatedFunctionName(i), force.getTabulatedFunction(i));
    const string reason = translator.translate(computation.expression);
    expressions.push_back(translated);
    return reason;
}

/**
 * Get whether the energy of two particles is the same in either order, as OpenMM requires. This tries random particles,
 * values and distances.
 */
bool ValueTranslator::isSymmetric(const string& expression) const
{
    if (model.getNumParticles() == 0)
        return true;
    const ParticleExpressions::OfPair compute = model.ofPair(model.parse(expression));
    const vector<int>& different = model.getDifferentParticles();
    mt19937 random(1);
    uniform_int_distribution<int> particle(0, different.size() - 1);
    uniform_real_distribution<double> distance(0.1, max(0.2, min(energy.cutoff, 3.0))), number(0.05, 2);
    for (int i = 0; i < NUM_TRIED_PAIRS; i++) {
        const int particle1 = different[particle(random)], particle2 = different[particle(random)];
        Variables there, back;
        there["r"] = back["r"] = distance(random);
        for (const Computation& value : values) {
            there[value.name + "1"] = back[value.name + "2"] = number(random);
            there[value.name + "2"] = back[value.name + "1"] = number(random);
        }
        if (!areSameInEitherOrder(compute(particle1, particle2, there), compute(particle2, particle1, back)))
            return false;
    }
    return true;
}

string ValueTranslator::translate()
{
    for (size_t i = 0; i < values.size(); i++) {
        const string reason = add(values[i], i, energy.values);
        if (!reason.empty())
            return reason;
    }
    for (const Computation& term : terms) {
        const string reason = add(term, values.size(), energy.terms);
        if (!reason.empty())
            return reason;
        if (term.type != CustomGBForce::SingleParticle && !isSymmetric(term.expression))
            return "its expression is not the same in either order of two particles";
    }
    return "";
}

string ChainTreePlugin::translateValues(const CustomGBForce& force, const NativeForceKind::Parameters& parameters,
                                        EnergyTerms::ValueEnergy& energy)
{
    energy.cutoff = numeric_limits<double>::infinity();
    if (force.getNonbondedMethod() != CustomGBForce::NoCutoff)
        energy.cutoff = force.getCutoffDistance();
    for (int i = 0; i < force.getNumExclusions(); i++) {
        array<int, 2> exclusion;
        force.getExclusionParticles(i, exclusion[0], exclusion[1]);
        energy.exclusions.push_back(exclusion);
    }
    return ValueTranslator(force, parameters, energy).translate();
}
