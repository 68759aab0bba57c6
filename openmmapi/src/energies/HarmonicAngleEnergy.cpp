#include "openmm/HarmonicAngleForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateHarmonicAngles(const Force& owner, int index, const System&, const NativeForceKind::Parameters&,
                                      EnergyTerms& terms)
{
    const HarmonicAngleForce& force = dynamic_cast<const HarmonicAngleForce&>(owner);
    EnergyTerms::TermSet set = createTermSet(index, ctHarmonicAngleTerm, 3, 2);
    for (int i = 0; i < force.getNumAngles(); i++) {
        int p1, p2, p3;
        double angle, k;
        force.getAngleParameters(i, p1, p2, p3, angle, k);
        addTerm(set, {p1, p2, p3}, {angle, k});
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind KIND(typeid(HarmonicAngleForce), translateHarmonicAngles, copyForce<HarmonicAngleForce>);
