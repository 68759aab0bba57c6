#include "ctdensity.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include "openmmchaintree/TorsionDensity.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

namespace {

/**
 * Sets of torsions, by their indices.
 */
class Sets : public MoveParameter {
public:
    typedef vector<vector<int>> Type;
    Sets(const string& name, const Type& sets, const string& text) : MoveParameter(name, vector<int>(), text)
    {
        // The density gives the number of torsions of each set.

        auto& all = get<vector<int>>(value);
        for (auto& set : sets)
            all.insert(all.end(), set.begin(), set.end());
    }
    static Type read(const SerializationNode& node, const string&);
};

/**
 * The density of each set.
 */
class Densities : public MoveParameter {
public:
    typedef vector<TorsionDensity> Type;
    Densities(const string& name, const Type& densities, const string& text);
    static Type read(const SerializationNode& node, const string&);
};

} // namespace

#define DRAWN_MOVE(P)                                                                                                  \
    P(Sets, torsions, "sets of torsions")                                                                              \
    P(Densities, densities, "density of each set, or one for all")

MOVE_PARAMETERS(DrawnMove, DRAWN_MOVE)

namespace {

/**
 * Draws new values of the torsions of a set from their density. See TorsionMonteCarloIntegrator::addDrawnMove().
 */
class DrawnMove : public DeclaredMove<DrawnMoveParameters> {
public:
    explicit DrawnMove(const DrawnMoveParameters& parameters);
    string getSubject() const;
    vector<MoveParameter> getParameters() const;
    void write(SerializationNode& node) const;
    void bind(const LinkStructure& structure, const string& name);
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal);
    double computeLogRatio(TrialSession& trials);

private:
    const TorsionDensity& densityOf(int set) const
    {
        return densities.size() == 1 ? densities[0] : densities[set];
    }
    vector<TorsionDensity> listDensities() const;
    double evaluateFormer();
    /** The set of the open trial, the former values of its torsions, and the drawn values. */
    int drawnSet;
    vector<double> former, drawn;
    /** The density of a set, its number of random numbers, and its last evaluation. */
    class SetDensity {
    public:
        const ctDensity* engine;
        int numUniforms;
        vector<double> angles;
        double value;
    };
    vector<SetDensity> setDensities;
};

} // namespace

static void fail(const string& message)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: " + message);
}

/**
 * Get the name of a set of torsions for messages.
 */
static string nameOf(size_t set)
{
    return "set " + to_string(set) + " of a drawn move";
}

DrawnMove::DrawnMove(const DrawnMoveParameters& parameters) : DeclaredMove(parameters), drawnSet(0)
{
    if (torsions.empty())
        fail("a drawn move must have at least one set of torsions");
    if (densities.size() != 1 && densities.size() != torsions.size())
        fail("a drawn move must have one density, or one for each of its " + to_string(torsions.size()) +
             " sets of torsions, but has " + to_string(densities.size()));
    size_t most = 0;
    for (size_t i = 0; i < torsions.size(); i++) {
        if (torsions[i].size() != (size_t)densityOf(i).getNumTorsions())
            fail(nameOf(i) + " has " + to_string(torsions[i].size()) + " torsions, but its density is of " +
                 to_string(densityOf(i).getNumTorsions()));
        checkUnique(torsions[i], "TorsionMonteCarloIntegrator: " + nameOf(i) + " names torsion ");
        most = max(most, torsions[i].size());
    }
    former.resize(most);
    drawn.resize(most);
    for (size_t i = 0; i < torsions.size(); i++) {
        const ctDensity* engine = densityOf(i).getEngine();
        setDensities.push_back({engine, ctCountUniforms(engine), vector<double>(torsions[i].size(), HUGE_VAL), 0});
    }
}

string DrawnMove::getSubject() const
{
    return getKind().name + " torsions, " + to_string(torsions.size()) + (torsions.size() == 1 ? " set" : " sets");
}

// ---- Writing and reading ----

/**
 * Get the number of each density among the different ones.
 */
static vector<int> numberDensities(const vector<TorsionDensity>& densities, vector<TorsionDensity>& different)
{
    vector<int> numbers;
    for (auto& density : densities) {
        auto found = find(different.begin(), different.end(), density);
        numbers.push_back(found - different.begin());
        if (found == different.end())
            different.push_back(density);
    }
    return numbers;
}

Densities::Densities(const string& name, const Type& densities, const string& text) :
    MoveParameter(name, vector<double>(), text)
{
    auto& all = get<vector<double>>(value);
    vector<TorsionDensity> different;
    for (int number : numberDensities(densities, different))
        all.push_back(number);
    for (auto& density : different) {
        vector<int> bins;
        vector<double> weights, means, widths;
        if (density.isTable())
            density.getTable(bins, weights);
        else
            density.getRotamers(weights, means, widths);
        all.insert(all.end(), {(double)density.getNumTorsions(), density.getFloor()});
        all.insert(all.end(), bins.begin(), bins.end());
        for (auto part : {&weights, &means, &widths})
            all.insert(all.end(), part->begin(), part->end());
    }
}

