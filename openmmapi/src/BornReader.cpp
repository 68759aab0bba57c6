#include "openmmchaintree/internal/BornReader.h"
#include "lepton/Operation.h"
#include "lepton/ParsedExpression.h"
#include "openmmchaintree/internal/BornFormula.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;
using Lepton::ExpressionTreeNode;
using Lepton::Operation;

// ---- The expressions of the models ----

static const string PAIR_SUM = "step(r+s2-o1)*0.5*(1/L-1/U+0.25*(r-s2^2/r)*(1/U^2-1/L^2)+0.5*log(L/U)/r)";
static const string NECK = "+step(reach-r)*height/(1+100*(r+shift)^2+300000*(r+shift)^6)";
static const string FILLING = "+step(r+s2-o1)*step(s2-r-o1)*(1/o1-1/L)";
static const string SPHERES = "; U=r+s2; L=max(o1,abs(r-s2))";

/** Models with filled spheres come last. */
static const vector<string> PAIR_SUMS = {PAIR_SUM + SPHERES, PAIR_SUM + NECK + SPHERES, PAIR_SUM + FILLING + SPHERES,
                                         PAIR_SUM + NECK + FILLING + SPHERES};
static const int FIRST_FILLED = 2;
static const vector<string> RADII = {"one/(o+t*I)", "one/(o+t*tanh(p1*I+p2*I^2+p3*I^3))", "one/(o+t*tanh(p1*I+p3*I^3))",
                                     "one/(o+t*tanh(p1*I+p2*I^2))", "one/(o+t*tanh(p1*I))"};
/** The rounding error of a pair sum (1/nm) whose parts cancel, for particles 0.02 nm apart. */
static const double SUM_ROUNDING = 1e-10;
/** The largest number of particle types of a tabulated parameter. */
static const int MAX_NECK_TYPES = 128;
/** The largest number of particles for which all pairs are compared. */
static const size_t MAX_COMPARED = 300;
/** The number of random comparisons of energies. */
static const int NUM_RANDOM = 300;

void BornReader::require(bool condition, const char* what)
{
    if (!condition)
        throw UnknownBornModel(string("its ") + what +
                               " is not that of a generalized Born model that openmm-chaintree knows");
}

bool BornReader::areSame(double a, double b, double rounding)
{
    return abs(a - b) <= 1e-9 * (abs(a) + abs(b)) + rounding;
}

static bool isNumber(const ExpressionTreeNode& node)
{
    const vector<ExpressionTreeNode>& children = node.getChildren();
    return node.getOperation().getId() != Operation::VARIABLE && all_of(children.begin(), children.end(), isNumber);
}

// ---- The expressions of the Force ----

void BornReader::parse()
{
    string expression;
    CustomGBForce::ComputationType type;
    require(force.getNumComputedValues() == 2, "number of computed values");
    force.getComputedValueParameters(0, sumName, expression, type);
    const bool excludes = force.getNumExclusions() > 0;
    require(type == CustomGBForce::ParticlePairNoExclusions || (type == CustomGBForce::ParticlePair && !excludes),
            "first computed value");
    pairSum = model.parse(expression);
    force.getComputedValueParameters(1, radiusName, expression, type);
    require(type == CustomGBForce::SingleParticle, "second computed value");
    radius = model.parse(expression);
    int numSelf = 0, numPair = 0;
    for (int i = 0; i < force.getNumEnergyTerms(); i++) {
        force.getEnergyTermParameters(i, expression, type);
        require(type != CustomGBForce::ParticlePair || !excludes, "exclusion of pairs");
        const ExpressionTreeNode term = model.parse(expression);
        auto add = [&](ExpressionTreeNode& sum, int& count) {
            sum = count++ == 0 ? term : ExpressionTreeNode(new Operation::Add(), sum, term);
        };
        if (type == CustomGBForce::SingleParticle)
            add(selfEnergy, numSelf);
        else
            add(pairEnergy, numPair);
    }
    require(numSelf > 0 && numPair > 0, "number of energy terms");
}

// ---- Coefficients ----

/**
 * Get the value of an expression for each particle: in expressions of two particles, the first or the second one; in
 * others, OnNone.
 */
