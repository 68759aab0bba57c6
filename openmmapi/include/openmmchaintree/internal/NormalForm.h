#ifndef OPENMM_CHAINTREE_NORMALFORM_H_
#define OPENMM_CHAINTREE_NORMALFORM_H_

#include "lepton/ExpressionTreeNode.h"
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * An expression as a sum of products of powers, in which equal expressions that are written differently become the
 * same.
 *
 * Some names are its variables. A factor that does not depend on these is a coefficient. Products of sums are
 * multiplied out, terms that differ in their coefficients alone are added, and terms and factors have a fixed order.
 * Two expressions of the same shape differ in their coefficients alone.
 */
class NormalForm {
public:
    /**
     * @param expression  an expression
     * @param variables   the names of its variables, and their names in the shape
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
     * Get the coefficients, including 1, in their order in the shape.
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
        /** Its text without coefficients, and with them. */
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
