#include "openmmchaintree/internal/SizeAdaptation.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace std;

/** The least step of the logarithm of a scale, relative to the first steps. It is not 0, because the best size may
 *  change during a run; with this value, scales vary by some 3 %. */
static const double LEAST_GAIN = 0.1;

double SizeAdaptation::countTrial(bool accepted, double scale, double aim)
{
    numAccepted += accepted ? 1 : 0;
    if (++numTrials < BLOCK)
        return scale;

    // Robbins and Monro, Ann. Math. Stat. 22, 400 (1951), in the logarithm.

    numBlocks++;
    const double gain = max(LEAST_GAIN, 1 / sqrt((double)numBlocks));
    const double excess = numAccepted / (double)numTrials - aim;
    numTrials = numAccepted = 0;
    return min(1.0, max(LEAST_SCALE, scale * exp(gain * excess)));
}
