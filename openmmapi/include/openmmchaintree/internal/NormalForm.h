#ifndef OPENMM_CHAINTREE_NORMALFORM_H_
#define OPENMM_CHAINTREE_NORMALFORM_H_

#include "lepton/ExpressionTreeNode.h"
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * An expression as a sum of products of powers, so that two ways to write the same can be told to be the same.
 *
 * Some names are its variables. What does not depend on these is a coefficient, however it is written. Products of sums
 * are multiplied out, terms that differ in their coefficients alone are added, and terms and factors have a fixed
 * order. Two expressions of the same shape differ in their coefficients alone.
 */
class NormalForm {
public:
    /**
     * @param expression  an expression
     * @param variables   the names of its variables, and what the shape calls them
     */
    NormalForm(const Lepton::ExpressionTreeNode& expression, const std::map<std::string, std::string>& variables);
    /**
     * Get the expression without its coefficients.
     */
    const std::string& getShape() const
    {
        return sum.shape;
    }
    /**
     * Get the coefficients, in the order in which they stand in the shape. Those of one are among them.
     */
    std::vector<Lepton::ExpressionTreeNode> getCoefficients() const;

private:
    class Sum;
    /** A variable, or a function of sums, or a sum in parentheses. */
    class Atom {
    public:
        /** Empty if it is a sum. */
        std::string name;
        std::vector<Sum> arguments;
        /** It without its coefficients, and with them. */
        std::string shape, text;
    };
    class Factor {
    public:
        std::shared_ptr<const Atom> atom;
        double power;
    };
    class Term {
    public:
        Lepton::ExpressionTreeNode coefficient;
        std::vector<Factor> factors;
    };
    class Sum {
    public:
        std::vector<Term> terms;
        std::string shape, text;
    };
    class Builder;
    static void listCoefficients(const Sum& sum, std::vector<Lepton::ExpressionTreeNode>& list);
    Sum sum;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_NORMALFORM_H_*/
