#ifndef OPENMM_TORSIONDENSITY_H_
#define OPENMM_TORSIONDENSITY_H_

#include "internal/windowsExportChainTree.h"
#include <memory>
#include <vector>

struct ctDensity;

namespace ChainTreePlugin {

/**
 * A probability density of the values of one torsion, or of several together, from which
 * TorsionMonteCarloIntegrator::addDrawnMove() draws them. There are two kinds: a table on a periodic grid, as of phi
 * and psi, and a sum of rotamers, as of all torsions of a side chain. To create one, call fromTable() or
 * fromRotamers(); it cannot be changed. Copies share their numbers.
 *
 * A density has to be above 0 everywhere, since a move that is accepted by the ratio of two densities could never leave
 * a state where it is 0. Therefore a share of the draws, the floor, is uniform. A larger floor wastes more draws, but a
 * torsion leaves a place of low density sooner. The density affects how many trials are accepted, not the sampled
 * distribution.
 */
class OPENMM_EXPORT_CHAINTREE TorsionDensity {
public:
    /**
     * The most torsions of a density.
     */
    static const int MaxTorsions = 8;
    /**
     * Create a density that is constant in each bin of a grid, which cuts the circle of each torsion into bins of equal
     * width. The first bin of each begins at -pi.
     *
     * @param numBins  the number of bins of each torsion
     * @param values   a number for each bin, proportional to the density in it, the bins of the last torsion running
     *                 fastest. Without a floor each has to be above 0, with one at least 0.
     * @param floor    the share of draws that are uniform, from 0 to 1
     */
    static TorsionDensity fromTable(const std::vector<int>& numBins, const std::vector<double>& values,
                                    double floor = 0);
    /**
     * Create a density that is a sum of rotamers. Each of them is drawn as often as its weight says, and then each of
     * its torsions from a bell about its mean: a cubic B-spline, wrapped around the circle, which differs from a normal
     * density of the same standard deviation by 4% of its height at most, and ends after 3.46 deviations.
     *
     * @param weights  how often each rotamer is drawn, relative to the others
     * @param means    the mean of each torsion in the first rotamer, then those in the second, and so on, from -pi to
     *                 pi, in radians
     * @param widths   the standard deviations in the same order, above 0 and at most pi, in radians
     * @param floor    the share of draws of each torsion that are uniform for any rotamer, above 0 and at most 1
     */
    static TorsionDensity fromRotamers(const std::vector<double>& weights, const std::vector<double>& means,
                                       const std::vector<double>& widths, double floor);
    /**
     * Get the number of torsions.
     */
    int getNumTorsions() const;
    /**
     * Get whether this was created by fromTable().
     */
    bool isTable() const;
    /**
     * Get the share of draws that are uniform.
     */
    double getFloor() const;
    /**
     * Get the arguments of fromTable(). It is an error if this is a sum of rotamers.
     *
     * @param[out] numBins  the number of bins of each torsion
     * @param[out] values   a number for each bin
     */
    void getTable(std::vector<int>& numBins, std::vector<double>& values) const;
    /**
     * Get the arguments of fromRotamers(). It is an error if this is a table.
     *
     * @param[out] weights  how often each rotamer is drawn
     * @param[out] means    the mean of each torsion in each rotamer, in radians
     * @param[out] widths   the standard deviations, in radians
     */
    void getRotamers(std::vector<double>& weights, std::vector<double>& means, std::vector<double>& widths) const;
    /**
     * Get the density of values of the torsions. Its integral over all of them is 1.
     *
     * @param angles  a value for each torsion, in radians
     * @return the density, in 1/radian to the power of the number of torsions
     */
    double evaluate(const std::vector<double>& angles) const;
    /**
     * Get whether two densities were created by the same numbers.
     */
    bool operator==(const TorsionDensity& other) const;
#ifndef SWIG
    /**
     * Get the library's density, which draws and evaluates. It lives as long as any copy of this object.
     */
    const ctDensity* getEngine() const;
#endif

private:
    class Contents;
    explicit TorsionDensity(const std::shared_ptr<const Contents>& contents);
    std::shared_ptr<const Contents> contents;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_TORSIONDENSITY_H_*/
