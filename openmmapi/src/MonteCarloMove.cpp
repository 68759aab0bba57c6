#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include <algorithm>
#include <limits>
#include <locale>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Throw an exception if a number appears twice in a list.
 */
static void checkUnique(vector<int> values, const string& message)
{
    sort(values.begin(), values.end());
    auto repeated = adjacent_find(values.begin(), values.end());
    if (repeated != values.end())
        throw OpenMMException(message + to_string(*repeated) + " twice");
}

string ChainTreePlugin::toText(double value)
{
    for (int digits = 1;; digits++) {
        stringstream text;
        text.imbue(locale::classic());
        text.precision(digits);
        text << value;
        double read = 0;
        text >> read;
        if (read == value || digits == numeric_limits<double>::max_digits10)
            return text.str();
    }
}

/**
 * Write the indices that a move chooses from.
 */
static string listIndices(const vector<int>& indices)
{
    string text;
    for (int index : indices)
        text += (text.empty() ? "" : " ") + to_string(index);
    return text.empty() ? "all" : text;
}

TorsionMove::TorsionMove(double maxAngle, const vector<int>& torsions, int count) :
    maxAngle(maxAngle), torsions(torsions), count(count)
{
}

MoveDescription TorsionMove::describe() const
{
    return {{"kind", "torsion"},
            {"maxAngle", toText(maxAngle)},
            {"torsions", listIndices(torsions)},
            {"count", to_string(count)}};
}

void TorsionMove::bind(const LinkStructure& structure, const string& name)
{
    int numTorsions = structure.getTorsionLinks().size();
    if (numTorsions == 0)
        throw OpenMMException(name + " turns torsions, but the StericExclusionForce has none");
    for (int torsion : torsions)
        checkIndex(torsion, numTorsions, "torsion", name);
    checkUnique(torsions, name + " names torsion ");
    choices = torsions;
    if (choices.empty())
        for (int torsion = 0; torsion < numTorsions; torsion++)
            choices.push_back(torsion);
    if (count > (int)choices.size())
        throw OpenMMException(name + " turns " + to_string(count) + " torsions at once, but has only " +
                              to_string(choices.size()) + " to choose from");
    isDrawn.assign(choices.size(), false);
    drawnChoices.resize(count);
    drawnTorsions.resize(count);
    drawnChanges.resize(count);
}

void TorsionMove::propose(CalcStericExclusionForceKernel& kernel, RandomNumberGenerator& random)
{
    // Floyd's algorithm: every set of `count` choices is equally likely, and nothing is remembered between trials.

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
        drawnTorsions[i] = choices[drawnChoices[i]];
        drawnChanges[i] = random.drawSymmetric(maxAngle);
    }
    kernel.proposeTorsions(drawnTorsions, drawnChanges);
}

RigidBodyMove::RigidBodyMove(double maxTranslation, double maxAngle, const vector<int>& molecules) :
    maxTranslation(maxTranslation), maxAngle(maxAngle), molecules(molecules)
{
}

MoveDescription RigidBodyMove::describe() const
{
    return {{"kind", "rigid body"},
            {"maxTranslation", toText(maxTranslation)},
            {"maxAngle", toText(maxAngle)},
            {"molecules", listIndices(molecules)}};
}

void RigidBodyMove::bind(const LinkStructure& structure, const string& name)
{
    const vector<LinkStructure::Molecule>& all = structure.getMolecules();
    choices.clear();
    vector<bool> isNamed(all.size(), false);
    for (int particle : molecules) {
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
    if (molecules.empty())
        for (int molecule = 0; molecule < (int)all.size(); molecule++)
            if (!all[molecule].fixed)
                choices.push_back(molecule);
    if (choices.empty())
        throw OpenMMException(name + " moves molecules, but all molecules have fixed particles");
}

void RigidBodyMove::propose(CalcStericExclusionForceKernel& kernel, RandomNumberGenerator& random)
{
    int molecule = choices[random.drawIndex(choices.size())];
    Vec3 translation = random.drawPointInBall(maxTranslation);
    Vec3 rotation = random.drawDirection() * random.drawSymmetric(maxAngle);
    kernel.proposeRigidMotion(molecule, rotation, translation);
}
