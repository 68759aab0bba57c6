#include "TrialEnergy.h"
#include "openmm/OpenMMException.h"
#include <algorithm>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

// EnergyTerms has the same kinds in the same order as ctenergy.h.

static_assert((int)EnergyTerms::HarmonicBond == ctHarmonicBondTerm &&
                  (int)EnergyTerms::HarmonicAngle == ctHarmonicAngleTerm &&
                  (int)EnergyTerms::PeriodicTorsion == ctPeriodicTorsionTerm &&
                  (int)EnergyTerms::RyckaertBellemans == ctRyckaertBellemansTerm &&
                  (int)EnergyTerms::TorsionMap == ctTorsionMapTerm && (int)EnergyTerms::Exception == ctExceptionTerm &&
                  (int)EnergyTerms::Expression == ctExpressionTerm,
              "the kinds of terms differ");
static_assert((int)EnergyTerms::X == ctMeasureX && (int)EnergyTerms::Distance == ctMeasureDistance &&
                  (int)EnergyTerms::Dihedral == ctMeasureDihedral,
              "the measures differ");
static_assert((int)EnergyTerms::Constant == ctConstantOperator && (int)EnergyTerms::Negate == ctNegateOperator &&
                  (int)EnergyTerms::Cot == ctCotOperator && (int)EnergyTerms::Erf == ctErfOperator &&
                  (int)EnergyTerms::PowerConstant == ctPowerConstantOperator &&
                  (int)EnergyTerms::Table == ctTableOperator,
              "the operators differ");
static_assert((int)EnergyTerms::Particles == ctOfParticles && (int)EnergyTerms::Pairs == ctOfPairs &&
                  (int)EnergyTerms::AllPairs == ctOfAllPairs,
              "the extents differ");

static vector<ctOperation> describe(const vector<EnergyTerms::Operation>& operations)
{
    vector<ctOperation> described;
    for (const EnergyTerms::Operation& operation : operations) {
        const array<int, 3>& a = operation.arguments;
        described.push_back({(ctOperator)operation.kind, {a[0], a[1], a[2]}, operation.constant});
    }
    return described;
}

static const int (*describe(const vector<array<int, 2>>& pairs))[2]
{
    return reinterpret_cast<const int(*)[2]>(pairs.data());
}

static vector<ctTable> describe(const vector<EnergyTerms::TableFunction>& tables)
{
    vector<ctTable> described;
    for (const EnergyTerms::TableFunction& given : tables) {
        ctTable table = {};
        table.isDiscrete = given.discrete;
        table.isPeriodic = given.periodic;
        table.dimensions = given.dimensions;
        copy(given.sizes.begin(), given.sizes.end(), table.sizes);
        copy(given.minima.begin(), given.minima.end(), table.minima);
        copy(given.maxima.begin(), given.maxima.end(), table.maxima);
        table.values = given.values.data();
        described.push_back(table);
    }
    return described;
}

/**
 * The arrays of the library that hold the terms of one set.
 */
class LibraryTerms {
public:
    explicit LibraryTerms(const EnergyTerms::TermSet& set)
    {
        for (const EnergyTerms::Map& map : set.maps)
            maps.push_back({map.size, map.coefficients.data()});
        for (const EnergyTerms::Input& input : set.inputs) {
            const array<int, 4>& p = input.particles;
            inputs.push_back({(ctMeasure)input.measure, {p[0], p[1], p[2], p[3]}});
        }
        operations = ::describe(set.operations);
        expression = {(int)inputs.size(), inputs.data(), (int)operations.size(), operations.data()};
    }
    ctTermSet describe(const EnergyTerms::TermSet& set) const
    {
        ctTermSet described = {};
        described.kind = (ctTermKind)set.kind;
        described.count = set.particles.size() / set.particlesPerTerm;
        described.particlesPerTerm = set.particlesPerTerm;
        described.particles = set.particles.data();
        described.parametersPerTerm = set.parametersPerTerm;
        described.parameters = set.parameters.data();
        described.mapCount = maps.size();
        described.maps = maps.data();
        described.expression = set.kind == EnergyTerms::Expression ? &expression : NULL;
        return described;
    }

private:
    vector<ctTorsionMap> maps;
    vector<ctInput> inputs;
    vector<ctOperation> operations;
    ctExpression expression;
};

/**
 * The same of a set of pairs.
 */
