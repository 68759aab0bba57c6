#include "openmmchaintree/internal/FormMatch.h"
#include "lepton/Operation.h"
#include "lepton/ParsedExpression.h"
#include "lepton/Parser.h"
#include "openmmchaintree/internal/NormalForm.h"

using namespace ChainTreePlugin;
using namespace std;
using Lepton::ExpressionTreeNode;
using Lepton::Operation;

FormMatch::FormMatch(const ExpressionTreeNode& node, const map<string, string>& variables, const vector<string>& known)
{
    const NormalForm form(node, variables);
    map<string, string> canonical;
    for (auto& variable : variables)
        canonical[variable.second] = variable.second;
    for (index = 0; index < (int)known.size(); index++) {
        const NormalForm other(Lepton::Parser::parse(known[index]).getRootNode(), canonical);
        if (other.getShape() != form.getShape())
            continue;
        const vector<ExpressionTreeNode> theirs = other.getCoefficients(), ours = form.getCoefficients();
        for (size_t i = 0; i < ours.size(); i++) {
            if (theirs[i].getOperation().getId() == Operation::VARIABLE)
                named[theirs[i].getOperation().getName()].push_back(ours[i]);
            else
                determined.push_back(make_pair(ours[i], theirs[i]));
        }
        return;
    }
    index = -1;
}
