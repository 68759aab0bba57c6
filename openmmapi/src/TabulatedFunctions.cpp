#include "openmmchaintree/internal/TabulatedFunctions.h"
#include "openmm/internal/SplineFitter.h"
#include "openmm/reference/ReferenceTabulatedFunction.h"
#include <vector>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

int ChainTreePlugin::countArguments(const TabulatedFunction& function)
{
    if (dynamic_cast<const Continuous1DFunction*>(&function) != NULL ||
        dynamic_cast<const Discrete1DFunction*>(&function) != NULL)
        return 1;
    if (dynamic_cast<const Continuous2DFunction*>(&function) != NULL ||
        dynamic_cast<const Discrete2DFunction*>(&function) != NULL)
        return 2;
    return 3;
}

unique_ptr<Lepton::CustomFunction> ChainTreePlugin::createFunction(const TabulatedFunction& function)
{
    return unique_ptr<Lepton::CustomFunction>(createReferenceTabulatedFunction(function));
}

// ---- Copies ----

/**
 * Assign a function to its copy if both are of class Table.
 */
template <class Table>
static void assignAs(const TabulatedFunction& original, TabulatedFunction& copy)
{
    const Table* table = dynamic_cast<const Table*>(&original);
    if (table != NULL)
        dynamic_cast<Table&>(copy) = *table;
}

void ChainTreePlugin::restorePeriod(const TabulatedFunction& original, TabulatedFunction& copy)
{
    assignAs<Continuous1DFunction>(original, copy);
    assignAs<Continuous2DFunction>(original, copy);
    assignAs<Continuous3DFunction>(original, copy);
}

// ---- Discrete tables ----

static bool translateDiscrete(const TabulatedFunction& function, EnergyTerms::TableFunction& table)
{
    table.sizes = {1, 1, 1};
    if (auto discrete = dynamic_cast<const Discrete1DFunction*>(&function)) {
        discrete->getFunctionParameters(table.values);
        table.sizes[0] = table.values.size();
    }
    else if (auto discrete = dynamic_cast<const Discrete2DFunction*>(&function))
        discrete->getFunctionParameters(table.sizes[0], table.sizes[1], table.values);
    else if (auto discrete = dynamic_cast<const Discrete3DFunction*>(&function))
        discrete->getFunctionParameters(table.sizes[0], table.sizes[1], table.sizes[2], table.values);
    else
        return false;
    table.discrete = true;
    return true;
}

// ---- Splines ----

/**
 * Get the points of a spline, rounded as in OpenMM.
 */
static vector<double> getPoints(double minimum, double maximum, int size)
{
    vector<double> points(size);
    for (int i = 0; i < size; i++)
        points[i] = minimum + i * (maximum - minimum) / (size - 1);
    return points;
}

/**
 * Write the cubic polynomials of a spline of one number.
 */
static void fit(const vector<double>& y, EnergyTerms::TableFunction& table)
{
    const vector<double> x = getPoints(table.minima[0], table.maxima[0], y.size());
    vector<double> curvatures;
    SplineFitter::createSpline(x, y, table.periodic, curvatures);
    for (size_t i = 0; i + 1 < y.size(); i++) {
        const double step = x[i + 1] - x[i], scale = step * step / 6;
        const double c0 = scale * curvatures[i], c1 = scale * curvatures[i + 1];
        table.values.insert(table.values.end(), {y[i], y[i + 1] - y[i] - 2 * c0 - c1, 3 * c0, c1 - c0});
    }
    table.sizes = {(int)y.size() - 1, 1, 1};
}

/**
 * The same for a spline of two numbers.
 */
static void fit(int sizeX, int sizeY, const vector<double>& values, EnergyTerms::TableFunction& table)
{
    vector<vector<double>> patches;
    SplineFitter::create2DSpline(getPoints(table.minima[0], table.maxima[0], sizeX),
                                 getPoints(table.minima[1], table.maxima[1], sizeY), values, table.periodic, patches);
    for (const vector<double>& patch : patches)
        table.values.insert(table.values.end(), patch.begin(), patch.end());
    table.sizes = {sizeX - 1, sizeY - 1, 1};
}

bool ChainTreePlugin::translateTable(const TabulatedFunction& function, EnergyTerms::TableFunction& table)
{
    table = EnergyTerms::TableFunction();
    table.dimensions = countArguments(function);
    if (translateDiscrete(function, table))
        return true;
    table.periodic = function.getPeriodic();
    vector<double> values;
    if (auto spline = dynamic_cast<const Continuous1DFunction*>(&function)) {
        spline->getFunctionParameters(values, table.minima[0], table.maxima[0]);
        fit(values, table);
        return true;
    }
    if (auto spline = dynamic_cast<const Continuous2DFunction*>(&function)) {
        int sizeX, sizeY;
        spline->getFunctionParameters(sizeX, sizeY, values, table.minima[0], table.maxima[0], table.minima[1],
                                      table.maxima[1]);
        fit(sizeX, sizeY, values, table);
        return true;
    }
    return false;
}
