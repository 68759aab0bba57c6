#ifndef OPENMM_CHAINTREE_PLAINENERGIES_H_
#define OPENMM_CHAINTREE_PLAINENERGIES_H_

/**
 * Energies of EnergyTerms as ctenergy.h defines them, by plain sums in double.
 */

#include "openmm/Vec3.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

// ---- Tables ----

/**
 * Find the interval of a number and where it is in it. Returns false if it is outside of the table.
 */
inline bool findInterval(const EnergyTerms::TableFunction& table, int dimension, double x, int& interval, double& u)
{
    const double low = table.minima[dimension], range = table.maxima[dimension] - low;
    double t = (x - low) / range;
    if (table.periodic)
        t -= std::floor(t);
    if (!(t >= 0 && t <= 1))
        return false;
    interval = std::min((int)(t * table.sizes[dimension]), table.sizes[dimension] - 1);
    u = t * table.sizes[dimension] - interval;
    return true;
}

inline double evaluateTable(const EnergyTerms::TableFunction& table, const std::vector<double>& x)
{
    if (table.discrete) {
        int index = 0, stride = 1;
        for (int i = 0; i < table.dimensions; i++) {
            const int k = (int)std::round(x[i]);
            if (k < 0 || k >= table.sizes[i])
                return std::numeric_limits<double>::quiet_NaN();
            index += stride * k;
            stride *= table.sizes[i];
        }
        return table.values[index];
    }
    int s[2] = {};
    double u[2] = {};
    for (int i = 0; i < table.dimensions; i++)
        if (!findInterval(table, i, x[i], s[i], u[i]))
            return 0;
    double sum = 0;
    if (table.dimensions == 1)
        for (int i = 0; i < 4; i++)
            sum += table.values[4 * s[0] + i] * std::pow(u[0], i);
    else
        for (int i = 0; i < 4; i++)
            for (int j = 0; j < 4; j++)
                sum += table.values[16 * (s[0] + table.sizes[0] * s[1]) + 4 * i + j] * std::pow(u[0], i) *
                       std::pow(u[1], j);
    return sum;
}

// ---- Expressions ----

inline double evaluateOperation(const ctOperation& operation, double a, double b, double c)
{
    const double v = operation.constant;
    switch (operation.kind) {
    case ctConstantOperator:
        return v;
    case ctAddOperator:
        return a + b;
    case ctSubtractOperator:
        return a - b;
    case ctMultiplyOperator:
        return a * b;
    case ctDivideOperator:
        return a / b;
    case ctPowerOperator:
        return std::pow(a, b);
    case ctNegateOperator:
        return -a;
    case ctSqrtOperator:
        return std::sqrt(a);
    case ctExpOperator:
        return std::exp(a);
    case ctLogOperator:
        return std::log(a);
    case ctSinOperator:
        return std::sin(a);
    case ctCosOperator:
        return std::cos(a);
    case ctTanhOperator:
        return std::tanh(a);
    case ctErfOperator:
        return std::erf(a);
    case ctErfcOperator:
        return std::erfc(a);
    case ctStepOperator:
        return a < 0 ? 0 : 1;
    case ctDeltaOperator:
        return a == 0 ? 1 : 0;
    case ctSquareOperator:
        return a * a;
    case ctCubeOperator:
        return a * a * a;
    case ctReciprocalOperator:
        return 1 / a;
    case ctAddConstantOperator:
        return a + v;
    case ctMultiplyConstantOperator:
        return a * v;
    case ctPowerConstantOperator:
        return std::pow(a, v);
    case ctMinOperator:
        return std::min(a, b);
    case ctMaxOperator:
        return std::max(a, b);
    case ctAbsOperator:
        return std::fabs(a);
    case ctFloorOperator:
        return std::floor(a);
    case ctCeilOperator:
        return std::ceil(a);
    case ctSelectOperator:
        return a != 0 ? b : c;
    default:
        return std::numeric_limits<double>::quiet_NaN(); // no test of pairs has it
    }
}

