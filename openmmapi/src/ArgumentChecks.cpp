#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmm/OpenMMException.h"
#include <algorithm>
#include <cmath>
#include <sstream>

using namespace OpenMM;
using namespace std;

void ChainTreePlugin::checkNotNegative(double value, const string& name)
{
    if (isfinite(value) && value >= 0)
        return;
    stringstream message;
    message << name << " must be a finite number and at least 0, but is " << value;
    throw OpenMMException(message.str());
}

void ChainTreePlugin::checkIndex(int index, int count, const string& what, const string& whose)
{
    if (index >= 0 && index < count)
        return;
    stringstream message;
    message << whose << " names " << what << " " << index << ", but there are " << count << " " << what << "s";
    throw OpenMMException(message.str());
}

void ChainTreePlugin::checkUnique(vector<int> values, const string& message)
{
    sort(values.begin(), values.end());
    auto repeated = adjacent_find(values.begin(), values.end());
    if (repeated != values.end())
        throw OpenMMException(message + to_string(*repeated) + " twice");
}

void ChainTreePlugin::checkVersion(int version, int newest, const string& what, int oldest)
{
    if (version >= oldest && version <= newest)
        return;
    stringstream message;
    message << what << " has version " << version << ", but this openmm-chaintree reads only versions " << oldest
            << " to " << newest;
    throw OpenMMException(message.str());
}