class LibraryPairs {
public:
    explicit LibraryPairs(const EnergyTerms::PairSet& set) :
        operations(::describe(set.operations)), tables(::describe(set.tables))
    {
        for (const EnergyTerms::InteractionGroup& group : set.groups)
            groups.push_back({{(int)group[0].size(), (int)group[1].size()}, {group[0].data(), group[1].data()}});
    }
    ctPairSet describe(const EnergyTerms::PairSet& set) const
    {
        ctPairSet described = {};
        described.operationCount = operations.size();
        described.operations = operations.data();
        described.tableCount = tables.size();
        described.tables = tables.data();
        described.parametersPerParticle = set.parametersPerParticle;
        described.parameters = set.parameters.data();
        described.cutoff = set.cutoff;
        described.switchingDistance = set.switchingDistance;
        described.exclusionCount = set.exclusions.size();
        described.exclusions = ::describe(set.exclusions);
        described.groupCount = groups.size();
        described.groups = groups.data();
        return described;
    }

private:
    vector<ctOperation> operations;
    vector<ctTable> tables;
    vector<ctInteractionGroup> groups;
};

/**
 * The same of a value energy.
 */
class LibraryValues {
public:
    explicit LibraryValues(const EnergyTerms::ValueEnergy& energy) : values(energy.values), terms(energy.terms)
    {
    }
    ctValueEnergy describe(const EnergyTerms::ValueEnergy& energy) const
    {
        ctValueEnergy described = {};
        described.parametersPerParticle = energy.parametersPerParticle;
        described.parameters = energy.parameters.data();
        described.valueCount = values.described.size();
        described.values = values.described.data();
        described.termCount = terms.described.size();
        described.terms = terms.described.data();
        described.cutoff = energy.cutoff;
        described.exclusionCount = energy.exclusions.size();
        described.exclusions = ::describe(energy.exclusions);
        return described;
    }

private:
    class Expressions {
    public:
        explicit Expressions(const vector<EnergyTerms::ValueExpression>& expressions)
        {
            for (const EnergyTerms::ValueExpression& expression : expressions) {
                operations.push_back(::describe(expression.operations));
                tables.push_back(::describe(expression.tables));
                described.push_back({(ctExtent)expression.extent, (int)operations.back().size(),
                                     operations.back().data(), (int)tables.back().size(), tables.back().data()});
            }
        }
        vector<vector<ctOperation>> operations;
        vector<vector<ctTable>> tables;
        vector<ctValueExpression> described;
    };
    Expressions values, terms;
};

static ctNonbonded describe(const EnergyTerms::Nonbonded& given)
{
    ctNonbonded nonbonded = {};
    nonbonded.charges = given.charges.data();
    nonbonded.sigmas = given.sigmas.data();
    nonbonded.epsilons = given.epsilons.data();
    nonbonded.cutoff = given.cutoff;
    nonbonded.switchingDistance = given.switchingDistance;
    nonbonded.dielectric = given.dielectric;
    nonbonded.exclusionCount = given.exclusions.size();
    nonbonded.exclusions = describe(given.exclusions);
    return nonbonded;
}

static ctBorn describe(const EnergyTerms::Born& given)
{
    ctBorn born = {};
    born.charges = given.charges.data();
    born.radii = given.radii.data();
    born.offsetRadii = given.offsetRadii.data();
    born.scaledRadii = given.scaledRadii.data();
    born.isFilled = given.filled;
    born.isRescaled = given.rescaled;
    born.alphas = given.alphas.data();
    born.betas = given.betas.data();
    born.gammas = given.gammas.data();
    born.neckTypeCount = given.numNeckTypes;
    born.neckTypes = given.neckTypes.data();
    born.neckHeights = given.neckHeights.data();
    born.neckDistances = given.neckDistances.data();
    born.neckScale = given.neckScale;
    born.neckCut = given.neckCut;
    born.coulomb = given.coulomb;
    born.soluteDielectric = given.soluteDielectric;
    born.solventDielectric = given.solventDielectric;
    born.kappa = given.kappa;
    born.surfaceEnergy = given.surfaceEnergy;
    born.probeRadius = given.probeRadius;
    born.cutoff = given.cutoff;
    born.shift = given.shift;
    return born;
}

/**
 * Describe terms by arrays of which each keeps what one description points to.
 */
template <class Description, class Arrays, class Given>
static vector<Description> describeAll(const vector<Given>& given, vector<Arrays>& arrays)
{
    vector<Description> described;
    arrays.reserve(given.size());
    for (const Given& one : given) {
        arrays.emplace_back(one);
        described.push_back(arrays.back().describe(one));
    }
    return described;
}

