/* The energies of a BornReader. */

#include "lepton/ParsedExpression.h"
#include "openmmchaintree/internal/BornReader.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace std;
using Lepton::ExpressionTreeNode;

static const vector<string> SELF_ENERGIES = {"plain/B", "plain/B+surface/B^6", "plain/B+screened*exp(k*B)/B",
                                             "plain/B+screened*exp(k*B)/B+surface/B^6"};
static const vector<string> PAIR_ENERGIES = {
    "plain/f; f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2)))", "plain/f+plainShift; f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2)))",
    "plain/f+screened*exp(k*f)/f; f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2)))",
    "plain/f+plainShift+(screened/f+screenedShift)*exp(k*f); f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2)))"};

/** Used where the energy does not determine each of them: kJ nm / (mol e^2), nm, and kJ/mol/nm^2. */
static const double USUAL_COULOMB = 138.935485, USUAL_PROBE = 0.14, USUAL_SURFACE_ENERGY = 28.3919551;

/**
 * Find the parameter that is the charge: the energy of pairs is a multiple of the product of the charges.
 */
void BornReader::findCharges(const ExpressionTreeNode& node)
{
    for (size_t parameter = 0; parameter < model.getNames().size(); parameter++) {
        vector<double> values;
        for (int i = 0; i < numParticles; i++)
            values.push_back(model.getParameter(i, parameter));
        const double factor = findFactor(node, values);
        if (isfinite(factor) && arePairs(node, true, [&](int i, int j) {
                return factor * values[i] * values[j];
            })) {
            born.charges = values;
            return;
        }
    }
}

/**
 * Divide a coefficient of pairs by the product of charges.
 */
double BornReader::findFactor(const ExpressionTreeNode& node, const vector<double>& charges)
{
    int largest = 0;
    for (int i = 0; i < numParticles; i++)
        if (abs(charges[i]) > abs(charges[largest]))
            largest = i;
    return model.ofPair(node)(largest, largest, {}) / (charges[largest] * charges[largest]);
}

void BornReader::readPairEnergy()
{
    const char* what = "pair energy";
    map<string, string> variables = {{"r", "r"}};
    for (const char* number : {"1", "2"}) {
        variables[radiusName + number] = string("B") + number;
        variables[sumName + number] = string("I") + number;
    }
    const FormMatch match(pairEnergy, variables, PAIR_ENERGIES);
    require(match.getIndex() >= 0, what);
    requireNumbers(match, what);
    findCharges(match.get("plain"));
    require(!born.charges.empty(), what);
    auto getFactor = [&](const string& name) {
        if (!match.has(name))
            return 0.0;
        const double factor = findFactor(match.get(name), born.charges);
        require(arePairs(match.get(name), true,
                         [&](int i, int j) {
                             return factor * born.charges[i] * born.charges[j];
                         }),
                what);
        return factor;
    };
    plain = getFactor("plain");
    screened = getFactor("screened");
    born.shift = plain == 0 ? 0 : -getFactor("plainShift") / plain;
    require(areSame(getFactor("screenedShift"), -born.shift * screened), what);
    born.kappa = match.has("k") ? -getNumber(match, "k") : 0;
    readDielectrics(match.has("k"));
}

/**
 * The energy determines only products of the Coulomb constant and dielectrics.
 */
void BornReader::readDielectrics(bool isScreened)
{
    born.soluteDielectric = 1;
    if (isScreened) {
        require(plain < 0 && screened > 0, "pair energy");
        born.coulomb = USUAL_COULOMB;
        born.soluteDielectric = -born.coulomb / plain;
        born.solventDielectric = born.coulomb / screened;
        return;
    }
    born.coulomb = USUAL_COULOMB;
    born.solventDielectric = 1 / (1 + plain / born.coulomb);
    if (!(isfinite(born.solventDielectric) && born.solventDielectric > 0)) {
        born.coulomb = -2 * plain;
        born.solventDielectric = 2;
    }
    if (plain == 0)
        born.charges.assign(numParticles, 0);
}

void BornReader::readSelfEnergy()
{
    const char* what = "energy of particles";
    const map<string, string> variables = {{radiusName, "B"}, {sumName, "I"}, {"x", "x"}, {"y", "y"}, {"z", "z"}};
    const FormMatch match(selfEnergy, variables, SELF_ENERGIES);
    require(match.getIndex() >= 0, what);
    requireNumbers(match, what);
    require(areSame(born.kappa, -getNumber(match, "k")), what);
    const vector<double> ofPlain = getValues(match, "plain"), ofScreened = getValues(match, "screened");
    for (int i = 0; i < numParticles; i++) {
        const double square = born.charges[i] * born.charges[i];
        require(areSame(ofPlain[i], 0.5 * plain * square) && areSame(ofScreened[i], 0.5 * screened * square), what);
    }
    if (match.has("surface"))
        readSurface(getValues(match, "surface"));
}

/**
 * Find a and p such that the energy of each surface is a (R + p)^2 R^6. The usual value of p is tried first.
 */
void BornReader::readSurface(const vector<double>& surface)
{
    auto tryProbe = [&](double probe) {
        born.probeRadius = probe;
        born.surfaceEnergy = surface[0] / (pow(born.radii[0] + probe, 2) * pow(born.radii[0], 6));
        for (int i = 0; i < numParticles; i++)
            if (!areSame(surface[i], born.surfaceEnergy * pow(born.radii[i] + probe, 2) * pow(born.radii[i], 6)))
                return false;
        return true;
    };
    if (!born.rescaled) {
        findRadii(surface);
        require(tryProbe(USUAL_PROBE), "surface");
        return;
    }
    if (tryProbe(USUAL_PROBE))
        return;
    const auto ends = minmax_element(born.radii.begin(), born.radii.end());
    const int i = ends.first - born.radii.begin(), j = ends.second - born.radii.begin();
    const double a = sqrt(abs(surface[i]) / pow(born.radii[i], 6)), b = sqrt(abs(surface[j]) / pow(born.radii[j], 6));
    require(tryProbe((a * born.radii[j] - b * born.radii[i]) / (b - a)), "surface");
}

/**
 * If only energies of surfaces depend on whole radii, find the radii that give these energies.
 */
void BornReader::findRadii(const vector<double>& surface)
{
    for (int i = 0; i < numParticles; i++) {
        const double target = surface[i] / USUAL_SURFACE_ENERGY;
        require(target > 0, "surface");
        double& R = born.radii[i];
        for (int step = 0; step < 100; step++) {
            const double value = pow(R + USUAL_PROBE, 2) * pow(R, 6);
            R *= exp(-log(value / target) / (6 + 2 * R / (R + USUAL_PROBE)));
        }
    }
}
