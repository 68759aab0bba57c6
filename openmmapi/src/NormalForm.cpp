#include "openmmchaintree/internal/NormalForm.h"
#include "lepton/Operation.h"
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

using namespace ChainTreePlugin;
using namespace std;
using Lepton::ExpressionTreeNode;
using Lepton::Operation;

/** The name of the exponential function, whose powers are exponentials. */
static const char EXP[] = "exp";

/** The largest number of terms of a sum. */
static const size_t MAX_TERMS = 200;

// ---- Coefficients ----

static ExpressionTreeNode toNode(double value)
{
    return ExpressionTreeNode(new Operation::Constant(value));
}

static bool isConstant(const ExpressionTreeNode& node, double& value)
{
    if (node.getOperation().getId() != Operation::CONSTANT)
        return false;
    value = dynamic_cast<const Operation::Constant&>(node.getOperation()).getValue();
    return true;
}

/**
 * Evaluate an expression. Returns false if it depends on a name.
 */
static bool evaluate(const ExpressionTreeNode& node, double& value)
{
    if (node.getOperation().getId() == Operation::VARIABLE)
        return false;
    vector<double> arguments(node.getChildren().size() + 1);
    for (size_t i = 0; i < node.getChildren().size(); i++)
        if (!evaluate(node.getChildren()[i], arguments[i]))
            return false;
    value = node.getOperation().evaluate(arguments.data(), {});
    return true;
}

static ExpressionTreeNode multiply(const ExpressionTreeNode& a, const ExpressionTreeNode& b)
{
    double value;
    if (isConstant(a, value) && value == 1)
        return b;
    if (isConstant(b, value) && value == 1)
        return a;
    return ExpressionTreeNode(new Operation::Multiply(), a, b);
}

static ExpressionTreeNode raise(const ExpressionTreeNode& a, double power)
{
    double value;
    if (power == 1 || (isConstant(a, value) && value == 1))
        return a;
    return ExpressionTreeNode(new Operation::Power(), a, toNode(power));
}

static string toText(double value)
{
    stringstream text;
    text << hexfloat << value;
    return text.str();
}

/**
 * Write an expression so that different ones have different texts.
 */
static string toText(const ExpressionTreeNode& node)
{
    double value;
    if (isConstant(node, value))
        return toText(value);
    string text = node.getOperation().getName() + "[" + to_string(node.getOperation().getId());
    for (const ExpressionTreeNode& child : node.getChildren())
        text += "," + toText(child);
    return text + "]";
}

// ---- Sums ----

/**
 * Makes sums for one set of variables.
 */
class NormalForm::Builder {
public:
    explicit Builder(const map<string, string>& variables) : variables(variables)
    {
    }
    Sum build(const ExpressionTreeNode& node) const
    {
        const vector<ExpressionTreeNode>& children = node.getChildren();
        if (!isVariable(node))
            return finish({{node, {}}});
        switch (node.getOperation().getId()) {
        case Operation::VARIABLE:
            return toSum(variables.at(node.getOperation().getName()), {});
        case Operation::ADD:
            return add(build(children[0]), build(children[1]));
        case Operation::SUBTRACT:
            return add(build(children[0]), scale(build(children[1]), -1));
        case Operation::NEGATE:
            return scale(build(children[0]), -1);
        case Operation::MULTIPLY:
            return multiply(build(children[0]), build(children[1]));
        case Operation::DIVIDE:
            return multiply(build(children[0]), raise(build(children[1]), -1));
        case Operation::SQRT:
            return raise(build(children[0]), 0.5);
        case Operation::POWER:
            return buildPower(node);
        case Operation::SELECT:
            return buildSelect(node);
        default:
            return buildFunction(node);
        }
    }

private:
    bool isVariable(const ExpressionTreeNode& node) const
    {
        if (node.getOperation().getId() == Operation::VARIABLE)
            return variables.count(node.getOperation().getName()) != 0;
        return any_of(node.getChildren().begin(), node.getChildren().end(), [&](const ExpressionTreeNode& child) {
            return isVariable(child);
        });
    }

    // Expressions

    Sum buildPower(const ExpressionTreeNode& node) const
    {
        double power;
        if (!::evaluate(node.getChildren()[1], power))
            return buildFunction(node);
        return raise(build(node.getChildren()[0]), power);
    }
    /**
     * select(step, value, 0) is the product of step and value.
     */
    Sum buildSelect(const ExpressionTreeNode& node) const
    {
        const vector<ExpressionTreeNode>& children = node.getChildren();
        double value;
        if (children[0].getOperation().getId() != Operation::STEP || !::evaluate(children[2], value) || value != 0)
            return buildFunction(node);
        return multiply(build(children[0]), build(children[1]));
    }
    Sum buildFunction(const ExpressionTreeNode& node) const
    {
        vector<Sum> arguments;
        for (const ExpressionTreeNode& child : node.getChildren())
            arguments.push_back(build(child));
        const Operation::Id id = node.getOperation().getId();
        if (id == Operation::MIN || id == Operation::MAX)
            sort(arguments.begin(), arguments.end(), [](const Sum& a, const Sum& b) {
                return a.shape < b.shape;
            });
        if (id == Operation::ABS && isNegative(arguments[0]))
            arguments[0] = scale(arguments[0], -1);
        return toSum(id == Operation::EXP ? EXP : node.getOperation().getName() + "#" + to_string(id), arguments);
    }
    static bool isNegative(const Sum& sum)
    {
        double value;
        return ::evaluate(sum.terms.back().coefficient, value) && value < 0;
    }

