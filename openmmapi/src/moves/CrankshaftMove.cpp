#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/JointChoices.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define CRANKSHAFT_MOVE(P)                                                                                             \
    P(Angle, maxAngle, "largest angle")                                                                                \
    P(Indices, ballJoints, "all")                                                                                      \
    P(Count, window, "largest number of bonds in a window", 2)

MOVE_PARAMETERS(CrankshaftMove, CRANKSHAFT_MOVE)

/** In nm. A window with a shorter line is never turned. No trial changes the length, so this keeps detailed balance. */
static const double SHORTEST_LINE = 1e-6;

namespace {

/**
 * Turns the piece between two ball joints about the line between them. See
 * TorsionMonteCarloIntegrator::addCrankshaftMove().
 */
class CrankshaftMove : public DeclaredMove<CrankshaftMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);

private:
    /** A ball joint at the end of windows, and the number of windows that end there. */
    class End {
    public:
        int ballJoint, numWindows;
    };
    vector<End> ends;
    /** For each ball joint the next one towards the root that may turn, or -1; and its particle. */
    vector<int> next, particles;
    /** The particles at the ends of the line, and their positions. The first is nearer to the root. */
    vector<int> axis = vector<int>(2);
    vector<Vec3> positions = vector<Vec3>(2);
};

} // namespace

void CrankshaftMove::bind(const LinkStructure& structure, const string& name)
{
    const vector<LinkStructure::Link>& links = structure.getLinks();
    const vector<int> choices = chooseBallJoints(structure, ballJoints, name);
    vector<bool> mayTurn(structure.getBallJointLinks().size(), false);
    for (int ballJoint : choices)
        mayTurn[ballJoint] = true;
    next.assign(mayTurn.size(), -1);
    particles.assign(mayTurn.size(), -1);
    for (int ballJoint : choices) {
        particles[ballJoint] = structure.getBallJointParticle(ballJoint);
        int link = links[structure.getBallJointLinks()[ballJoint]].parent;
        while (links[link].parent != -1 && (links[link].ballJoint == -1 || !mayTurn[links[link].ballJoint]))
            link = links[link].parent;
        next[ballJoint] = links[link].ballJoint;
    }
    ends.clear();
    for (int ballJoint : choices) {
        int numBonds = 0;
        for (int joint = ballJoint; next[joint] != -1 && numBonds < window; joint = next[joint])
            numBonds++;
        if (numBonds >= 2)
            ends.push_back({ballJoint, numBonds - 1});
    }
    if (ends.empty())
        throw OpenMMException(name + " turns the piece between two ball joints, but no three of its ball joints follow "
                                     "each other along a chain");
}

bool CrankshaftMove::draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
{
    const End& end = ends[random.drawIndex(ends.size())];
    int begin = end.ballJoint;
    for (int numBonds = 2 + random.drawIndex(end.numWindows); numBonds > 0; numBonds--)
        begin = next[begin];
    axis = {particles[begin], particles[end.ballJoint]};
    trials.getPositions(axis, positions);
    const Vec3 line = positions[1] - positions[0];
    const double length = sqrt(line.dot(line)), angle = random.drawSymmetric(getScale() * maxAngle);
    if (length < SHORTEST_LINE)
        return false;
    proposal.addBallRotation(begin, line * (angle / length));
    proposal.addBallRotation(end.ballJoint, line * (-angle / length));
    return true;
}

MOVE("crankshaft", CrankshaftMove, CRANKSHAFT_MOVE)
