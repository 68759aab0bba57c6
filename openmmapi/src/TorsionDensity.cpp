#include "openmmchaintree/TorsionDensity.h"
#include "ctdensity.h"
#include "openmm/OpenMMException.h"
#include <climits>
#include <cmath>
#include <new>
#include <sstream>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static_assert(TorsionDensity::MaxTorsions == CT_DENSITY_MOST, "the library and the API allow as many torsions");

/**
 * The arguments that created a density, and the library's density.
 */
class TorsionDensity::Contents {
public:
    struct Destroy {
        void operator()(ctDensity* density) const
        {
            ctDestroyDensity(density);
        }
    };
    int numTorsions;
    bool isTable;
    double floor;
    vector<int> numBins;
    /** Of a table, the values; of rotamers, the weights. */
    vector<double> weights;
    vector<double> means, widths;
    unique_ptr<ctDensity, Destroy> density;
};

// ---- Checks ----

static void fail(const string& message)
{
    throw OpenMMException("TorsionDensity: " + message);
}

/**
 * Throw an exception unless a number lies in an interval. NaN lies in none.
 */
static void checkBetween(double value, double least, double most, const string& name, const string& range)
{
    if (value >= least && value <= most)
        return;
    stringstream message;
    message << name << " must be " << range << ", but is " << value;
    fail(message.str());
}

/**
 * Throw an exception unless numbers are finite, at least 0, and have a finite sum above 0.
 */
static void checkWeights(const vector<double>& weights, const string& name)
{
    double sum = 0;
    for (double weight : weights) {
        checkBetween(weight, 0, HUGE_VAL, name, "at least 0");
        sum += weight;
    }
    if (!(sum > 0) || !isfinite(sum))
        fail("the sum of all " + name.substr(name.find(' ') + 1) + "s must be finite and above 0");
}

static void checkNumTorsions(size_t count)
{
    if (count < 1 || count > TorsionDensity::MaxTorsions)
        fail("a density must be of 1 to " + to_string(TorsionDensity::MaxTorsions) + " torsions, but is of " +
             to_string(count));
}

// ---- Creation ----

TorsionDensity::TorsionDensity(const shared_ptr<const Contents>& contents) : contents(contents)
{
    if (contents->density == NULL)
        throw bad_alloc();
}

TorsionDensity TorsionDensity::fromTable(const vector<int>& numBins, const vector<double>& values, double floor)
{
    checkNumTorsions(numBins.size());
    long long count = 1;
    for (int bins : numBins) {
        if (bins < 1)
            fail("the number of bins must be at least 1, but is " + to_string(bins));
        count *= bins;
        if (count > INT_MAX)
            fail("a table has too many bins");
    }
    if ((size_t)count != values.size())
        fail("a table of " + to_string(count) + " bins has " + to_string(values.size()) + " values");
    checkWeights(values, "a value");
    checkBetween(floor, 0, 1, "the floor", "from 0 to 1");
    for (double value : values)
        if (value == 0 && floor == 0)
            fail("a value is 0, so that torsions there would never move; give the table a floor, the "
                 "share of draws that are uniform");
    auto contents = make_shared<Contents>();
    contents->numTorsions = numBins.size();
    contents->isTable = true;
    contents->floor = floor;
    contents->numBins = numBins;
    contents->weights = values;
    contents->density.reset(ctCreateTable(numBins.size(), numBins.data(), values.data(), floor));
    return TorsionDensity(contents);
}

TorsionDensity TorsionDensity::fromRotamers(const vector<double>& weights, const vector<double>& means,
                                            const vector<double>& widths, double floor)
{
    if (weights.empty() || weights.size() > INT_MAX)
        fail("there must be at least one rotamer");
    if (means.size() % weights.size() != 0)
        fail(to_string(means.size()) + " means cannot be divided among " + to_string(weights.size()) + " rotamers");
    const size_t numTorsions = means.size() / weights.size();
    checkNumTorsions(numTorsions);
    if (widths.size() != means.size())
        fail("there are " + to_string(means.size()) + " means, but " + to_string(widths.size()) + " widths");
    checkWeights(weights, "a weight");
    const double rounding = 1e-9; // of a half turn that was computed
    for (double mean : means)
        checkBetween(mean, -M_PI - rounding, M_PI + rounding, "a mean", "from -pi to pi radians");
    for (double width : widths) {
        checkBetween(width, 0, M_PI + rounding, "a width", "above 0 and at most pi radians");
        if (width < 1e-9)
            fail("a width must be above 0");
    }
    checkBetween(floor, 0, 1, "the floor", "above 0 and at most 1");
    if (floor == 0)
        fail("the floor of rotamers must be above 0: between them the density would be 0, and torsions there would "
             "never move");
    auto contents = make_shared<Contents>();
    contents->numTorsions = numTorsions;
    contents->isTable = false;
    contents->floor = floor;
    contents->weights = weights;
    contents->means = means;
    contents->widths = widths;
    contents->density.reset(
        ctCreateRotamers(numTorsions, weights.size(), weights.data(), means.data(), widths.data(), floor));
    return TorsionDensity(contents);
}

// ---- Access ----

int TorsionDensity::getNumTorsions() const
{
    return contents->numTorsions;
}

bool TorsionDensity::isTable() const
{
    return contents->isTable;
}

double TorsionDensity::getFloor() const
{
    return contents->floor;
}

void TorsionDensity::getTable(vector<int>& numBins, vector<double>& values) const
{
    if (!contents->isTable)
        fail("it is a sum of rotamers, not a table");
    numBins = contents->numBins;
    values = contents->weights;
}

void TorsionDensity::getRotamers(vector<double>& weights, vector<double>& means, vector<double>& widths) const
{
    if (contents->isTable)
        fail("it is a table, not a sum of rotamers");
    weights = contents->weights;
    means = contents->means;
    widths = contents->widths;
}

double TorsionDensity::evaluate(const vector<double>& angles) const
{
    if (angles.size() != (size_t)contents->numTorsions)
        fail("it is of " + to_string(contents->numTorsions) + " torsions, but was given " + to_string(angles.size()) +
             " angles");
    vector<double> wrapped;
    for (double angle : angles) {
        if (!isfinite(angle))
            fail("an angle is not finite");
        wrapped.push_back(remainder(angle, 2 * M_PI));
    }
    return ctGetDensity(contents->density.get(), wrapped.data());
}

bool TorsionDensity::operator==(const TorsionDensity& other) const
{
    const Contents &a = *contents, &b = *other.contents;
    return &a == &b || (a.isTable == b.isTable && a.floor == b.floor && a.numBins == b.numBins &&
                        a.weights == b.weights && a.means == b.means && a.widths == b.widths);
}

const ctDensity* TorsionDensity::getEngine() const
{
    return contents->density.get();
}
