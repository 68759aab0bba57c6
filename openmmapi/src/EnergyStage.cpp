#include "openmmchaintree/internal/EnergyStage.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
#include <cmath>

using namespace ChainTreePlugin;
using namespace std;

EnergyStages::EnergyStages() : numAsked(0)
{
}

void EnergyStages::add(unique_ptr<EnergyStage> stage)
{
    entries.push_back({std::move(stage), false, {0, 0}});
}

void EnergyStages::resetStatistics()
{
    for (Entry& entry : entries)
        entry.statistics = {0, 0};
}

vector<EnergyStages::Statistics> EnergyStages::getAllStatistics() const
{
    vector<Statistics> statistics;
    for (const Entry& entry : entries)
        statistics.push_back(entry.statistics);
    return statistics;
}

void EnergyStages::setAllStatistics(const vector<Statistics>& statistics)
{
    for (size_t i = 0; i < entries.size(); i++)
        entries[i].statistics = statistics[i];
}

void EnergyStages::begin(TrialSession& trials)
{
    for (Entry& entry : entries)
        entry.takesPart = entry.stage->begin(trials);
}

/**
 * Get the logarithm of the factor exp(-energyChange / kT).
 */
static double toLogRatio(double energyChange, double temperature)
{
    return energyChange == 0 ? 0 : -energyChange / (BOLTZ * temperature);
}

/**
 * Decide by the Metropolis criterion. A number is drawn only if it matters.
 */
static bool isAccepted(double logRatio, RandomNumberGenerator& random)
{
    return logRatio >= 0 || random.drawUniform() < exp(logRatio);
}

bool EnergyStages::decide(TrialSession& trials, double logRatio, double temperature, Rule rule,
                          RandomNumberGenerator& random)
{
    return rule == DecideOneByOne && temperature > 0 ? decideOneByOne(trials, logRatio, temperature, random)
                                                     : decideBySum(trials, logRatio, temperature, random);
}

bool EnergyStages::decideBySum(TrialSession& trials, double logRatio, double temperature, RandomNumberGenerator& random)
{
    double sum = 0;
    for (numAsked = 0; numAsked < entries.size() && !std::isnan(sum); numAsked++) {
        Entry& entry = entries[numAsked];
        if (entry.takesPart) {
            sum += entry.stage->computeEnergyChange(trials);
            entry.statistics.computed++;
        }
    }
    return !std::isnan(sum) && isAccepted(logRatio + toLogRatio(sum, temperature), random);
}

bool EnergyStages::decideOneByOne(TrialSession& trials, double logRatio, double temperature,
                                  RandomNumberGenerator& random)
{
    bool isFirst = true;
    for (numAsked = 0; numAsked < entries.size();) {
        Entry& entry = entries[numAsked];
        if (entry.takesPart && isFirst && !entry.stage->isAntisymmetric()) {
            if (!isAccepted(logRatio, random))
                return false;
            isFirst = false;
        }
        numAsked++;
        if (!entry.takesPart)
            continue;
        const double drawn = random.drawUniform();
        const double change = entry.stage->computeEnergyChange(trials);
        const double stageLogRatio = toLogRatio(change + entry.stage->getCorrection(), temperature);
        entry.statistics.computed++;
        if (!(drawn < exp(isFirst ? logRatio + stageLogRatio : stageLogRatio))) // also if it is not a number
            return false;
        isFirst = false;
    }
    return !isFirst || isAccepted(logRatio, random);
}

void EnergyStages::accept()
{
    for (Entry& entry : entries)
        if (entry.takesPart)
            entry.stage->accept();
}

void EnergyStages::reject()
{
    Entry* last = NULL;
    for (size_t i = 0; i < numAsked; i++)
        if (entries[i].takesPart) {
            entries[i].stage->reject();
            last = &entries[i];
        }
    if (last != NULL)
        last->statistics.rejected++;
}

void EnergyStages::save()
{
    for (Entry& entry : entries)
        if (entry.takesPart)
            entry.stage->save();
}

void EnergyStages::restore()
{
    for (Entry& entry : entries)
        if (entry.takesPart)
            entry.stage->restore();
}
