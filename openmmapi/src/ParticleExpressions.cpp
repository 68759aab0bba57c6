#include "openmmchaintree/internal/ParticleExpressions.h"
#include "lepton/Operation.h"
#include "lepton/ParsedExpression.h"
#include "lepton/Parser.h"
#include <cmath>
#include <limits>

using namespace ChainTreePlugin;
using namespace std;
using Lepton::ExpressionTreeNode;
using Lepton::Operation;
using Lepton::ParsedExpression;

void ParticleExpressions::findDifferent()
{
    set<vector<double>> known;
    for (size_t i = 0; i < particles.size(); i++)
        if (known.insert(particles[i]).second)
            different.push_back(i);
}

ExpressionTreeNode ParticleExpressions::parse(const string& expression) const
{
    return Lepton::Parser::parse(expression, functions.get()).getRootNode();
}

ParticleExpressions::OfParticle ParticleExpressions::ofParticle(const ExpressionTreeNode& node) const
{
    const ParsedExpression expression = ParsedExpression(node).optimize(globals);
    return [=](int particle, const Variables& others) {
        Variables variables = others;
        for (size_t i = 0; i < names.size(); i++)
            variables[names[i]] = particles[particle][i];
        return expression.evaluate(variables);
    };
}

ParticleExpressions::OfPair ParticleExpressions::ofPair(const ExpressionTreeNode& node) const
{
    const ParsedExpression expression = ParsedExpression(node).optimize(globals);
    const set<int> used = findParameters(node);
    return [=](int particle1, int particle2, const Variables& others) {
        Variables variables = others;
        for (int i : used) {
            variables[names[i] + "1"] = particles[particle1][i];
            variables[names[i] + "2"] = particles[particle2][i];
        }
        return expression.evaluate(variables);
    };
}

double ParticleExpressions::computeNumber(const ExpressionTreeNode& node) const
{
    return ParsedExpression(node).optimize(globals).evaluate();
}

// ---- Dependence on particles ----

/**
 * Find the parameter that a node names. Returns its index and the particle; an index of -1 if there is none.
 */
static pair<int, int> findParameter(const ExpressionTreeNode& node, const vector<string>& names)
{
    if (node.getOperation().getId() == Operation::VARIABLE)
        for (size_t i = 0; i < names.size(); i++)
            for (int particle : {1, 2})
                if (node.getOperation().getName() == names[i] + to_string(particle))
                    return make_pair(i, particle);
    return make_pair(-1, 0);
}

ParticleExpressions::Dependence ParticleExpressions::getDependence(const ExpressionTreeNode& node) const
{
    int dependence = findParameter(node, names).second;
    for (const ExpressionTreeNode& child : node.getChildren())
        dependence |= getDependence(child);
    return (Dependence)dependence;
}

set<int> ParticleExpressions::findParameters(const ExpressionTreeNode& node) const
{
    set<int> found;
    const int index = findParameter(node, names).first;
    if (index >= 0)
        found.insert(index);
    for (const ExpressionTreeNode& child : node.getChildren()) {
        const set<int> inChild = findParameters(child);
        found.insert(inChild.begin(), inChild.end());
    }
    return found;
}

bool ParticleExpressions::isSeparable(const ExpressionTreeNode& node, bool product) const
{
    if (getDependence(node) != OnBoth)
        return true;
    const vector<ExpressionTreeNode>& children = node.getChildren();
    switch (node.getOperation().getId()) {
    case Operation::NEGATE:
        return isSeparable(children[0], product);
    case Operation::ADD:
    case Operation::SUBTRACT:
        return !product && isSeparable(children[0], product) && isSeparable(children[1], product);
    case Operation::MULTIPLY:
    case Operation::DIVIDE:
        if (!product && getDependence(children[0]) != OnNone && getDependence(children[1]) != OnNone)
            return false;
        return isSeparable(children[0], product) && isSeparable(children[1], product);
    default:
        return false;
    }
}

bool ChainTreePlugin::areSameInEitherOrder(double energy, double reversedEnergy)
{
    if (!isfinite(energy) || !isfinite(reversedEnergy))
        return isfinite(energy) == isfinite(reversedEnergy);
    return abs(energy - reversedEnergy) <= 1e-9 * (abs(energy) + abs(reversedEnergy)) + numeric_limits<double>::min();
}