/**
 * Get the density of each set, even if all share one.
 */
vector<TorsionDensity> DrawnMove::listDensities() const
{
    return densities.size() == 1 ? vector<TorsionDensity>(torsions.size(), densities[0]) : densities;
}

vector<MoveParameter> DrawnMove::getParameters() const
{
    return DrawnMoveParameters{torsions, listDensities()}.list();
}

static void writeDensity(const TorsionDensity& density, SerializationNode& node)
{
    vector<int> bins;
    vector<double> weights, means, widths;
    node.setDoubleProperty("floor", density.getFloor());
    if (density.isTable()) {
        density.getTable(bins, weights);
        for (int count : bins)
            node.createChildNode("Torsion").setIntProperty("bins", count);
        for (double value : weights)
            node.createChildNode("Bin").setDoubleProperty("value", value);
        return;
    }
    density.getRotamers(weights, means, widths);
    auto mean = means.begin(), width = widths.begin();
    for (double weight : weights) {
        SerializationNode& rotamer = node.createChildNode("Rotamer");
        rotamer.setDoubleProperty("weight", weight);
        for (int k = 0; k < density.getNumTorsions(); k++)
            rotamer.createChildNode("Torsion").setDoubleProperty("mean", *mean++).setDoubleProperty("width", *width++);
    }
}

static TorsionDensity readDensity(const SerializationNode& node)
{
    vector<int> bins;
    vector<double> weights, means, widths;
    for (auto& child : node.getChildren()) {
        if (child.getName() == "Torsion")
            bins.push_back(child.getIntProperty("bins"));
        else if (child.getName() == "Bin")
            weights.push_back(child.getDoubleProperty("value"));
        else {
            weights.push_back(child.getDoubleProperty("weight"));
            for (auto& torsion : child.getChildren()) {
                means.push_back(torsion.getDoubleProperty("mean"));
                widths.push_back(torsion.getDoubleProperty("width"));
            }
        }
    }
    const double floor = node.getDoubleProperty("floor");
    return bins.empty() ? TorsionDensity::fromRotamers(weights, means, widths, floor)
                        : TorsionDensity::fromTable(bins, weights, floor);
}

void DrawnMove::write(SerializationNode& node) const
{
    vector<TorsionDensity> different;
    const vector<int> numbers = numberDensities(listDensities(), different);
    for (auto& density : different)
        writeDensity(density, node.createChildNode("Density"));
    for (size_t i = 0; i < torsions.size(); i++) {
        SerializationNode& set = node.createChildNode("Set");
        set.setIntProperty("density", numbers[i]);
        for (int torsion : torsions[i])
            set.createChildNode("Torsion").setIntProperty("index", torsion);
    }
}

Sets::Type Sets::read(const SerializationNode& node, const string&)
{
    Type sets;
    for (auto& child : node.getChildren())
        if (child.getName() == "Set")
            sets.push_back(Indices::read(child));
    return sets;
}

Densities::Type Densities::read(const SerializationNode& node, const string&)
{
    Type different, densities;
    for (auto& child : node.getChildren())
        if (child.getName() == "Density")
            different.push_back(readDensity(child));
        else {
            const int density = child.getIntProperty("density");
            checkIndex(density, different.size(), "density", "the XML of a drawn move");
            densities.push_back(different[density]);
        }
    return densities;
}

// ---- Trials ----

void DrawnMove::bind(const LinkStructure& structure, const string& name)
{
    for (auto& set : torsions)
        for (int torsion : set) {
            checkIndex(torsion, structure.getTorsionLinks().size(), "torsion", name);
            structure.checkNoClosure(structure.getTorsionLinks()[torsion], name);
        }
}

bool DrawnMove::draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
{
    drawnSet = random.drawIndex(torsions.size());
    const vector<int>& set = torsions[drawnSet];
    const SetDensity& density = setDensities[drawnSet];
    double uniforms[CT_UNIFORMS_MOST];
    for (int i = 0; i < density.numUniforms; i++)
        uniforms[i] = random.drawUniform();
    ctDrawAngles(density.engine, uniforms, drawn.data());
    for (size_t i = 0; i < set.size(); i++) {
        former[i] = trials.getTorsionAngle(set[i]);
        const double change = drawn[i] - former[i];
        proposal.addTorsion(set[i], change - 2 * M_PI * ((change > M_PI) - (change < -M_PI)));
    }
    return true;
}

/**
 * Get the density of the former values. Most trials are rejected, so these often have not changed since the last call.
 */
double DrawnMove::evaluateFormer()
{
    SetDensity& density = setDensities[drawnSet];
    if (!equal(density.angles.begin(), density.angles.end(), former.begin())) {
        copy_n(former.begin(), density.angles.size(), density.angles.begin());
        density.value = ctGetDensity(density.engine, former.data());
    }
    return density.value;
}

double DrawnMove::computeLogRatio(TrialSession&)
{
    return log(evaluateFormer() / ctGetDensity(setDensities[drawnSet].engine, drawn.data()));
}

MOVE("drawn", DrawnMove, DRAWN_MOVE)
