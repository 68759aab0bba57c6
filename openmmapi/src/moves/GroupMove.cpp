#include "openmmchaintree/internal/MoleculeChoices.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include <algorithm>
#include <cmath>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

#define GROUP_MOVE(P)                                                                                                  \
    P(Length, maxTranslation, "largest translation")                                                                   \
    P(Angle, maxAngle, "largest angle")                                                                                \
    P(Number, maxDistance, "largest distance of neighbors", "nm")                                                      \
    P(Indices, molecules, "all without fixed particles")

MOVE_PARAMETERS(GroupMove, GROUP_MOVE)

/** In nm. Places farther apart are different: they differ by vectors of the periodic box. */
static const double SAME_PLACE = 1e-4;

namespace {

/**
 * The molecules that are linked to one, directly or by others.
 */
class Group {
public:
    /** The members, by their indices among the choices of the move, in the order in which they were found. */
    vector<int> members;
    /** Whether each of the choices is a member. */
    vector<bool> isMember;
    /** For each of the choices that is a member, the periodic image of its centroid that is next to the others. */
    vector<Vec3> places;
    /** Whether the group is linked to an image of itself, so that it cannot turn. */
    bool spansBox;
};

/**
 * Moves the molecules of a group as one rigid body. See TorsionMonteCarloIntegrator::addGroupMove().
 */
class GroupMove : public DeclaredMove<GroupMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    string getSubject() const;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);

private:
    Vec3 findWay(const Vec3& from, const Vec3& to, const BoxVectors& box) const;
    void findGroup(int first, double distance, const BoxVectors& box, Group& group) const;
    bool isSameGroup() const;
    /** The molecules to choose from, by their indices in the LinkStructure. */
    vector<int> choices;
    size_t numMolecules = 0;
    bool isPeriodic = false;
    /** The centroids of all choices. */
    vector<Vec3> centroids;
    /** The group in the present state and in the proposed one. */
    Group group, proposedGroup;
};

} // namespace

string GroupMove::getSubject() const
{
    stringstream subject;
    subject.imbue(locale::classic());
    subject << getKind().name << " within " << maxDistance << " nm";
    return subject.str();
}

void GroupMove::bind(const LinkStructure& structure, const string& name)
{
    choices = chooseMolecules(structure, molecules, name);
    numMolecules = structure.getMolecules().size();
    isPeriodic = structure.isPeriodic();
    centroids.resize(choices.size());
}

/**
 * Get the way from one place to the nearest image of another.
 */
Vec3 GroupMove::findWay(const Vec3& from, const Vec3& to, const BoxVectors& box) const
{
    Vec3 way = to - from;
    for (int k = 2; k >= 0 && isPeriodic; k--)
        way -= box[k] * floor(way[k] / box[k][k] + 0.5);
    return way;
}

/**
 * Find the group of one of the choices from the centroids.
 *
 * @param distance  molecules are linked if their centroids are closer
 */
void GroupMove::findGroup(int first, double distance, const BoxVectors& box, Group& found) const
{
    found.members.assign(1, first);
    found.isMember.assign(choices.size(), false);
    found.isMember[first] = true;
    found.places.resize(choices.size());
    found.places[first] = centroids[first];
    found.spansBox = false;
    for (size_t i = 0; i < found.members.size(); i++) {
        const int member = found.members[i];
        for (int other = 0; other < (int)choices.size(); other++) {
            const Vec3 way = findWay(centroids[member], centroids[other], box);
            if (other == member || way.dot(way) >= distance * distance)
                continue;
            const Vec3 place = found.places[member] + way, difference = place - found.places[other];
            if (found.isMember[other]) {
                found.spansBox |= difference.dot(difference) > SAME_PLACE * SAME_PLACE;
                continue;
            }
            found.isMember[other] = true;
            found.places[other] = place;
            found.members.push_back(other);
        }
    }
}

/**
 * Get whether the proposed centroids have the group of the present ones, moved.
 */
bool GroupMove::isSameGroup() const
{
    if (proposedGroup.isMember != group.isMember || proposedGroup.spansBox != group.spansBox)
        return false;
    return group.spansBox || all_of(group.members.begin(), group.members.end(), [this](int member) {
               const Vec3 difference = proposedGroup.places[member] - group.places[member];
               return difference.dot(difference) <= SAME_PLACE * SAME_PLACE;
           });
}

/**
 * Turn a vector about a direction.
 */
static Vec3 turn(const Vec3& vector, const Vec3& direction, double angle)
{
    return vector * cos(angle) + direction.cross(vector) * sin(angle) +
           direction * (direction.dot(vector) * (1 - cos(angle)));
}

bool GroupMove::draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
{
    const BoxVectors& box = trials.getBox();
    for (size_t i = 0; i < choices.size(); i++)
        centroids[i] = trials.getCentroid(choices[i]);
    const int first = random.drawIndex(choices.size());
    const double distance = maxDistance * random.drawUniform();
    findGroup(first, distance, box, group);
    if (isPeriodic && group.members.size() == numMolecules)
        return false; // nothing would move relative to anything else
    const Vec3 translation = random.drawPointInBall(getScale() * maxTranslation), direction = random.drawDirection();
    const double drawnAngle = random.drawSymmetric(getScale() * maxAngle), angle = group.spansBox ? 0 : drawnAngle;
    Vec3 middle;
    for (int member : group.members)
        middle += group.places[member] / group.members.size();
    for (int member : group.members) {
        const Vec3 arm = group.places[member] - middle;
        const Vec3 shift = turn(arm, direction, angle) - arm + translation;
        proposal.addRigidMotion(choices[member], direction * angle, shift);
        centroids[member] = group.places[member] += shift;
    }

    // The reverse trial must find the same group.

    findGroup(first, distance, box, proposedGroup);
    return isSameGroup();
}

MOVE("group", GroupMove, GROUP_MOVE)