inline double evaluatePair(const EnergyTerms::PairSet& set, int particle1, int particle2, double r)
{
    std::vector<double> results;
    for (const ctOperation& operation : set.operations) {
        const int size = set.parametersPerParticle, number = operation.arguments[0];
        if (operation.kind == ctInputOperator)
            results.push_back(number == 0 ? r : std::numeric_limits<double>::quiet_NaN());
        else if (operation.kind == ctParameterOperator)
            results.push_back(
                set.parameters[number < size ? particle1 * size + number : particle2 * size + number - size]);
        else {
            std::vector<double> x;
            for (int i = 0; i < 3; i++)
                x.push_back(results.empty() ? 0 : results[operation.arguments[i]]);
            results.push_back(operation.kind == ctTableOperator ? evaluateTable(set.tables[(int)operation.constant], x)
                                                                : evaluateOperation(operation, x[0], x[1], x[2]));
        }
    }
    double energy = results.back();
    if (r > set.switchingDistance) {
        const double t = (r - set.switchingDistance) / (set.cutoff - set.switchingDistance);
        energy *= 1 - 10 * std::pow(t, 3) + 15 * std::pow(t, 4) - 6 * std::pow(t, 5);
    }
    return energy;
}

inline double getDistanceOf(const std::vector<OpenMM::Vec3>& positions, int particle1, int particle2)
{
    const OpenMM::Vec3 delta = positions[particle1] - positions[particle2];
    return std::sqrt(delta.dot(delta));
}

inline double computePlainEnergy(const EnergyTerms::PairSet& set, const std::vector<OpenMM::Vec3>& positions)
{
    std::set<std::pair<int, int>> exclusions;
    for (const std::array<int, 2>& exclusion : set.exclusions)
        exclusions.insert(std::minmax(exclusion[0], exclusion[1]));
    std::vector<int> all(positions.size());
    for (size_t i = 0; i < all.size(); i++)
        all[i] = i;
    std::vector<EnergyTerms::InteractionGroup> groups = set.groups;
    if (groups.empty())
        groups.push_back({all, all});
    double energy = 0;
    for (const EnergyTerms::InteractionGroup& group : groups) {
        std::set<std::pair<int, int>> pairs;
        for (int i : group[0])
            for (int j : group[1])
                if (i != j)
                    pairs.insert(std::minmax(i, j));
        for (const std::pair<int, int>& pair : pairs) {
            const double r = getDistanceOf(positions, pair.first, pair.second);
            if (r < set.cutoff && exclusions.count(pair) == 0)
                energy += evaluatePair(set, pair.first, pair.second, r);
        }
    }
    return energy;
}

// ---- Generalized Born ----

inline double computePlainEnergy(const EnergyTerms::Born& born, const std::vector<OpenMM::Vec3>& positions)
{
    const int n = positions.size();
    std::vector<double> radii(n);
    double energy = 0;
    for (int i = 0; i < n; i++) {
        const double o = born.offsetRadii[i];
        double sum = 0;
        for (int j = 0; j < n; j++) {
            const double r = getDistanceOf(positions, i, j), s = born.scaledRadii[j];
            if (i == j || r > born.cutoff)
                continue;
            if (r + s >= o) {
                const double U = r + s, L = std::max(o, std::fabs(r - s));
                sum += 0.5 * (1 / L - 1 / U + 0.25 * (r - s * s / r) * (1 / (U * U) - 1 / (L * L)) +
                              0.5 * std::log(L / U) / r);
            }
            if (born.filled && o < s - r)
                sum += 1 / o - 1 / (s - r);
            if (born.numNeckTypes > 0 && r <= born.radii[i] + born.radii[j] + born.neckCut) {
                const int types = born.neckTypes[i] + born.numNeckTypes * born.neckTypes[j];
                const double delta = r - born.neckDistances[types];
                sum += born.neckScale * born.neckHeights[types] /
                       (1 + 100 * std::pow(delta, 2) + 0.3e6 * std::pow(delta, 6));
            }
        }
        const double p = sum * o;
        radii[i] =
            born.rescaled
                ? 1 / (1 / o - std::tanh(born.alphas[i] * p - born.betas[i] * p * p + born.gammas[i] * p * p * p) /
                                   born.radii[i])
                : 1 / (1 / o - sum);
    }
    auto screen = [&](double f) {
        return born.coulomb * (1 / born.soluteDielectric - std::exp(-born.kappa * f) / born.solventDielectric);
    };
    for (int i = 0; i < n; i++) {
        const double q = born.charges[i], B = radii[i];
        energy += -0.5 * screen(B) * q * q / B +
                  born.surfaceEnergy * std::pow(born.radii[i] + born.probeRadius, 2) * std::pow(born.radii[i] / B, 6);
        for (int j = 0; j < i; j++) {
            const double r = getDistanceOf(positions, i, j), BB = B * radii[j];
            if (r > born.cutoff)
                continue;
            const double f = std::sqrt(r * r + BB * std::exp(-r * r / (4 * BB)));
            energy -= screen(f) * q * born.charges[j] * (1 / f - born.shift);
        }
    }
    return energy;
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_PLAINENERGIES_H_*/