vector<double> BornReader::getValues(const ExpressionTreeNode& node, ParticleExpressions::Dependence particle) const
{
    require((model.getDependence(node) & ~particle) == 0, "order of particles");
    vector<double> values;
    if (particle == ParticleExpressions::OnNone) {
        auto compute = model.ofParticle(node);
        for (int i = 0; i < numParticles; i++)
            values.push_back(compute(i, {}));
    }
    else {
        auto compute = model.ofPair(node);
        for (int i = 0; i < numParticles; i++)
            values.push_back(compute(i, i, {}));
    }
    return values;
}

vector<double> BornReader::getValues(const FormMatch& match, const string& name) const
{
    return match.has(name) ? getValues(match.get(name), ParticleExpressions::OnNone) : vector<double>(numParticles);
}

/**
 * Get the value of a name, which must be one number for all particles and everywhere in the expression.
 */
double BornReader::getNumber(const FormMatch& match, const string& name) const
{
    if (!match.has(name))
        return 0;
    const double number = model.computeNumber(match.get(name));
    for (const ExpressionTreeNode& node : match.getAll(name))
        require(areSame(number, model.computeNumber(node)), "screening");
    return number;
}

/**
 * Get whether a coefficient of pairs has the expected values, which are a sum, or else a product, of functions of one
 * particle each. If it is such a sum or product itself, pairs with one particle suffice; else all pairs have to be
 * compared.
 */
bool BornReader::arePairs(const ExpressionTreeNode& node, bool product, function<double(int, int)> expected)
{
    auto compute = model.ofPair(node);
    auto isExpected = [&](int i, int j) {
        return areSame(compute(i, j, {}), expected(i, j));
    };
    const vector<int>& particles = model.getDifferentParticles();
    int reference = particles[0];
    for (int i : particles)
        if (abs(expected(i, i)) > abs(expected(reference, reference)))
            reference = i;
    for (int i : particles)
        if (!isExpected(i, reference) || !isExpected(reference, i))
            return false;
    if (model.isSeparable(node, product))
        return true;
    if (particles.size() > MAX_COMPARED)
        return false;
    for (int i : particles)
        for (int j : particles)
            if (!isExpected(i, j))
                return false;
    return true;
}

/**
 * Require that the coefficients without a name are the numbers of the model.
 */
void BornReader::requireNumbers(const FormMatch& match, const char* what) const
{
    for (auto& pair : match.getDetermined()) {
        require(model.getDependence(pair.first) == ParticleExpressions::OnNone, what);
        require(areSame(model.computeNumber(pair.first), Lepton::ParsedExpression(pair.second).evaluate()), what);
    }
}

// ---- Born radii ----

void BornReader::readPairSum()
{
    const char* what = "pair sum";
    const FormMatch match(pairSum, {{"r", "r"}}, PAIR_SUMS);
    require(match.getIndex() >= 0, what);
    born.offsetRadii = getValues(match.get("o1"), ParticleExpressions::OnFirst);
    born.scaledRadii = getValues(match.get("s2"), ParticleExpressions::OnSecond);
    for (const ExpressionTreeNode& node : match.getAll("o1"))
        require(getValues(node, ParticleExpressions::OnFirst) == born.offsetRadii, what);
    for (const ExpressionTreeNode& node : match.getAll("s2"))
        require(getValues(node, ParticleExpressions::OnSecond) == born.scaledRadii, what);
    for (auto& pair : match.getDetermined()) {
        if (model.getDependence(pair.first) == ParticleExpressions::OnNone && isNumber(pair.second)) {
            require(areSame(model.computeNumber(pair.first), model.computeNumber(pair.second)), what);
            continue;
        }
        const Lepton::ParsedExpression expression(pair.second);
        auto expected = [&](int i, int j) {
            return expression.evaluate({{"o1", born.offsetRadii[i]}, {"s2", born.scaledRadii[j]}});
        };
        require(arePairs(pair.first, false, expected), what);
    }
    born.filled = match.getIndex() >= FIRST_FILLED;
    readRadii();
    if (match.has("reach"))
        readNecks(match);
}

