#include "openmm/PeriodicTorsionForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translatePeriodicTorsions(const PeriodicTorsionForce& force, const NativeForceKind::Setting& setting,
                                        EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctPeriodicTorsionTerm, 4, 3);
    for (int i = 0; i < force.getNumTorsions(); i++) {
        int p1, p2, p3, p4, periodicity;
        double phase, k;
        force.getTorsionParameters(i, p1, p2, p3, p4, periodicity, phase, k);
        if (periodicity < 0)
            return "one of its periodicities is negative";
        addTerm(set, {p1, p2, p3, p4}, {(double)periodicity, phase, k});
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind PERIODIC_TORSIONS(translatePeriodicTorsions);
