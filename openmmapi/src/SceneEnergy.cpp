#include "openmmchaintree/internal/SceneEnergy.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/EngineArrays.h"
#include "openmmchaintree/internal/Scene.h"
#include <algorithm>
#include <numeric>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void fail(const string& message)
{
    throw OpenMMException("StericExclusionForce: " + message);
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
 * The arrays of the library for a set of terms.
 */
class LibraryTerms {
public:
    explicit LibraryTerms(const EnergyTerms::TermSet& set)
    {
        for (const EnergyTerms::Map& map : set.maps)
            maps.push_back({map.size, map.coefficients.data()});
        expression = {(int)set.inputs.size(), set.inputs.data(), (int)set.operations.size(), set.operations.data()};
    }
    ctTermSet describe(const EnergyTerms::TermSet& set) const
    {
        ctTermSet described = {};
        described.kind = set.kind;
        described.count = set.particles.size() / set.particlesPerTerm;
        described.particlesPerTerm = set.particlesPerTerm;
        described.particles = set.particles.data();
        described.parametersPerTerm = set.parametersPerTerm;
        described.parameters = set.parameters.data();
        described.mapCount = maps.size();
        described.maps = maps.data();
        described.expression = set.operations.empty() ? NULL : &expression;
        described.groupsPerTerm = set.groupsPerTerm;
        described.isPeriodic = set.periodic;
        return described;
    }

private:
    vector<ctTorsionMap> maps;
    ctExpression expression;
};

/**
 * The arrays of the library for a set of pairs.
 */
class LibraryPairs {
public:
    explicit LibraryPairs(const EnergyTerms::PairSet& set) : tables(::describe(set.tables))
    {
        for (const EnergyTerms::InteractionGroup& group : set.groups)
            groups.push_back({{(int)group[0].size(), (int)group[1].size()}, {group[0].data(), group[1].data()}});
    }
    ctPairSet describe(const EnergyTerms::PairSet& set) const
    {
        ctPairSet described = {};
        described.operationCount = set.operations.size();
        described.operations = set.operations.data();
        described.tableCount = tables.size();
        described.tables = tables.data();
        described.parametersPerParticle = set.parametersPerParticle;
        described.parameters = set.parameters.data();
        described.cutoff = set.cutoff;
        described.switchingDistance = set.switchingDistance;
        described.exclusionCount = set.exclusions.size();
        described.exclusions = rowsOf(set.exclusions);
        described.groupCount = groups.size();
        described.groups = groups.data();
        return described;
    }

private:
    vector<ctTable> tables;
    vector<ctInteractionGroup> groups;
};

/**
 * The arrays of the library for a value energy.
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
        described.exclusions = rowsOf(energy.exclusions);
        return described;
    }

private:
    class Expressions {
    public:
        explicit Expressions(const vector<EnergyTerms::ValueExpression>& expressions)
        {
            for (const EnergyTerms::ValueExpression& expression : expressions) {
                tables.push_back(::describe(expression.tables));
                described.push_back({expression.extent, (int)expression.operations.size(), expression.operations.data(),
                                     (int)tables.back().size(), tables.back().data()});
            }
        }
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
    nonbonded.ewaldAlpha = given.ewaldAlpha;
    nonbonded.exclusionCount = given.exclusions.size();
    nonbonded.exclusions = rowsOf(given.exclusions);
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
 * In a periodic box cutoffs are at most half of its width. Those of the Forces are, so the stand-in's must not be
 * longer.
 */
static ctStandIn describeStandIn(const EnergyTerms& terms)
{
    ctStandIn standIn = terms.standIn;
    if (!terms.born.empty() && terms.born[0].periodic) {
        standIn.bornCutoff = min(standIn.bornCutoff, terms.born[0].cutoff);
        standIn.pairCutoff = min(standIn.pairCutoff, min(terms.born[0].cutoff, terms.nonbonded[0].cutoff));
    }
    return standIn;
}

/**
 * Describe each item by pointers into arrays, which must outlive the descriptions.
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

void SceneEnergy::Deleter::operator()(ctEnergy* energy) const
{
    ctDestroyEnergy(energy);
}

SceneEnergy::SceneEnergy(Scene& scene) : scene(scene), isSaved(false)
{
}

SceneEnergy::~SceneEnergy()
{
}

// ---- Life ----

void SceneEnergy::setTerms(const EnergyTerms& terms)
{
    reset();
    this->terms = terms;
    standIn.clear();
    scene.setListed(findListed());
}

/**
 * Find the particles in terms or pairs, which have to be in leaves.
 */
vector<uint8_t> SceneEnergy::findListed() const
{
    const int numParticles = scene.definition.getNumParticles();
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

SceneEnergy::Handle SceneEnergy::create(ctChainTree* tree, const ctDefinition& scene) const
{
    vector<LibraryTerms> arrays;
    const vector<ctTermSet> sets = describeAll<ctTermSet>(terms.termSets, arrays);
    vector<LibraryPairs> pairArrays;
    const vector<ctPairSet> pairSets = describeAll<ctPairSet>(terms.pairSets, pairArrays);
    vector<LibraryValues> valueArrays;
    const vector<ctValueEnergy> valueEnergies = describeAll<ctValueEnergy>(terms.valueEnergies, valueArrays);
    const ctNonbonded nonbonded = terms.nonbonded.empty() ? ctNonbonded() : describe(terms.nonbonded[0]);
    const ctBorn born = terms.born.empty() ? ctBorn() : describe(terms.born[0]);
    const ctStandIn standIn = describeStandIn(terms);
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
        fail(errorText);
    return Handle(created);
}

/**
 * Get the library's energy, which is made at the first call.
 */
ctEnergy* SceneEnergy::require()
{
    return require(scene.tree.get(), energy);
}

/**
 * Get the library's energy of one of the scene's trees.
 */
ctEnergy* SceneEnergy::require(ctChainTree* tree, Handle& handle) const
{
    if (handle)
        return handle.get();
    Handle made = create(tree, scene.definition.describe(scene.arrangement));
    if (!standIn.empty())
        check(ctSetStandIn(made.get(), standIn.data()), made.get());
    handle = std::move(made);
    return handle.get();
}

void SceneEnergy::reset()
{
    energy.reset();
    otherEnergy.reset();
    isSaved = false;
}

void SceneEnergy::check(ctStatus status) const
{
    check(status, energy.get());
}

void SceneEnergy::check(ctStatus status, const ctEnergy* failed) const
{
    if (status != ctSuccess)
        fail(ctGetEnergyErrorText(failed));
}

void SceneEnergy::countChangeableTerms(vector<int>& counts)
{
    auto count = [&](const ctEnergy* energy) {
        counts.resize(terms.termSets.size());
        for (size_t i = 0; i < counts.size(); i++)
            counts[i] = ctCountChangeableTerms(energy, i);
    };
    if (scene.tree)
        return count(require());

    // A scene without positions has no tree yet, and knows no box.

    const vector<Vec3> positions(scene.definition.getNumParticles());
    SceneDefinition withoutBox(scene.definition);
    withoutBox.isPeriodic = false;
    const Scene::Tree tree = Scene::createTree(withoutBox, positions);
    count(create(tree.get(), withoutBox.describe(positions)).get());
}

// ---- The state ----

bool SceneEnergy::update(bool force)
{
    ctEnergy* energy = require();
    if (!force && ctIsEnergyOfState(energy))
        return false;
    check(ctRefreshEnergy(energy, &scene.counts));
    return true;
}

void SceneEnergy::getEnergies(double& pairs, vector<double>& pairSets, vector<double>& termSets)
{
    readEnergies(require(), scene.tree.get(), pairs, pairSets, termSets);
}

/**
 * Get the inverse of the volume of a tree's periodic box, 1/nm^3; 0 without one.
 */
static double inverseVolumeOf(const ctChainTree* tree)
{
    double box[3][3];
    return ctGetBox(tree, box) ? 1 / (box[0][0] * box[1][1] * box[2][2]) : 0;
}

void SceneEnergy::readEnergies(const ctEnergy* energy, const ctChainTree* tree, double& pairs, vector<double>& pairSets,
                               vector<double>& termSets) const
{
    const double perVolume = inverseVolumeOf(tree);
    pairs = ctGetPairEnergy(energy);
    if (!terms.nonbonded.empty())
        pairs += terms.nonbonded[0].dispersion * perVolume;
    pairSets.resize(terms.pairSets.size());
    for (size_t i = 0; i < pairSets.size(); i++)
        pairSets[i] = ctGetPairSetEnergy(energy, i) + terms.pairSets[i].longRange * perVolume;
    termSets.resize(terms.termSets.size());
    for (size_t i = 0; i < termSets.size(); i++)
        termSets[i] = ctGetTermEnergy(energy, i);
}

void SceneEnergy::computeWhole(double& nonbonded, double& born)
{
    check(ctComputeWholeEnergy(require(), &nonbonded, &born, &scene.counts));
    if (!terms.nonbonded.empty())
        nonbonded += terms.nonbonded[0].dispersion * inverseVolumeOf(scene.tree.get());
}

void SceneEnergy::computeValues(bool inTrial, vector<double>& energies)
{
    energies.resize(terms.valueEnergies.size());
    if (inTrial && scene.isScaled) {
        ctEnergy* proposed = require(scene.other.get(), otherEnergy);
        check(ctComputeValueEnergies(proposed, false, energies.data()), proposed);
        return;
    }
    check(ctComputeValueEnergies(require(), inTrial, energies.data()));
}

void SceneEnergy::save()
{
    isSaved = false;
    if (!energy)
        return;
    check(ctSaveEnergy(energy.get()));
    isSaved = true;
}

void SceneEnergy::restore()
{
    if (isSaved)
        check(ctRestoreEnergy(energy.get()));
    else
        energy.reset();
}

// ---- Trials ----

/**
 * Sum one part of the energy of a tree's state. Pairs are not divided: all count as near.
 */
double SceneEnergy::sumPart(const ctEnergy* energy, const ctChainTree* tree, ctEnergyPart part) const
{
    double pairs;
    vector<double> pairSets, termSets;
    readEnergies(energy, tree, pairs, pairSets, termSets);
    if (part == ctTermsPart)
        return accumulate(termSets.begin(), termSets.end(), 0.0);
    return part == ctNearPairsPart ? accumulate(pairSets.begin(), pairSets.end(), pairs) : 0;
}

/**
 * Compute a part of the change by the open trial, which scales the box.
 */
double SceneEnergy::computeScaledChange(ctEnergyPart part)
{
    ctEnergy* proposed = require(scene.other.get(), otherEnergy);
    if (part == ctTermsPart) {
        update(false);
        check(ctRefreshEnergy(proposed, &scene.counts), proposed);
    }
    const double before = sumPart(energy.get(), scene.tree.get(), part);
    const double after = sumPart(proposed, scene.other.get(), part);
    return before == after ? 0 : after - before; // also if both are infinite
}

double SceneEnergy::computeEnergyChange(ctEnergyPart part)
{
    if (scene.isScaled)
        return computeScaledChange(part);
    double change;
    check(ctComputeEnergyChange(require(), part, &change, &scene.counts));
    return change;
}

double SceneEnergy::getNearChangeBack()
{
    return ctGetNearChangeBack(require());
}

void SceneEnergy::accept()
{
    // This fails if not all parts of the change were computed. Then the next update computes the whole energy.

    if (energy)
        ctAcceptEnergyChange(energy.get());
}

// ---- The stand-in ----

int SceneEnergy::getStandInSize() const
{
    return terms.born.empty() ? 0 : scene.definition.getNumParticles();
}

void SceneEnergy::renewStandIn()
{
    check(ctRenewStandIn(require(), &scene.counts));
    getStandIn(standIn);
    otherEnergy.reset();
}

void SceneEnergy::getStandIn(vector<double>& numbers)
{
    numbers.resize(getStandInSize());
    if (!numbers.empty())
        ctGetStandIn(require(), numbers.data());
}

void SceneEnergy::setStandIn(const vector<double>& numbers)
{
    if ((int)numbers.size() != getStandInSize())
        fail("the stand-in is of another energy");
    if (!numbers.empty())
        check(ctSetStandIn(require(), numbers.data()));
    standIn = numbers;
    otherEnergy.reset();
}
