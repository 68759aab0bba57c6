#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/AtomGroups.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include <algorithm>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define ATOM_MOVE(P)                                                                                                   \
    P(Length, maxDisplacement, "largest displacement")                                                                 \
    P(Indices, particles, "all that can move, in molecules with a radius or a joint")                                  \
    P(Flag, withHydrogens, "whether hydrogens follow")

MOVE_PARAMETERS(AtomMove, ATOM_MOVE)

namespace {

/** An accepted trial takes seven times as long as a rejected one, most of which end at the bonded terms. In villin with
 *  GBn2, lengths and angles had 1.3 to 1.6 times as many independent values a second as with an acceptance of 0.4. */
const double AIM = 0.25;

/**
 * Displaces a particle, and what has to move with it. See TorsionMonteCarloIntegrator::addAtomMove().
 */
class AtomMove : public DeclaredMove<AtomMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    string getSubject() const;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);
    bool displacesParticles() const
    {
        return true;
    }
    size_t getSizeClass() const
    {
        return choices[drawn].sizeClass;
    }
    double getAim() const
    {
        return AIM;
    }

private:
    void followSite(const VirtualPlace& site, const Vec3& shift, const TrialSession& trials, Proposal& proposal);
    class Choice {
    public:
        AtomGroups::Group group;
        size_t sizeClass;
    };
    vector<Choice> choices;
    /** The choice of the last trial. */
    size_t drawn = 0;
    // Memory.
    vector<int> siteParticles;
    vector<Vec3> positions;
};

} // namespace

string AtomMove::getSubject() const
{
    return getKind().name + (withHydrogens ? " with its hydrogens" : "");
}

void AtomMove::bind(const LinkStructure& structure, const string& name)
{
    for (int particle : particles)
        checkIndex(particle, structure.getParticleLinks().size(), "particle", name);
    if (!structure.isFlexible())
        throw OpenMMException(name + " displaces particles within their links, but the Context was made when no move "
                                     "did, so that its links are rigid; reinitialize the Context");
    checkUnique(particles, name + " names particle ");
    const AtomGroups& groups = structure.getAtomGroups();
    vector<Choice> found;
    vector<pair<int, int>> classes;
    for (int particle : groups.findFirstOfUnits(particles.empty() ? groups.findDefaults() : particles)) {
        found.push_back({groups.makeGroup(particle, withHydrogens, name), 0});
        classes.push_back(found.back().group.stiffness);
    }
    if (found.empty())
        throw OpenMMException(name +
                              " displaces particles, but all are fixed, or in molecules without a radius or a joint");
    sort(classes.begin(), classes.end());
    classes.erase(unique(classes.begin(), classes.end()), classes.end());
    setNumSizeClasses(classes.size(), name);
    for (Choice& choice : found)
        choice.sizeClass = lower_bound(classes.begin(), classes.end(), choice.group.stiffness) - classes.begin();
    choices = std::move(found);
    drawn = 0;
}

/**
 * Add the displacement of a virtual site, which depends on others of its particles, too.
 */
void AtomMove::followSite(const VirtualPlace& site, const Vec3& shift, const TrialSession& trials, Proposal& proposal)
{
    const vector<int>& moved = choices[drawn].group.particles;
    siteParticles = site.getParticles();
    siteParticles.push_back(site.getSite());
    trials.getPositions(siteParticles, positions);
    for (size_t i = 0; i + 1 < siteParticles.size(); i++)
        if (find(moved.begin(), moved.end(), siteParticles[i]) != moved.end())
            positions[i] += shift;
    proposal.addDisplacement(site.getSite(), site.compute(positions) - positions.back());
}

bool AtomMove::draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
{
    drawn = random.drawIndex(choices.size());
    const Choice& choice = choices[drawn];
    const Vec3 shift = random.drawPointInBall(getScale(choice.sizeClass) * maxDisplacement);
    for (int particle : choice.group.particles)
        proposal.addDisplacement(particle, shift);
    for (const VirtualPlace* site : choice.group.sites)
        followSite(*site, shift, trials, proposal);
    return true;
}

MOVE("atom", AtomMove, ATOM_MOVE)
