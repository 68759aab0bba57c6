#include "openmmchaintree/internal/BornFormula.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace std;

double BornFormula::computePairSum(int i, int j, double r) const
{
    const double o = born.offsetRadii[i], s = born.scaledRadii[j];
    double sum = 0;
    if (r + s >= o) {
        const double upper = r + s, lower = max(o, abs(r - s));
        sum = 0.5 * (1 / lower - 1 / upper + 0.25 * (r - s * s / r) * (1 / (upper * upper) - 1 / (lower * lower)) +
                     0.5 * log(lower / upper) / r);
    }
    if (born.filled && o < s - r)
        sum += 1 / o - 1 / (s - r);
    if (born.numNeckTypes > 0 && r <= born.radii[i] + born.radii[j] + born.neckCut) {
        const int types = born.neckTypes[i] + born.numNeckTypes * born.neckTypes[j];
        const double square = pow(r - born.neckDistances[types], 2);
        sum += born.neckScale * born.neckHeights[types] / (1 + 100 * square + 0.3e6 * square * square * square);
    }
    return sum;
}

double BornFormula::computeRadius(int i, double sum) const
{
    const double o = born.offsetRadii[i];
    if (!born.rescaled)
        return 1 / (1 / o - sum);
    const double p = sum * o;
    return 1 / (1 / o - tanh(((born.gammas[i] * p - born.betas[i]) * p + born.alphas[i]) * p) / born.radii[i]);
}

double BornFormula::screen(double distance) const
{
    return born.coulomb * (1 / born.soluteDielectric - exp(-born.kappa * distance) / born.solventDielectric);
}

double BornFormula::computeSelfEnergy(int i, double B) const
{
    const double R = born.radii[i];
    return -0.5 * screen(B) * born.charges[i] * born.charges[i] / B +
           born.surfaceEnergy * pow(R + born.probeRadius, 2) * pow(R / B, 6);
}

double BornFormula::computePairEnergy(int i, int j, double r, double B1, double B2) const
{
    const double f = sqrt(r * r + B1 * B2 * exp(-r * r / (4 * B1 * B2)));
    return -screen(f) * born.charges[i] * born.charges[j] * (1 / f - born.shift);
}
