/**
 * This tests that the sizes of moves adapt to an acceptance, when they do, and how their scales are kept.
 */

#include "CheckpointSupport.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/internal/SizeAdaptation.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "SamplingSupport.h"
#include <memory>
#include <random>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * The scale of a move whose acceptance is known comes to where that is 0.4, from any scale, and stays there.
 */
static void testScaleOfKnownAcceptance()
{
    mt19937_64 random(1);
    for (double best : {0.9, 0.1, 0.003})
        for (double start : {1.0, 1e-4}) {
            SizeAdaptation adaptation;
            double scale = start, sum = 0;
            const int numTrials = 60000;
            for (int i = 0; i < numTrials; i++) {
                const bool accepted = (random() >> 11) * 0x1p-53 < pow(SizeAdaptation::AIM, scale / best);
                const double next = adaptation.countTrial(accepted, scale);
                ASSERT(next == scale || (i + 1) % SizeAdaptation::BLOCK == 0);
                scale = next;
                if (i >= numTrials / 2)
                    sum += log(scale);
            }
            const double found = exp(sum / (numTrials / 2));
            ASSERT_EQUAL_TOL(1.0, found / best, 0.05);
            ASSERT_EQUAL_TOL(1.0, scale / found, 0.2);
        }

    // What is always or never accepted.

    SizeAdaptation adaptation;
    double scale = 0.01;
    for (int i = 0; i < 20000; i++) {
        scale = adaptation.countTrial(true, scale);
        ASSERT(scale <= 1);
    }
    ASSERT_EQUAL(1, scale);
    for (int i = 0; i < 50000; i++)
        scale = adaptation.countTrial(false, scale);
    ASSERT_EQUAL(SizeAdaptation::LEAST_SCALE, scale);
}

/**
 * Two chains of beads that are crowded in a trap, and kinds of moves that have a size, but one.
 */
class Crowd : public BeadChain {
public:
    Crowd() : BeadChain(20, 0.45, 0.9), integrator(300)
    {
        const int length = 20;
        addMolecule(length, 0.45, 0.9, Vec3(0.9, 0, 0.9));
        CustomExternalForce* trap = new CustomExternalForce("x^2+y^2+z^2");
        for (int i = 0; i < 2 * length; i++)
            trap->addParticle(i);
        system.addForce(trap);
        integrator.setRandomNumberSeed(4);
        integrator.setTrialsPerStep(77);
        integrator.addTorsionMove(1, M_PI);
        integrator.addTorsionMove(1, 0, {1, 2});
        integrator.addRigidBodyMove(1, 2, M_PI);
        integrator.addLocalMove(1, 1, 5);
    }
    TorsionMonteCarloIntegrator integrator;
};

static const int WITHOUT_SIZE = 1, NUM_MOVES = 4;

static double getAcceptance(const TorsionMonteCarloIntegrator& integrator, int move)
{
    const Statistics counts(integrator, move);
    return counts.accepted / (double)counts.attempted;
}

static void testAcceptance(Platform& platform)
{
    Crowd crowd;
    TorsionMonteCarloIntegrator& integrator = crowd.integrator;
    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);

    // Off by default.

    ASSERT(!integrator.getAdaptMoveSizes());
    integrator.step(100);
    for (int move = 0; move < NUM_MOVES; move++) {
        ASSERT_EQUAL(1, integrator.getMoveScale(move));
        ASSERT(Statistics(integrator, move).attempted > 1000);
    }
    ASSERT(getAcceptance(integrator, 0) < 0.2);

    // Counts restart with it, and when it ends.

    integrator.setAdaptMoveSizes(true);
    for (int move = 0; move < NUM_MOVES; move++)
        ASSERT_EQUAL(0, Statistics(integrator, move).attempted);
    integrator.step(1000);
    ASSERT(integrator.getAdaptMoveSizes());
    integrator.setAdaptMoveSizes(true);
    ASSERT(Statistics(integrator, 0).attempted > 10000);
    integrator.setAdaptMoveSizes(false);
    vector<double> scales;
    for (int move = 0; move < NUM_MOVES; move++) {
        ASSERT_EQUAL(0, Statistics(integrator, move).attempted);
        scales.push_back(integrator.getMoveScale(move));
    }
    integrator.step(1000);
    for (int move = 0; move < NUM_MOVES; move++) {
        ASSERT_EQUAL(scales[move], integrator.getMoveScale(move));
        ASSERT_EQUAL(move == WITHOUT_SIZE, scales[move] == 1);
        if (move != WITHOUT_SIZE)
            ASSERT_EQUAL_TOL(0.4, getAcceptance(integrator, move), 0.06 / 0.4);
    }
}

/**
 * A run interrupted while sizes adapt continues bit for bit, from a checkpoint and from a State; with outer tests,
 * too, that take trials back.
 */
