#include "openmm/HarmonicAngleForce.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateHarmonicAngles(const HarmonicAngleForce& force, const NativeForceKind::Setting& setting,
                                      EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctHarmonicAngleTerm, 3, 2);
    for (int i = 0; i < force.getNumAngles(); i++) {
        int p1, p2, p3;
        double angle, k;
        force.getAngleParameters(i, p1, p2, p3, angle, k);
        addTerm(set, {p1, p2, p3}, {angle, k});
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind HARMONIC_ANGLES(translateHarmonicAngles);
