#include "openmmchaintree/internal/MoleculeChoices.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

vector<int> ChainTreePlugin::chooseMolecules(const LinkStructure& structure, const vector<int>& particles,
                                             const string& name)
{
    const vector<LinkStructure::Molecule>& all = structure.getMolecules();
    vector<int> choices;
    vector<bool> isNamed(all.size(), false);
    for (int particle : particles) {
        checkIndex(particle, structure.getParticleLinks().size(), "particle", name);
        int molecule = structure.getParticleMolecule(particle);
        if (all[molecule].fixed)
            throw OpenMMException(name + " names the molecule of particle " + to_string(particle) +
                                  ", which has fixed particles and cannot move");
        if (isNamed[molecule])
            throw OpenMMException(name + " names the molecule of particle " + to_string(particle) + " twice");
        isNamed[molecule] = true;
        choices.push_back(molecule);
    }
    if (particles.empty())
        for (int molecule = 0; molecule < (int)all.size(); molecule++)
            if (!all[molecule].fixed)
                choices.push_back(molecule);
    if (choices.empty())
        throw OpenMMException(name + " moves molecules, but all molecules have fixed particles");
    return choices;
}
