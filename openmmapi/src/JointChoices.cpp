#include "openmmchaintree/internal/JointChoices.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Check the joints of one kind that a move names.
 *
 * @param links  the link that each joint moves
 * @param kind   "torsion" or "ball joint"
 */
static void checkJoints(const vector<int>& links, const string& kind, const vector<int>& named, const string& name)
{
    if (links.empty())
        throw OpenMMException(name + " turns " + kind + "s, but the StericExclusionForce has none");
    for (int joint : named)
        checkIndex(joint, links.size(), kind, name);
    checkUnique(named, name + " names " + kind + " ");
}

static vector<int> chooseJoints(const LinkStructure& structure, const vector<int>& links, const string& kind,
                                const vector<int>& named, const string& name)
{
    checkJoints(links, kind, named, name);
    for (int joint : named)
        structure.checkNoClosure(links[joint], name);
    vector<int> choices = named;
    if (named.empty())
        for (int joint = 0; joint < (int)links.size(); joint++)
            if (structure.getLinkClosure(links[joint]) == -1)
                choices.push_back(joint);
    return choices;
}

void ChainTreePlugin::checkTorsions(const LinkStructure& structure, const vector<int>& torsions, const string& name)
{
    checkJoints(structure.getTorsionLinks(), "torsion", torsions, name);
}

vector<int> ChainTreePlugin::chooseTorsions(const LinkStructure& structure, const vector<int>& torsions,
                                            const string& name)
{
    const vector<int> choices = chooseJoints(structure, structure.getTorsionLinks(), "torsion", torsions, name);
    if (choices.empty())
        throw OpenMMException(name +
                              " turns torsions, but all of them lie in rings of closures; only closed moves turn "
                              "these");
    return choices;
}

vector<int> ChainTreePlugin::chooseBallJoints(const LinkStructure& structure, const vector<int>& ballJoints,
                                              const string& name)
{
    const vector<int> choices = chooseJoints(structure, structure.getBallJointLinks(), "ball joint", ballJoints, name);
    if (choices.empty())
        throw OpenMMException(name + " turns ball joints, but all of them lie in rings of closures");
    return choices;
}
