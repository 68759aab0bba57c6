#include "openmmchaintree/internal/EnergyStage.h"
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

void EnergyStages::begin(TrialSession& trials)
{
    for (Entry& entry : entries)
        entry.takesPart = entry.stage->begin(trials);
}

double EnergyStages::computeChange(TrialSession& trials)
{
    double sum = 0;
    for (numAsked = 0; numAsked < entries.size() && !std::isnan(sum); numAsked++) {
        Entry& entry = entries[numAsked];
        if (entry.takesPart) {
            sum += entry.stage->computeChange(trials);
            entry.statistics.computed++;
        }
    }
    return sum;
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