static void testGoingOn(Platform& platform, bool hasOuterTests)
{
    unique_ptr<Crowd> crowds[3];
    unique_ptr<Context> contexts[3];
    for (int i = 0; i < 3; i++) {
        crowds[i] = make_unique<Crowd>();
        if (hasOuterTests) {
            Probe* probe = new Probe(); // that OpenMM evaluates
            probe->energy = [](const vector<Vec3>& x) {
                return 2 * x[19].dot(x[19]);
            };
            crowds[i]->system.addForce(probe);
            crowds[i]->integrator.setTrialsPerOuterTest(20);
        }
        crowds[i]->integrator.setAdaptMoveSizes(true);
        contexts[i] = make_unique<Context>(crowds[i]->system, crowds[i]->integrator, platform);
    }
    contexts[0]->setPositions(crowds[0]->positions);
    crowds[0]->integrator.step(10);
    const WrittenContext written(*contexts[0]);
    written.loadCheckpoint(*contexts[1]);
    contexts[2]->setState(fromXml(written.xml));
    for (auto& crowd : crowds)
        crowd->integrator.step(25);
    ASSERT(crowds[0]->integrator.getMoveScale(0) < 1);
    for (int i : {1, 2}) {
        assertSameBits(getPositions(*contexts[0]), getPositions(*contexts[i]));
        for (int move = 0; move < NUM_MOVES; move++)
            ASSERT_EQUAL(crowds[0]->integrator.getMoveScale(move), crowds[i]->integrator.getMoveScale(move));
    }
    long long attempted, accepted, takenBack;
    double mean, deviation;
    crowds[0]->integrator.getOuterStatistics(attempted, accepted, takenBack, mean, deviation);
    ASSERT_EQUAL(hasOuterTests, takenBack > 0);

    // A State from before there were scales.

    string text = written.xml;
    text[text.find("version=\"4\"", text.find("<IntegratorParameters")) + 9] = '3';
    for (size_t at; (at = text.find(" scale=\"")) != string::npos;)
        text.erase(at, text.find('"', at + 8) + 1 - at);
    contexts[1]->setState(fromXml(text));
    ASSERT_EQUAL(1, crowds[1]->integrator.getMoveScale(0));
}

static void testSettingScales(Platform& platform)
{
    Crowd crowd;
    TorsionMonteCarloIntegrator& integrator = crowd.integrator;
    integrator.setMoveScale(0, 1.0 / 32);
    integrator.setMoveScale(2, 0.5);
    ASSERT_EQUAL(1.0 / 32, integrator.getMoveScale(0));
    ASSERT_EQUAL("torsion ±3.14159 rad (weight 1, scaled by 0.0312, all torsions)", integrator.getMoveDescription(0));
    for (double bad : {0.0, -1.0, 1.1, numeric_limits<double>::quiet_NaN()})
        assertThrows("the scale of move 0 must be above 0 and at most 1, but is", [&] {
            integrator.setMoveScale(0, bad);
        });
    assertThrows("move 1 has no size that could be scaled", [&] {
        integrator.setMoveScale(WITHOUT_SIZE, 0.5);
    });
    for (int bad : {-1, NUM_MOVES}) {
        assertThrows("Index out of range", [&] {
            integrator.setMoveScale(bad, 0.5);
        });
        assertThrows("Index out of range", [&] {
            integrator.getMoveScale(bad);
        });
    }

    // Trials are smaller, and counts restart.

    Context context(crowd.system, integrator, platform);
    context.setPositions(crowd.positions);
    integrator.setMoveScale(2, 1.0 / 1024);
    vector<double> before, after;
    integrator.getTorsionAngles(context, before);
    for (int move : {3, 1})
        integrator.removeMove(move);
    integrator.setTrialsPerStep(1);
    double largest = 0;
    for (int i = 0; i < 300; i++) {
        const vector<Vec3> start = getPositions(context);
        integrator.step(1);
        integrator.getTorsionAngles(context, after);
        for (size_t j = 0; j < before.size(); j++)
            largest = max(largest, fabs(remainder(after[j] - before[j], 2 * M_PI)));
        before = after;
        if (Statistics(integrator, 0).attempted == 0)
            ASSERT(getDistance(start[0], getPositions(context)[0]) < 0.05);
    }
    ASSERT(largest > 0.05 && largest <= M_PI / 32 + 1e-9);
    integrator.setMoveScale(0, 0.25);
    ASSERT_EQUAL(0, Statistics(integrator, 0).attempted);
    ASSERT(Statistics(integrator, 1).attempted > 0);

    // XML holds what is set. Other parameters make another move, which has its own size.

    integrator.setAdaptMoveSizes(true);
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    ASSERT(copy.getAdaptMoveSizes());
    ASSERT_EQUAL(0.25, copy.getMoveScale(0));
    ASSERT_EQUAL(1.0 / 1024, copy.getMoveScale(1));
    copy.setTorsionMoveParameters(0, 1, 0.5);
    ASSERT_EQUAL(1, copy.getMoveScale(0));
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testScaleOfKnownAcceptance();
        testAcceptance(platform);
        testGoingOn(platform, false);
        testGoingOn(platform, true);
        testSettingScales(platform);
    });
}