    // Calculation with sums

    static Sum toSum(const string& name, const vector<Sum>& arguments)
    {
        Atom atom = {name, arguments, name + "(", name + "("};
        for (const Sum& argument : arguments) {
            atom.shape += argument.shape + ",";
            atom.text += argument.text + ",";
        }
        atom.shape += ")";
        atom.text += ")";
        return finish({{toNode(1), {{make_shared<Atom>(atom), 1}}}});
    }
    static Sum add(const Sum& a, const Sum& b)
    {
        vector<Term> terms = a.terms;
        terms.insert(terms.end(), b.terms.begin(), b.terms.end());
        return finish(terms);
    }
    static Sum scale(const Sum& sum, double factor)
    {
        vector<Term> terms = sum.terms;
        for (Term& term : terms)
            term.coefficient = ::multiply(toNode(factor), term.coefficient);
        return finish(terms);
    }
    static Sum multiply(const Sum& a, const Sum& b)
    {
        vector<Term> terms;
        for (const Term& x : a.terms)
            for (const Term& y : b.terms) {
                const Sum product = multiply(x, y);
                terms.insert(terms.end(), product.terms.begin(), product.terms.end());
                if (terms.size() > MAX_TERMS)
                    throw runtime_error("its expression has too many terms");
            }
        return finish(terms);
    }
    static Sum multiply(const Term& a, const Term& b)
    {
        Term product = {::multiply(a.coefficient, b.coefficient), a.factors};
        for (const Factor& factor : b.factors) {
            auto same = find_if(product.factors.begin(), product.factors.end(), [&](const Factor& other) {
                return other.atom->text == factor.atom->text;
            });
            if (same == product.factors.end())
                product.factors.push_back(factor);
            else
                same->power += factor.power;
        }

        // Remove factors with power 0, and multiply out sums with power 1.

        vector<Factor> factors;
        vector<Sum> sums;
        for (const Factor& factor : product.factors)
            if (factor.power == 1 && factor.atom->name.empty())
                sums.push_back(factor.atom->arguments[0]);
            else if (factor.power != 0)
                factors.push_back(factor);
        product.factors = factors;
        Sum result = finish({product});
        for (const Sum& sum : sums)
            result = multiply(result, sum);
        return result;
    }
    static Sum raise(const Sum& sum, double power)
    {
        if (power == 1)
            return sum;
        if (power == 0)
            return finish({{toNode(1), {}}});
        const Term& first = sum.terms[0];
        double value;
        const bool isFactor = sum.terms.size() == 1 && first.factors.size() == 1 && first.factors[0].power == 1 &&
                              isConstant(first.coefficient, value) && value == 1;
        if (sum.terms.size() == 1 && (isFactor || power == floor(power))) {
            Term term = {::raise(first.coefficient, power), {}};
            Sum exponentials = finish({{toNode(1), {}}});
            for (const Factor& factor : first.factors)
                if (factor.atom->name == EXP)
                    exponentials =
                        multiply(exponentials, toSum(EXP, {scale(factor.atom->arguments[0], factor.power * power)}));
                else
                    term.factors.push_back({factor.atom, factor.power * power});
            return multiply(finish({term}), exponentials);
        }
        Atom atom = {"", {sum}, "(" + sum.shape + ")", "(" + sum.text + ")"};
        return finish({{toNode(1), {{make_shared<Atom>(atom), power}}}});
    }

    /**
     * Sort terms and factors, add terms that differ in their coefficients alone, and write the texts.
     */
    static Sum finish(const vector<Term>& terms)
    {
        class Entry {
        public:
            Term term;
            string shape, text;
        };
        vector<Entry> entries;
        for (const Term& term : terms) {
            Entry entry = {term, "", ""};
            vector<Factor>& factors = entry.term.factors;
            sort(factors.begin(), factors.end(), [](const Factor& a, const Factor& b) {
                return make_pair(a.atom->shape, a.power) < make_pair(b.atom->shape, b.power);
            });
            for (const Factor& factor : factors) {
                entry.shape += "*" + factor.atom->shape + "^" + ::toText(factor.power);
                entry.text += "*" + factor.atom->text + "^" + ::toText(factor.power);
            }
            auto same = find_if(entries.begin(), entries.end(), [&](const Entry& other) {
                return other.text == entry.text;
            });
            if (same == entries.end())
                entries.push_back(entry);
            else
                same->term.coefficient =
                    ExpressionTreeNode(new Operation::Add(), same->term.coefficient, term.coefficient);
        }
        stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
            return a.shape < b.shape;
        });
        Sum sum;
        for (const Entry& entry : entries) {
            sum.terms.push_back(entry.term);
            sum.shape += "+" + entry.shape;
            sum.text += "+" + ::toText(entry.term.coefficient) + entry.text;
        }
        return sum;
    }

    const map<string, string>& variables;
};

NormalForm::NormalForm(const ExpressionTreeNode& expression, const map<string, string>& variables) :
    sum(Builder(variables).build(expression))
{
}

void NormalForm::listCoefficients(const Sum& sum, vector<ExpressionTreeNode>& list)
{
    for (const Term& term : sum.terms) {
        list.push_back(term.coefficient);
        for (const Factor& factor : term.factors)
            for (const Sum& argument : factor.atom->arguments)
                listCoefficients(argument, list);
    }
}

vector<ExpressionTreeNode> NormalForm::getCoefficients() const
{
    vector<ExpressionTreeNode> list;
    listCoefficients(sum, list);
    return list;
}
