#include "openmm/internal/NonbondedForceImpl.h"
#include "openmm/NonbondedForce.h"
#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "openmmchaintree/internal/ForceTranslation.h"
#include <cmath>
#include <limits>
#include <set>
#include <utility>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string describeMethod(NonbondedForce::NonbondedMethod method)
{
    switch (method) {
    case NonbondedForce::CutoffPeriodic:
        return "its cutoff is periodic";
    case NonbondedForce::Ewald:
        return "Ewald summation is periodic";
    case NonbondedForce::PME:
        return "PME is periodic";
    case NonbondedForce::LJPME:
        return "openmm-chaintree has no code for LJPME";
    default:
        return "openmm-chaintree does not know its nonbonded method";
    }
}

namespace {

/**
 * Charges, or products of charges, with Lennard-Jones parameters.
 */
class Values {
public:
    double charge, sigma, epsilon;
};

} // namespace

/**
 * Add the parameter offsets. Returns an empty text, or else why it cannot: with two offsets of one particle or
 * exception by one parameter, OpenMM's Platforms disagree whether to add both or keep the last.
 */
template <class GetOffset>
static string addOffsets(int numOffsets, GetOffset getOffset, const NativeForceKind::Parameters& parameters,
                         vector<Values>& values)
{
    set<pair<string, int>> known;
    for (int i = 0; i < numOffsets; i++) {
        string parameter;
        int index;
        Values scale;
        getOffset(i, parameter, index, scale);
        if (!known.insert(make_pair(parameter, index)).second)
            return "the parameter " + parameter + " appears in two offsets of one particle or exception";
        const double value = parameters.at(parameter);
        values[index].charge += value * scale.charge;
        values[index].sigma += value * scale.sigma;
        values[index].epsilon += value * scale.epsilon;
    }
    return "";
}

static string translateParticles(const NonbondedForce& force, const NativeForceKind::Parameters& parameters,
                                 EnergyTerms::Nonbonded& nonbonded)
{
    vector<Values> values(force.getNumParticles());
    for (int i = 0; i < force.getNumParticles(); i++)
        force.getParticleParameters(i, values[i].charge, values[i].sigma, values[i].epsilon);
    auto getOffset = [&](int i, string& parameter, int& particle, Values& scale) {
        force.getParticleParameterOffset(i, parameter, particle, scale.charge, scale.sigma, scale.epsilon);
    };
    const string reason = addOffsets(force.getNumParticleParameterOffsets(), getOffset, parameters, values);
    for (const Values& value : values) {
        if (value.epsilon < 0)
            return "a parameter makes the epsilon of a particle negative";
        nonbonded.charges.push_back(value.charge);
        nonbonded.sigmas.push_back(value.sigma);
        nonbonded.epsilons.push_back(value.epsilon);
    }
    return reason;
}

/**
 * Each exception excludes its pair. Exceptions with an energy are terms without a cutoff, as in OpenMM.
 */
static string translateExceptions(const NonbondedForce& force, const NativeForceKind::Parameters& parameters,
                                  EnergyTerms::Nonbonded& nonbonded, EnergyTerms::TermSet& exceptions)
{
    vector<Values> values(force.getNumExceptions());
    for (int i = 0; i < force.getNumExceptions(); i++) {
        int p1, p2;
        force.getExceptionParameters(i, p1, p2, values[i].charge, values[i].sigma, values[i].epsilon);
        nonbonded.exclusions.push_back({p1, p2});
    }
    auto getOffset = [&](int i, string& parameter, int& exception, Values& scale) {
        force.getExceptionParameterOffset(i, parameter, exception, scale.charge, scale.sigma, scale.epsilon);
    };
    const string reason = addOffsets(force.getNumExceptionParameterOffsets(), getOffset, parameters, values);
    for (size_t i = 0; i < values.size(); i++)
        if (values[i].charge != 0 || values[i].epsilon != 0)
            addTerm(exceptions, {nonbonded.exclusions[i][0], nonbonded.exclusions[i][1]},
                    {values[i].charge, values[i].sigma, values[i].epsilon});
    return reason;
}

/**
 * Get alpha of the Ewald summation that OpenMM uses.
 */
static double findEwaldAlpha(const System& system, const NonbondedForce& force)
{
    double alpha;
    int sizes[3];
    if (force.getNonbondedMethod() == NonbondedForce::Ewald)
        NonbondedForceImpl::calcEwaldParameters(system, force, alpha, sizes[0], sizes[1], sizes[2]);
    else
        NonbondedForceImpl::calcPMEParameters(system, force, alpha, sizes[0], sizes[1], sizes[2], false);
    return alpha;
}

