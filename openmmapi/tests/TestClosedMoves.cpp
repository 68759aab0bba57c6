/**
 * This tests what closed moves sample. Without energy and spheres torsions that were drawn uniformly stay uniform, and
 * so do their pairs, the Jacobian of a window, and its number of solutions.
 *
 * The argument multiplies the number of samples: TestClosedMoves 100 takes minutes and says what it finds.
 */

#include "BackboneSupport.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "Significance.h"
#include <cstdlib>
#include <iomanip>
#include <new>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static long long numAllocations = 0;

void* operator new(size_t size)
{
    numAllocations++;
    void* memory = malloc(size == 0 ? 1 : size);
    if (memory == NULL)
        throw bad_alloc();
    return memory;
}

// Inlined without operator new, they would look to gcc as if they freed what another one has allocated.
[[gnu::noinline]] void operator delete(void* memory) noexcept
{
    free(memory);
}

[[gnu::noinline]] void operator delete(void* memory, size_t) noexcept
{
    free(memory);
}

static int countSolutions(const ctWindow& window)
{
    const double angles[CT_WINDOW_MOST] = {0};
    double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
    return ctFindClosures(&window, angles, solutions);
}

/**
 * What is looked at, of many states.
 */
class Record {
public:
    Record(int numTorsions, int residue) :
        residue(residue), angleCounts(numTorsions, vector<int>(NUM_BINS, 0)),
        pairCounts(numTorsions * (numTorsions - 1) / 2, vector<int>(NUM_PAIR_BINS * NUM_PAIR_BINS, 0)),
        solutionCounts(CT_CLOSURES_MOST + 1, 0)
    {
    }
    void add(Context& context, const TorsionMonteCarloIntegrator& integrator)
    {
        integrator.getTorsionAngles(context, angles);
        auto findBin = [](double angle, int numBins) {
            return min(numBins - 1, (int)((angle / (2 * M_PI) + 0.5) * numBins));
        };
        for (size_t i = 0, pair = 0; i < angles.size(); i++) {
            angleCounts[i][findBin(angles[i], NUM_BINS)]++;
            for (size_t j = 0; j < i; j++, pair++)
                pairCounts[pair]
                          [findBin(angles[i], NUM_PAIR_BINS) * NUM_PAIR_BINS + findBin(angles[j], NUM_PAIR_BINS)]++;
        }
        const ctWindow window = findWindow(getPositions(context), residue);
        logJacobians.push_back(computeLogJacobian(window));
        solutionCounts[countSolutions(window)]++;
    }
    /**
     * Get the significance of the most significant deviation from another record of uniform states, or from uniform
     * angles, corrected for their number.
     */
    double compare(const Record& uniform, bool isLong) const
    {
        double least = 1;
        int numTests = 0;
        auto take = [&](const string& what, double significance) {
            if (isLong && (significance < least || what[0] != 't'))
                cout << "    " << what << ": p = " << significance << endl;
            least = min(least, significance);
            numTests++;
        };
        for (auto& counts : angleCounts)
            take("torsion", testEquallyLikely(counts));
        for (auto& counts : pairCounts)
            take("two torsions", testEquallyLikely(counts));
        take("log |J|", testSameDistribution(logJacobians, uniform.logJacobians));
        take("solutions", testSameCounts(solutionCounts, uniform.solutionCounts));
        return least * numTests;
    }

private:
    static const int NUM_BINS = 16, NUM_PAIR_BINS = 6;
    const int residue;
    vector<double> angles, logJacobians;
    vector<vector<int>> angleCounts, pairCounts;
    vector<int> solutionCounts;
};

class Setting {
public:
    const char* name;
    int numTorsions, residue;
    double maxAngle, hop;
    int numTrials, numSamples;
};

/**
 * Torsions that were drawn uniformly are so after a few closed moves, however the window is drawn.
 */
