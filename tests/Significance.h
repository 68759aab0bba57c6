#ifndef OPENMM_CHAINTREE_SIGNIFICANCE_H_
#define OPENMM_CHAINTREE_SIGNIFICANCE_H_

/**
 * How likely it is that chance alone makes two things differ as much as they do.
 */

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * The chance that a chi-squared variable is larger than a value (the regularized incomplete gamma function, by its
 * series or its continued fraction).
 */
inline double getChiSquaredTail(double value, double degreesOfFreedom)
{
    const double a = degreesOfFreedom / 2, x = value / 2;
    if (x <= 0)
        return 1;
    const double scale = std::exp(a * std::log(x) - x - std::lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (double n = a + 1; term > 1e-16 * sum; n++)
            sum += term *= x / n;
        return std::max(0.0, 1 - scale * sum);
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int i = 1; i < 10000; i++) {
        const double an = -i * (i - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (std::fabs(d * c - 1) < 1e-15)
            break;
    }
    return scale * h;
}

/**
 * The significance of counts that should be equally likely (Pearson).
 */
inline double testEquallyLikely(const std::vector<int>& counts)
{
    double total = 0, chiSquared = 0;
    for (int count : counts)
        total += count;
    const double expected = total / counts.size();
    for (int count : counts)
        chiSquared += (count - expected) * (count - expected) / expected;
    return getChiSquaredTail(chiSquared, counts.size() - 1);
}

/**
 * The significance of the difference between two sets of counts. Rare classes are merged.
 */
inline double testSameCounts(const std::vector<int>& counts1, const std::vector<int>& counts2)
{
    std::vector<std::pair<double, double>> classes;
    double rare1 = 0, rare2 = 0, total1 = 0, total2 = 0;
    for (size_t i = 0; i < counts1.size(); i++) {
        total1 += counts1[i];
        total2 += counts2[i];
        if (counts1[i] + counts2[i] >= 20)
            classes.push_back({counts1[i], counts2[i]});
        else {
            rare1 += counts1[i];
            rare2 += counts2[i];
        }
    }
    if (rare1 + rare2 > 0)
        classes.push_back({rare1, rare2});
    const double ratio = std::sqrt(total2 / total1);
    double chiSquared = 0;
    for (auto& c : classes)
        chiSquared += std::pow(ratio * c.first - c.second / ratio, 2) / (c.first + c.second);
    return classes.size() < 2 ? 1 : getChiSquaredTail(chiSquared, classes.size() - 1);
}

/**
 * The significance of two samples of one distribution (Kolmogorov and Smirnov).
 */
inline double testSameDistribution(std::vector<double> sample1, std::vector<double> sample2)
{
    std::sort(sample1.begin(), sample1.end());
    std::sort(sample2.begin(), sample2.end());
    const double size1 = sample1.size(), size2 = sample2.size();
    double largest = 0;
    for (size_t i = 0, j = 0; i < sample1.size() && j < sample2.size();) {
        if (sample1[i] <= sample2[j])
            i++;
        else
            j++;
        largest = std::max(largest, std::fabs(i / size1 - j / size2));
    }
    const double root = std::sqrt(size1 * size2 / (size1 + size2));
    const double lambda = (root + 0.12 + 0.11 / root) * largest;
    double sum = 0;
    for (int k = 1; k <= 100; k++)
        sum += (k % 2 == 1 ? 2 : -2) * std::exp(-2 * k * k * lambda * lambda);
    return lambda < 0.2 ? 1 : std::min(1.0, std::max(0.0, sum));
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_SIGNIFICANCE_H_*/
