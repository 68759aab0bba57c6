#include "openmm/RBTorsionForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateRBTorsions(const RBTorsionForce& force, const NativeForceKind::Setting& setting,
                                  EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctRyckaertBellemansTerm, 4, 6);
    for (int i = 0; i < force.getNumTorsions(); i++) {
        int p1, p2, p3, p4;
        vector<double> c(6);
        force.getTorsionParameters(i, p1, p2, p3, p4, c[0], c[1], c[2], c[3], c[4], c[5]);
        addTerm(set, {p1, p2, p3, p4}, c);
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind RB_TORSIONS(translateRBTorsions);