/**
 * Translate the part of direct space that subtracts excluded pairs, which reciprocal space includes.
 */
static string translateExcludedPairs(const EnergyTerms::Nonbonded& nonbonded, EnergyTerms::TermSet& set)
{
    ExpressionTranslator translator(set);
    translator.addInput("r", {ctMeasureDistance, {0, 1}});
    translator.addParameter("charges");
    translator.addConstant("alpha", nonbonded.ewaldAlpha);
    translator.addConstant("coulomb", CT_COULOMB);
    for (const array<int, 2>& pair : nonbonded.exclusions) {
        const double charges = nonbonded.charges[pair[0]] * nonbonded.charges[pair[1]];
        if (charges != 0)
            addTerm(set, {pair[0], pair[1]}, {charges});
    }
    return translator.translate("-coulomb*charges*select(r, erf(alpha*r)/r, 2*alpha/sqrt(3.14159265358979324))");
}

static string translateNonbonded(const NonbondedForce& force, const NativeForceKind::Setting& setting,
                                 EnergyTerms& terms)
{
    const NonbondedForce::NonbondedMethod method = force.getNonbondedMethod();
    const bool isEwald = setting.isPeriodic && (method == NonbondedForce::Ewald || method == NonbondedForce::PME);
    const bool isPeriodic = isEwald || (setting.isPeriodic && method == NonbondedForce::CutoffPeriodic);
    if (method != NonbondedForce::NoCutoff && method != NonbondedForce::CutoffNonPeriodic && !isPeriodic)
        return describeMethod(method);
    if (force.getExceptionsUsePeriodicBoundaryConditions() && !isPeriodic)
        return "its exceptions use periodic boundary conditions";
    if (!force.getIncludeDirectSpace())
        return "its direct space is left out";
    if (!terms.nonbonded.empty())
        return "openmm-chaintree has code for one NonbondedForce, and there is another before it";
    EnergyTerms::Nonbonded nonbonded;
    nonbonded.force = setting.index;
    nonbonded.cutoff = numeric_limits<double>::infinity();
    nonbonded.switchingDistance = nonbonded.cutoff;
    nonbonded.dielectric = 1;
    nonbonded.periodic = isPeriodic;
    if (isPeriodic && force.getUseDispersionCorrection())
        nonbonded.dispersion = NonbondedForceImpl::calcDispersionCorrection(setting.system, force);
    if (method == NonbondedForce::CutoffNonPeriodic || isPeriodic) {
        nonbonded.cutoff = force.getCutoffDistance();
        nonbonded.switchingDistance =
            force.getUseSwitchingFunction() ? force.getSwitchingDistance() : force.getCutoffDistance();
        nonbonded.dielectric = force.getReactionFieldDielectric();
        if (!(nonbonded.cutoff > 0 && isfinite(nonbonded.cutoff) && isfinite(nonbonded.switchingDistance) &&
              isfinite(nonbonded.dielectric)))
            return "its cutoff, switching distance or dielectric makes no sense";
    }
    if (isEwald) {
        nonbonded.ewaldAlpha = findEwaldAlpha(setting.system, force);
        if (!(nonbonded.ewaldAlpha > 0 && nonbonded.ewaldAlpha * nonbonded.cutoff <= CT_MOST_EWALD))
            return "its alpha of Ewald summation does not fit its cutoff";
    }
    EnergyTerms::TermSet exceptions = createTermSet(setting.index, ctExceptionTerm, 2, 3);
    exceptions.periodic = force.getExceptionsUsePeriodicBoundaryConditions();
    string reason = translateParticles(force, setting.parameters, nonbonded);
    if (reason.empty())
        reason = translateExceptions(force, setting.parameters, nonbonded, exceptions);
    if (isEwald && reason.empty()) {
        EnergyTerms::TermSet excluded = createTermSet(setting.index, ctExpressionTerm, 2, 1);
        excluded.periodic = exceptions.periodic;
        reason = translateExcludedPairs(nonbonded, excluded);
        terms.termSets.push_back(excluded);
    }
    terms.nonbonded.push_back(nonbonded);
    terms.termSets.push_back(exceptions);
    return reason;
}

static const NativeForceKind NONBONDED(translateNonbonded);