static void testUniform(Platform& platform, const Setting& setting, double factor)
{
    Backbone chain(setting.numTorsions, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(11);
    integrator.setTrialsPerStep(setting.numTrials);
    integrator.addClosedMove(1, setting.maxAngle, {}, setting.hop);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    mt19937 random(5);
    uniform_real_distribution<double> draw(-M_PI, M_PI);
    vector<double> angles(setting.numTorsions);
    Record moved(setting.numTorsions, setting.residue), uniform(setting.numTorsions, setting.residue);
    const int numSamples = factor * setting.numSamples;
    for (int i = 0; i < 2 * numSamples; i++) {
        for (double& angle : angles)
            angle = draw(random);
        integrator.setTorsionAngles(context, angles);
        if (i % 2 == 0)
            integrator.step(1);
        (i % 2 == 0 ? moved : uniform).add(context, integrator);
    }
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    const bool isLong = factor > 1;
    if (isLong)
        cout << setting.name << ": " << numSamples << " samples, " << setting.numTrials << " trials each, "
             << double(accepted) / attempted << " accepted" << endl;
    const double significance = moved.compare(uniform, isLong);
    if (isLong)
        cout << "    all: p = " << significance << endl;
    ASSERT(accepted > attempted / 20);
    if (!(significance > 1e-3))
        throw OpenMMException(string(setting.name) +
                              ": closed moves do not keep torsions uniform, p = " + to_string(significance));
}

/**
 * The tail stays where it is, however often a window turns, and bonds and angles do.
 */
static void testNoDrift(Platform& platform)
{
    Backbone chain(12, 0.05);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(3);
    integrator.addClosedMove(1, 0.3, {}, 0.3);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(500);
    const vector<Vec3> x = getPositions(context);
    const int last = x.size() - 1;
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT(accepted > 2000);
    ASSERT(getDistance(x[5], chain.positions[5]) > 1e-3);
    for (int i : {0, 1, last - 1, last})
        ASSERT(getDistance(x[i], chain.positions[i]) < 1e-9);
    for (int i = 0; i < last; i++)
        ASSERT_EQUAL_TOL(getDistance(chain.positions[i], chain.positions[i + 1]), getDistance(x[i], x[i + 1]), 1e-11);
}

/**
 * A seed's trajectory has the same bits on every instruction set.
 */
static void testInstructionSets(Platform& platform)
{
    vector<vector<Vec3>> ends;
    for (const char* set : {"avx512", "avx2", "portable"}) {
        setenv("CHAINTREE_SIMD", set, 1);
        Backbone chain(40, 0.14);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.setRandomNumberSeed(3);
        integrator.addClosedMove(1, 0.3, {}, 0.3);
        integrator.addTorsionMove(0.2, 0.3);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        integrator.step(30);
        long long attempted, clashed, rejected, accepted;
        integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
        ASSERT(clashed > 100 && accepted > 500);
        ends.push_back(getPositions(context));
    }
    unsetenv("CHAINTREE_SIMD");
    assertSameBits(ends[0], ends[1]);
    assertSameBits(ends[0], ends[2]);
}

static void testCheckpoint(Platform& platform)
{
    Backbone chain(16, 0.1);
    TorsionMonteCarloIntegrator integrator(300), other(300);
    for (auto each : {&integrator, &other})
        each->addClosedMove(1, 0.3, {}, 0.3);
    Context context(chain.system, integrator, platform), otherContext(chain.system, other, platform);
    context.setPositions(chain.positions);
    integrator.step(3);
    stringstream checkpoint, wrong;
    context.createCheckpoint(checkpoint);
    context.createCheckpoint(wrong);
    otherContext.loadCheckpoint(checkpoint);
    integrator.step(3);
    other.step(3);
    assertSameBits(getPositions(context), getPositions(otherContext));
    other.setClosedMoveParameters(0, 1, 0.3, {}, 0.4);
    assertThrows("move 0 has hop 0.3 in it, but 0.4 here", [&] {
        otherContext.loadCheckpoint(wrong);
    });
}

/**
 * Trials allocate no memory.
 */
static void testMemory(Platform& platform)
{
    numAllocations = 0;
    Backbone chain(16, 0.1);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addClosedMove(1, 0.3, {}, 0.3);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    ASSERT(numAllocations > 0);
    integrator.step(10);
    integrator.setTrialsPerStep(1000);
    numAllocations = 0;
    integrator.step(1);
    ASSERT(numAllocations < 10);
}

int main(int argc, char** argv)
{
    const double factor = argc > 1 ? atof(argv[1]) : 1;
    return runOnPlatform("Reference", [&](Platform& platform) {
        const Setting settings[] = {{"Newton, far", 8, 0, 1.5, 0, 20, 16000},
                                    {"hops", 8, 0, 0.5, 1, 4, 12000},
                                    {"all windows", 12, 1, 0.5, 0.3, 12, 4000}};
        for (const Setting& setting : settings)
            testUniform(platform, setting, factor);
        testNoDrift(platform);
        testInstructionSets(platform);
        testCheckpoint(platform);
        testMemory(platform);
    });
}
