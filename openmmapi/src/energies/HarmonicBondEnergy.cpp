#include "openmm/HarmonicBondForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateHarmonicBonds(const Force& owner, int index, const System&, const NativeForceKind::Parameters&,
                                     EnergyTerms& terms)
{
    const HarmonicBondForce& force = dynamic_cast<const HarmonicBondForce&>(owner);
    EnergyTerms::TermSet set = createTermSet(index, ctHarmonicBondTerm, 2, 2);
    for (int i = 0; i < force.getNumBonds(); i++) {
        int p1, p2;
        double length, k;
        force.getBondParameters(i, p1, p2, length, k);
        addTerm(set, {p1, p2}, {length, k});
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind KIND(typeid(HarmonicBondForce), translateHarmonicBonds, copyForce<HarmonicBondForce>);
