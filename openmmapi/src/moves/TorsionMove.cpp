#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/JointChoices.h"
#include "openmmchaintree/internal/MoveDeclaration.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define TORSION_MOVE(P)                                                                                                \
    P(Angle, maxAngle, "largest angle")                                                                                \
    P(Indices, torsions, "all")                                                                                        \
    P(Count, count, "number of torsions", 1)

MOVE_PARAMETERS(TorsionMove, TORSION_MOVE)

namespace {

/**
 * Turns a number of different torsions, each by a uniform angle. See TorsionMonteCarloIntegrator::addTorsionMove().
 */
class TorsionMove : public DeclaredMove<TorsionMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    string getSubject() const
    {
        return count == 1 ? getKind().name : to_string(count) + " torsions";
    }
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);

private:
    /** The torsions to choose from: those given, or all. */
    vector<int> choices;
    vector<bool> isDrawn;
    vector<int> drawnChoices;
};

} // namespace

void TorsionMove::bind(const LinkStructure& structure, const string& name)
{
    choices = chooseTorsions(structure, torsions, name);
    if (count > (int)choices.size())
        throw OpenMMException(name + " turns " + to_string(count) + " torsions at once, but has only " +
                              to_string(choices.size()) + " to choose from");
    isDrawn.assign(choices.size(), false);
    drawnChoices.resize(count);
}

bool TorsionMove::draw(const TrialSession&, RandomNumberGenerator& random, Proposal& proposal)
{
    // Floyd's algorithm: every set of `count` choices is equally likely, independent of earlier trials.

    for (int i = 0; i < count; i++) {
        int last = choices.size() - count + i;
        int choice = random.drawIndex(last + 1);
        if (isDrawn[choice])
            choice = last;
        isDrawn[choice] = true;
        drawnChoices[i] = choice;
    }
    for (int i = 0; i < count; i++) {
        isDrawn[drawnChoices[i]] = false;
        proposal.addTorsion(choices[drawnChoices[i]], random.drawSymmetric(getScale() * maxAngle));
    }
    return true;
}

MOVE("torsion", TorsionMove, TORSION_MOVE)