void BornReader::readRadii()
{
    const char* what = "Born radius";
    const FormMatch match(radius, {{sumName, "I"}, {"x", "x"}, {"y", "y"}, {"z", "z"}}, RADII);
    require(match.getIndex() >= 0, what);
    const vector<double> one = getValues(match, "one"), o = getValues(match, "o"), t = getValues(match, "t");
    const vector<double> p1 = getValues(match, "p1"), p2 = getValues(match, "p2"), p3 = getValues(match, "p3");
    born.rescaled = match.has("p1");
    for (int i = 0; i < numParticles; i++) {
        const double offsetRadius = born.offsetRadii[i];
        require(areSame(o[i] * offsetRadius, one[i]), what);
        if (!born.rescaled) {
            require(areSame(t[i], -one[i]), what);
            born.radii.push_back(offsetRadius);
            continue;
        }
        born.radii.push_back(-one[i] / t[i]);
        born.alphas.push_back(p1[i] / offsetRadius);
        born.betas.push_back(0 - p2[i] / (offsetRadius * offsetRadius));
        born.gammas.push_back(p3[i] / (offsetRadius * offsetRadius * offsetRadius));
    }
}

/**
 * Make tables of necks by the parameters on which they depend.
 */
void BornReader::readNecks(const FormMatch& match)
{
    const char* what = "neck";
    require(born.rescaled, what);
    auto reach = model.ofPair(match.get("reach"));
    born.neckScale = 1;
    born.neckCut = reach(0, 0, {}) - 2 * born.radii[0];
    auto expected = [&](int i, int j) {
        return born.radii[i] + born.radii[j] + born.neckCut;
    };
    require(arePairs(match.get("reach"), false, expected), what);
    set<int> used;
    for (const char* name : {"height", "shift"})
        for (const ExpressionTreeNode& node : match.getAll(name)) {
            const set<int> parameters = model.findParameters(node);
            used.insert(parameters.begin(), parameters.end());
        }
    map<vector<double>, int> types;
    vector<int> examples;
    for (int i = 0; i < numParticles; i++) {
        vector<double> values;
        for (int parameter : used)
            values.push_back(model.getParameter(i, parameter));
        auto added = types.insert(make_pair(values, (int)types.size()));
        if (added.second)
            examples.push_back(i);
        born.neckTypes.push_back(added.first->second);
    }
    born.numNeckTypes = types.size();
    require(born.numNeckTypes <= MAX_NECK_TYPES, "number of different necks");
    auto height = model.ofPair(match.get("height"));
    auto shift = model.ofPair(match.get("shift")), otherShift = model.ofPair(match.getAll("shift").at(1));
    for (int j : examples)
        for (int i : examples) {
            born.neckHeights.push_back(height(i, j, {}));
            born.neckDistances.push_back(-shift(i, j, {}));
            require(areSame(shift(i, j, {}), otherShift(i, j, {})), what);
        }
}

// ---- The whole model ----

/**
 * Compare the Force with its translation for random particles.
 */
void BornReader::guard()
{
    const BornFormula formula(born);
    auto sum = model.ofPair(pairSum), pairs = model.ofPair(pairEnergy);
    auto radii = model.ofParticle(radius), self = model.ofParticle(selfEnergy);
    for (int k = 0; k < NUM_RANDOM; k++) {
        const int i = drawParticle(), j = drawParticle();
        const double r = 0.02 * pow(200, draw(0, 1)), I = draw(-0.2, 1) / born.offsetRadii[i];
        const double B1 = draw(0.05, 3), B2 = draw(0.05, 3);
        require(areSame(sum(i, j, {{"r", r}}), formula.computePairSum(i, j, r), SUM_ROUNDING), "pair sum");
        require(areSame(radii(i, {{sumName, I}}), formula.computeRadius(i, I)), "Born radius");
        require(areSame(self(i, {{radiusName, B1}}), formula.computeSelfEnergy(i, B1)), "energy of particles");
        require(areSame(pairs(i, j, {{"r", r}, {radiusName + "1", B1}, {radiusName + "2", B2}}),
                        formula.computePairEnergy(i, j, r, B1, B2)),
                "pair energy");
    }
}

EnergyTerms::Born BornReader::read(int index)
{
    born.force = index;
    born.cutoff = numeric_limits<double>::infinity();
    if (force.getNonbondedMethod() != CustomGBForce::NoCutoff)
        born.cutoff = force.getCutoffDistance();
    born.periodic = force.getNonbondedMethod() == CustomGBForce::CutoffPeriodic;
    require(numParticles > 0, "number of particles");
    parse();
    readPairSum();
    readPairEnergy();
    readSelfEnergy();
    guard();
    return born;
}