TrialEnergy::TrialEnergy(ctChainTree* tree, const ctDefinition& scene, const EnergyTerms& terms) :
    numPairSets(terms.pairSets.size()), numTermSets(terms.termSets.size()),
    numValueEnergies(terms.valueEnergies.size()), sizeOfStandIn(terms.born.empty() ? 0 : scene.particleCount)
{
    vector<LibraryTerms> arrays;
    const vector<ctTermSet> sets = describeAll<ctTermSet>(terms.termSets, arrays);
    vector<LibraryPairs> pairArrays;
    const vector<ctPairSet> pairSets = describeAll<ctPairSet>(terms.pairSets, pairArrays);
    vector<LibraryValues> valueArrays;
    const vector<ctValueEnergy> valueEnergies = describeAll<ctValueEnergy>(terms.valueEnergies, valueArrays);
    const ctNonbonded nonbonded = terms.nonbonded.empty() ? ctNonbonded() : describe(terms.nonbonded[0]);
    const ctBorn born = terms.born.empty() ? ctBorn() : describe(terms.born[0]);
    const ctStandIn standIn = {terms.standIn.bornCutoff, terms.standIn.pairCutoff, terms.standIn.gridWidth};
    ctEnergyDefinition definition = {};
    definition.scene = &scene;
    definition.nonbonded = terms.nonbonded.empty() ? NULL : &nonbonded;
    definition.born = terms.born.empty() ? NULL : &born;
    definition.standIn = terms.born.empty() ? NULL : &standIn;
    definition.pairSetCount = pairSets.size();
    definition.pairSets = pairSets.data();
    definition.termSetCount = sets.size();
    definition.termSets = sets.data();
    definition.valueEnergyCount = valueEnergies.size();
    definition.valueEnergies = valueEnergies.data();
    ctEnergy* created;
    char errorText[256];
    if (ctCreateEnergy(tree, &definition, &created, errorText, sizeof(errorText)) != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + errorText);
    energy.reset(created);
}

vector<uint8_t> TrialEnergy::findListed(const EnergyTerms& terms, int numParticles)
{
    vector<uint8_t> listed(numParticles, terms.nonbonded.empty() ? 0 : 1);
    auto list = [&](const vector<int>& particles) {
        for (int particle : particles)
            listed[particle] = 1;
    };
    for (const EnergyTerms::TermSet& set : terms.termSets)
        list(set.particles);
    for (const EnergyTerms::PairSet& set : terms.pairSets) {
        if (set.groups.empty())
            listed.assign(numParticles, 1);
        for (const EnergyTerms::InteractionGroup& group : set.groups)
            for (const vector<int>& particles : group)
                list(particles);
    }
    return listed;
}

void TrialEnergy::check(ctStatus status) const
{
    if (status != ctSuccess)
        throw OpenMMException(string("StericExclusionForce: ") + ctGetEnergyErrorText(energy.get()));
}

bool TrialEnergy::update(bool force, ctCounts& counts)
{
    if (!force && ctIsEnergyOfState(energy.get()))
        return false;
    check(ctRefreshEnergy(energy.get(), &counts));
    return true;
}

double TrialEnergy::computeChange(ctEnergyPart part, ctCounts& counts)
{
    double change;
    check(ctComputeEnergyChange(energy.get(), part, &change, &counts));
    return change;
}

void TrialEnergy::accept()
{
    // If not all of the change was asked for, this fails, and the next update computes everything.

    ctAcceptEnergyChange(energy.get());
}

void TrialEnergy::keep()
{
    check(ctKeepEnergy(energy.get()));
}

void TrialEnergy::takeBack()
{
    check(ctTakeBackEnergy(energy.get()));
}

double TrialEnergy::getNearChangeBack() const
{
    return ctGetNearChangeBack(energy.get());
}

void TrialEnergy::computeWhole(double& nonbonded, double& born, ctCounts& counts)
{
    check(ctComputeWholeEnergy(energy.get(), &nonbonded, &born, &counts));
}

void TrialEnergy::computeValues(bool inTrial, vector<double>& energies)
{
    energies.resize(numValueEnergies);
    check(ctComputeValueEnergies(energy.get(), inTrial, energies.data()));
}

void TrialEnergy::renewStandIn(ctCounts& counts)
{
    check(ctRenewStandIn(energy.get(), &counts));
}

void TrialEnergy::getStandIn(vector<double>& numbers) const
{
    numbers.resize(sizeOfStandIn);
    if (sizeOfStandIn > 0)
        ctGetStandIn(energy.get(), numbers.data());
}

void TrialEnergy::setStandIn(const vector<double>& numbers)
{
    if ((int)numbers.size() != sizeOfStandIn)
        throw OpenMMException("StericExclusionForce: the stand-in is of another energy");
    if (sizeOfStandIn > 0)
        check(ctSetStandIn(energy.get(), numbers.data()));
}

void TrialEnergy::getEnergies(double& pairs, vector<double>& pairSets, vector<double>& termSets) const
{
    pairs = ctGetPairEnergy(energy.get());
    pairSets.resize(numPairSets);
    for (int i = 0; i < numPairSets; i++)
        pairSets[i] = ctGetPairSetEnergy(energy.get(), i);
    termSets.resize(numTermSets);
    for (int i = 0; i < numTermSets; i++)
        termSets[i] = ctGetTermEnergy(energy.get(), i);
}

void TrialEnergy::countChangeableTerms(vector<int>& counts) const
{
    counts.resize(numTermSets);
    for (int i = 0; i < numTermSets; i++)
        counts[i] = ctCountChangeableTerms(energy.get(), i);
}
