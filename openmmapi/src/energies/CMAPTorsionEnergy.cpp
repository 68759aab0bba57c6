#include "openmm/CMAPTorsionForce.h"
#include "openmm/internal/CMAPTorsionForceImpl.h"
#include "openmmchaintree/internal/ForceTranslation.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string translateCMAPTorsions(const CMAPTorsionForce& force, const NativeForceKind::Setting& setting,
                                    EnergyTerms& terms)
{
    EnergyTerms::TermSet set = createTermSet(setting.index, ctTorsionMapTerm, 8, 1);
    for (int i = 0; i < force.getNumMaps(); i++) {
        EnergyTerms::Map map;
        vector<double> energies;
        vector<vector<double>> patches;
        force.getMapParameters(i, map.size, energies);
        CMAPTorsionForceImpl::calcMapDerivatives(map.size, energies, patches);
        for (const vector<double>& patch : patches)
            map.coefficients.insert(map.coefficients.end(), patch.begin(), patch.end());
        set.maps.push_back(map);
    }
    for (int i = 0; i < force.getNumTorsions(); i++) {
        int map;
        vector<int> p(8);
        force.getTorsionParameters(i, map, p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]);
        addTerm(set, p, {(double)map});
    }
    terms.termSets.push_back(set);
    return "";
}

static const NativeForceKind CMAP_TORSIONS(translateCMAPTorsions);
