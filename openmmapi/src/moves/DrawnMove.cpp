#include "ctdensity.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/TorsionDensity.h"
#include <algorithm>
#include <cmath>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static void readDrawnMove(const SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator);

static const MoveKind KIND("drawn", "DrawnMove", TorsionMonteCarloIntegrator::DrawnMove, readDrawnMove);

namespace {

/**
 * Draws the torsions of a set anew from their density. See TorsionMonteCarloIntegrator::addDrawnMove().
 */
class DrawnMove : public MonteCarloMove {
public:
    DrawnMove(const vector<vector<int>>& torsions, const vector<TorsionDensity>& densities);
    string summarize() const;
    vector<MoveParameter> getParameters() const;
    void write(SerializationNode& node) const;
    void bind(const LinkStructure& structure, const string& name);
    bool propose(TrialSession& trials, RandomNumberGenerator& random);
    double computeLogRatio(TrialSession& trials);
    /** The sets of torsions, and the density of each: one for all, or as many as sets. */
    const vector<vector<int>> torsions;
    const vector<TorsionDensity> densities;

private:
    const TorsionDensity& densityOf(int set) const
    {
        return densities.size() == 1 ? densities[0] : densities[set];
    }
    vector<int> numberDensities(vector<TorsionDensity>& different) const;
    double evaluateFormer();
    /** The set that was drawn last, the values that its torsions had, those that were drawn, and the changes. */
    int drawnSet;
    vector<double> former, drawn, changes;
    /** The density of a set, how many random numbers it takes, where it was evaluated last, and what it was there. */
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
 * Get what a message calls a set of torsions.
 */
static string nameOf(size_t set)
{
    return "set " + to_string(set) + " of a drawn move";
}

DrawnMove::DrawnMove(const vector<vector<int>>& torsions, const vector<TorsionDensity>& densities) :
    MonteCarloMove(KIND), torsions(torsions), densities(densities), drawnSet(0)
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
    changes.resize(most);
    for (size_t i = 0; i < torsions.size(); i++) {
        const ctDensity* engine = densityOf(i).getEngine();
        setDensities.push_back({engine, ctCountUniforms(engine), vector<double>(torsions[i].size(), HUGE_VAL), 0});
    }
}

string DrawnMove::summarize() const
{
    return KIND.name + " torsions, " + to_string(torsions.size()) + (torsions.size() == 1 ? " set" : " sets");
}

// ---- Writing and reading ----

/**
 * Get the number of each set's density among those that differ.
 */
vector<int> DrawnMove::numberDensities(vector<TorsionDensity>& different) const
{
    vector<int> numbers;
    for (size_t i = 0; i < torsions.size(); i++) {
        auto found = find(different.begin(), different.end(), densityOf(i));
        numbers.push_back(found - different.begin());
        if (found == different.end())
            different.push_back(densityOf(i));
    }
    return numbers;
}

vector<MoveParameter> DrawnMove::getParameters() const
{
    vector<int> all;
    for (auto& set : torsions)
        all.insert(all.end(), set.begin(), set.end());

    // How many torsions a set has follows from its density.

    vector<TorsionDensity> different;
    vector<double> numbers;
    for (int number : numberDensities(different))
        numbers.push_back(number);
    for (auto& density : different) {
        vector<int> bins;
        vector<double> weights, means, widths;
        if (density.isTable())
            density.getTable(bins, weights);
        else
            density.getRotamers(weights, means, widths);
        numbers.insert(numbers.end(), {(double)density.getNumTorsions(), density.getFloor()});
        numbers.insert(numbers.end(), bins.begin(), bins.end());
        for (auto part : {&weights, &means, &widths})
            numbers.insert(numbers.end(), part->begin(), part->end());
    }
    return {{"torsions", all, "Torsion"}, {"densities", numbers, "Number"}};
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
    const vector<int> numbers = numberDensities(different);
    for (auto& density : different)
        writeDensity(density, node.createChildNode("Density"));
    for (size_t i = 0; i < torsions.size(); i++) {
        SerializationNode& set = node.createChildNode("Set");
        set.setIntProperty("density", numbers[i]);
        for (int torsion : torsions[i])
            set.createChildNode("Torsion").setIntProperty("index", torsion);
    }
}

static void readDrawnMove(const SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator)
{
    vector<TorsionDensity> different, densities;
    vector<vector<int>> torsions;
    for (auto& child : node.getChildren()) {
        if (child.getName() == "Density")
            different.push_back(readDensity(child));
        else {
            const int density = child.getIntProperty("density");
            checkIndex(density, different.size(), "density", "the XML of a drawn move");
            densities.push_back(different[density]);
            torsions.push_back(readIndices(child));
        }
    }
    integrator.addDrawnMove(weight, torsions, densities);
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

bool DrawnMove::propose(TrialSession& trials, RandomNumberGenerator& random)
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
        changes[i] = change - 2 * M_PI * ((change > M_PI) - (change < -M_PI));
    }
    trials.proposeTorsions(set, changes);
    return true;
}

/**
 * Get the density of the values that the set had. Most trials are refused, so that they are what they were.
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

// ---- The methods of the integrator ----

int TorsionMonteCarloIntegrator::addDrawnMove(double weight, const vector<vector<int>>& torsions,
                                              const vector<TorsionDensity>& densities)
{
    return addMove(make_unique<::DrawnMove>(torsions, densities), weight);
}

void TorsionMonteCarloIntegrator::getDrawnMoveParameters(int move, double& weight, vector<vector<int>>& torsions,
                                                         vector<TorsionDensity>& densities) const
{
    auto& found = moves->get<::DrawnMove>(move, KIND, weight);
    torsions = found.torsions;
    densities = found.densities;
}

void TorsionMonteCarloIntegrator::setDrawnMoveParameters(int move, double weight, const vector<vector<int>>& torsions,
                                                         const vector<TorsionDensity>& densities)
{
    setMove(move, KIND, make_unique<::DrawnMove>(torsions, densities), weight);
}
