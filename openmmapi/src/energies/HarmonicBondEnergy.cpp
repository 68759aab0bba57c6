#include "openmm/HarmonicBondForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateHarmonicBonds(const HarmonicBondForce& force, const NativeForceKind::Setting& setting,
                                     EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctHarmonicBondTerm, 2, 2);
    for (int i = 0; i < force.getNumBonds(); i++) {
        int p1, p2;
        double length, k;
        force.getBondParameters(i, p1, p2, length, k);
        addTerm(set, {p1, p2}, {length, k});
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind HARMONIC_BONDS(translateHarmonicBonds);
