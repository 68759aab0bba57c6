#ifndef OPENMM_CHAINTREE_FORMMATCH_H_
#define OPENMM_CHAINTREE_FORMMATCH_H_

#include "lepton/ExpressionTreeNode.h"
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * Finds which of some known expressions has the normal form of an expression, and the values of the known expression's
 * coefficients, by name.
 */
class FormMatch {
public:
    /**
     * @param node       the expression
     * @param variables  the names of its variables, and their names in the known expressions
     * @param known      the known expressions. All their names except variables stand for coefficients
     */
    FormMatch(const Lepton::ExpressionTreeNode& node, const std::map<std::string, std::string>& variables,
              const std::vector<std::string>& known);
    /**
     * Get the index of the known expression; -1: none.
     */
    int getIndex() const
    {
        return index;
    }
    bool has(const std::string& name) const
    {
        return named.count(name) != 0;
    }
    const Lepton::ExpressionTreeNode& get(const std::string& name) const
    {
        return named.at(name)[0];
    }
    /**
     * Get all coefficients that a name stands for.
     */
    const std::vector<Lepton::ExpressionTreeNode>& getAll(const std::string& name) const
    {
        return named.at(name);
    }
    /**
     * Get the coefficients that are not names in the known expression, with their required values: functions of names,
     * or numbers.
     */
    const std::vector<std::pair<Lepton::ExpressionTreeNode, Lepton::ExpressionTreeNode>>& getDetermined() const
    {
        return determined;
    }

private:
    int index;
    std::map<std::string, std::vector<Lepton::ExpressionTreeNode>> named;
    std::vector<std::pair<Lepton::ExpressionTreeNode, Lepton::ExpressionTreeNode>> determined;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_FORMMATCH_H_*/
