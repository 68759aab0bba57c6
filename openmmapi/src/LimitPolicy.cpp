#include "openmmchaintree/internal/LimitPolicy.h"
#include "openmm/OpenMMException.h"
#include <limits>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const long long NO_STEP = numeric_limits<long long>::min();

LimitPolicy::LimitPolicy() :
    scene(NULL), isCurrent(false), dynamicsIsExpected(false), stepsAreAnnounced(true), stepBegun(NO_STEP)
{
}

void LimitPolicy::setScene(Scene& scene)
{
    this->scene = &scene;
}

void LimitPolicy::expectDynamics(bool announced)
{
    dynamicsIsExpected = true;
    stepsAreAnnounced = announced;
}

void LimitPolicy::stepBegins(long long stepCount)
{
    stepBegun = stepCount;
}

void LimitPolicy::particlesWereMoved()
{
    const bool mayBeDynamics = (stepBegun != NO_STEP || !stepsAreAnnounced);
    if (dynamicsIsExpected && mayBeDynamics)
        isCurrent = false;
    else
        restart();
}

void LimitPolicy::positionsWereSeen(long long stepCount)
{
    // During a step the Context has the step count with which the step began. With another count the step is over.

    if (stepCount != stepBegun)
        stepBegun = NO_STEP;
}

void LimitPolicy::noStepIsUnderWay()
{
    stepBegun = NO_STEP;
}

void LimitPolicy::overlapsWereChanged()
{
    isCurrent = false;
}

void LimitPolicy::update()
{
    if (!isCurrent) {
        scene->raiseLimits();
        isCurrent = true;
    }
}

void LimitPolicy::restart()
{
    scene->clearLimits();
    isCurrent = false;
}

void LimitPolicy::setLimits(const vector<pair<int, int>>& pairs, const vector<double>& limits)
{
    scene->setLimits(pairs, limits);
    isCurrent = false;
}

void LimitPolicy::refuseToleratedClashes()
{
    update();
    vector<pair<int, int>> pairs;
    vector<double> limits;
    scene->getLimits(pairs, limits);
    if (pairs.empty())
        return;
    stringstream message;
    message << "StericExclusionForce: particles " << pairs[0].first << " and " << pairs[0].second
            << " clash when sampling starts, by an overlap of " << limits[0] << " nm";
    if (pairs.size() > 1)
        message << "; they are the first of " << pairs.size() << " such pairs";
    throw OpenMMException(message.str());
}

// ---- Checkpoints ----

/**
 * A limit in a checkpoint.
 */
class LimitRecord {
public:
    int particle1, particle2;
    double limit;
};

void LimitPolicy::writeLimits(CheckpointWriter& writer) const
{
    vector<pair<int, int>> pairs;
    vector<double> limits;
    vector<LimitRecord> records;
    scene->getLimits(pairs, limits);
    for (size_t i = 0; i < pairs.size(); i++)
        records.push_back({pairs[i].first, pairs[i].second, limits[i]});
    writer.write(records);
    writer.write((uint8_t)isCurrent);
}

void LimitPolicy::readLimits(CheckpointReader& reader, Kept& kept)
{
    for (const LimitRecord& record : reader.readVector<LimitRecord>()) {
        kept.pairs.push_back(make_pair(record.particle1, record.particle2));
        kept.limits.push_back(record.limit);
    }
    kept.isCurrent = (reader.read<uint8_t>() != 0);
}

void LimitPolicy::writeStep(CheckpointWriter& writer) const
{
    writer.write(stepBegun);
}

void LimitPolicy::readStep(CheckpointReader& reader, Kept& kept)
{
    kept.stepBegun = reader.read<long long>();
}

void LimitPolicy::restore(const Kept& kept, bool hasPositions)
{
    if (hasPositions)
        scene->setLimits(kept.pairs, kept.limits);
    isCurrent = kept.isCurrent;
    stepBegun = kept.stepBegun;
}
