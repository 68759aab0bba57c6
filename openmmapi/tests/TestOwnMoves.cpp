/**
 * Tests moves and stages of energy of kinds that the library does not know: whoever adds one has to write nothing else
 * than is written here.
 */

#include "openmm/CustomTorsionForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Names what an integrator keeps for those who extend it.
 */
class Extension : public TorsionMonteCarloIntegrator {
public:
    using TorsionMonteCarloIntegrator::addMove;
    using TorsionMonteCarloIntegrator::getEnergyStages;
};

static void addMove(TorsionMonteCarloIntegrator& integrator, unique_ptr<MonteCarloMove> move, double weight = 1)
{
    (integrator.*(&Extension::addMove))(std::move(move), weight);
}

// ---- A move that is not as likely as its reverse ----

#define BIASED_MOVE(P)                                                                                                 \
    P(Number, bias, "bias", "1", 0, 1)                                                                                 \
    P(Indices, torsions, "all")

MOVE_PARAMETERS(BiasedMove, BIASED_MOVE)

/**
 * Redraws torsion 0, whatever it was, with a density of 1 + bias cos(angle).
 */
class BiasedMove : public DeclaredMove<BiasedMoveParameters> {
public:
    BiasedMove(const BiasedMoveParameters& parameters, double sign = 1) : DeclaredMove(parameters), sign(sign), angle(0)
    {
    }
    BiasedMove(double bias, double sign = 1) : BiasedMove(BiasedMoveParameters{bias, {0}}, sign)
    {
    }
    string getSubject() const
    {
        return "biased torsion";
    }
    void bind(const LinkStructure& structure, const string& name)
    {
        if (structure.getTorsionLinks().empty())
            throw OpenMMException(name + " finds no torsion");
    }
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
    {
        do
            angle = random.drawSymmetric(M_PI);
        while (random.drawUniform() * (1 + bias) > getDensity(angle));
        trials.getPositions({0, 1, 2, 3}, ends);
        former = getDihedral(ends[0], ends[1], ends[2], ends[3]);
        proposal.addTorsion(0, angle - former);
        return true;
    }
    double computeLogRatio(TrialSession& trials)
    {
        if (angle > throwAbove)
            throw runtime_error("the move has had enough");
        trials.getProposedPositions({0, 1, 2, 3}, ends);
        ASSERT_EQUAL_TOL(1, cos(getDihedral(ends[0], ends[1], ends[2], ends[3]) - angle), 1e-12);
        return sign * log(getDensity(former) / getDensity(angle));
    }
    const double sign;
    double throwAbove = numeric_limits<double>::infinity();

private:
    double getDensity(double angle) const
    {
        return 1 + bias * cos(angle);
    }
    double angle, former;
    vector<Vec3> ends;
};

static const TorsionMonteCarloIntegrator::MoveType BIASED = (TorsionMonteCarloIntegrator::MoveType)1000;

MOVE_KIND("biased", BiasedMove, BIASED)

/**
 * Get the mean cosine of the torsion.
 *
 * @param height  the energy is this times the cosine, in kJ/mol; without a Force if it is 0
 */
static double sampleCosine(Platform& platform, double height, double sign)
{
    BeadChain chain(4, 0);
    if (height != 0) {
        CustomTorsionForce* energy = new CustomTorsionForce("height*cos(theta)");
        energy->addGlobalParameter("height", height);
        energy->addTorsion(0, 1, 2, 3);
        chain.system.addForce(energy);
    }
    TorsionMonteCarloIntegrator integrator(300);
    addMove(integrator, make_unique<BiasedMove>(0.8, sign));
    integrator.setTrialsPerStep(2);
    integrator.setRandomNumberSeed(7);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    const int numSamples = 20000;
    double sum = 0;
    vector<double> angles;
    for (int i = 0; i < numSamples; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        sum += cos(angles[0]);
    }
    return sum / numSamples;
}

static void testLogRatio(Platform& platform)
{
    // Without energy all angles are equally likely, however they are proposed. A ratio that is turned over is noticed.

    const double error = 0.02; // five standard deviations of the mean of samples of which two are worth one
    ASSERT_EQUAL_TOL(0.0, sampleCosine(platform, 0, 1), error);
    ASSERT(sampleCosine(platform, 0, -1) > 0.5);
    ASSERT(sampleCosine(platform, 0, 0) > 0.35);

    // With energy they are as likely as it says.

    const double kT = 300 * 8.31446261815324e-3, height = 2;
    double weights = 0, expected = 0;
    for (int i = 0; i < 360; i++) {
        const double cosine = cos(i * M_PI / 180), weight = exp(-height * cosine / kT);
        weights += weight;
        expected += weight * cosine;
    }
    ASSERT_EQUAL_TOL(expected / weights, sampleCosine(platform, height, 1), error);
}

static void testImpossibleWayBack(Platform& platform)
{
    // A trial from which nothing leads back is refused, and counted.

    class OneWay : public BiasedMove {
    public:
        OneWay() : BiasedMove(0)
        {
        }
        double computeLogRatio(TrialSession&)
        {
            return -numeric_limits<double>::infinity();
        }
    };
    BeadChain chain(4, 0);
    TorsionMonteCarloIntegrator integrator(300);
    addMove(integrator, make_unique<OneWay>());
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(1);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT_EQUAL(100, attempted);
    ASSERT_EQUAL(0, clashed + rejected + accepted);
    assertSameBits(chain.positions, getPositions(context));
}

static void testWhatMovesWrite(Platform& platform)
{
    // XML, checkpoints and messages take a kind of move as it describes itself.

    BeadChain chain(4, 0);
    TorsionMonteCarloIntegrator integrator(300);
    addMove(integrator, make_unique<BiasedMove>(0.25), 2.5);
    integrator.addTorsionMove(1, 0.5);
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);
    ASSERT(xml.str().find("<BiasedMove bias=\".25\" weight=\"2.5\">") != string::npos);
    unique_ptr<Integrator> read(XmlSerializer::deserialize<Integrator>(xml));
    auto& copy = dynamic_cast<TorsionMonteCarloIntegrator&>(*read);
    ASSERT_EQUAL(2, copy.getNumMoves());
    ASSERT_EQUAL(BIASED, copy.getMoveType(0));
    ASSERT_EQUAL("biased torsion (weight 2.5, 1 torsion to choose from)", copy.getMoveDescription(0));
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::TorsionMove, copy.getMoveType(1));
    double weight, maxAngle;
    vector<int> torsions;
    int count;
    assertThrows("move 0 is not a torsion move", [&] {
        copy.getTorsionMoveParameters(0, weight, maxAngle, torsions, count);
    });

    stringstream checkpoint, wrongCheckpoint;
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    integrator.step(3);
    context.createCheckpoint(checkpoint);
    vector<Vec3> positions = getPositions(context);
    Context copiedContext(chain.system, copy, platform);
    copiedContext.loadCheckpoint(checkpoint);
    integrator.step(1);
    copy.step(1);
    assertSameBits(getPositions(context), getPositions(copiedContext));
    TorsionMonteCarloIntegrator other(300);
    addMove(other, make_unique<BiasedMove>(0.5), 2.5);
    other.addTorsionMove(1, 0.5);
    Context otherContext(chain.system, other, platform);
    context.createCheckpoint(wrongCheckpoint);
    assertThrows("move 0 has bias 0.25 in it, but 0.5 here", [&] {
        otherContext.loadCheckpoint(wrongCheckpoint);
    });
    BeadChain bond(2, 0);
    assertThrows("TorsionMonteCarloIntegrator: move 0 finds no torsion", [&] {
        TorsionMonteCarloIntegrator unbound(300);
        addMove(unbound, make_unique<BiasedMove>(0));
        Context refused(bond.system, unbound, platform);
    });
}

static void testThrowingMove(Platform& platform)
{
    // An exception between propose and verdict ends the session: its trial is dropped, and the Context is where the
    // accepted trials have led, which is what the force says, too.

    BeadChain chain(4, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setRandomNumberSeed(1); // one by which the first trial is not the one that throws
    auto move = make_unique<BiasedMove>(0);
    move->throwAbove = 3;
    addMove(integrator, std::move(move));
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    bool hasThrown = false;
    try {
        integrator.step(1000);
    }
    catch (const runtime_error& error) {
        hasThrown = true;
    }
    ASSERT(hasThrown);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT(accepted > 0);
    assertThrows("there is no open proposal", [&] {
        chain.force->acceptProposal(context);
    });
    vector<Vec3> positions = getPositions(context);
    vector<double> angles;
    integrator.getTorsionAngles(context, angles);
    ASSERT_EQUAL_TOL(1, cos(angles[0] - getDihedral(positions[0], positions[1], positions[2], positions[3])), 1e-12);
    ASSERT(angles[0] <= 3 &&
           angles[0] != getDihedral(chain.positions[0], chain.positions[1], chain.positions[2], chain.positions[3]));
}

// ---- A stage of one's own ----

/**
 * Says what it is told to, and writes down what it is asked.
 */
class ToldStage : public EnergyStage {
public:
    explicit ToldStage(function<double()> say) : say(say)
    {
    }
    string getName() const
    {
        return "told";
    }
    bool begin(TrialSession&)
    {
        begun++;
        return takesPart;
    }
    double computeEnergyChange(TrialSession&)
    {
        computed++;
        return say();
    }
    void accept()
    {
        accepted++;
    }
    void reject()
    {
        rejected++;
    }
    bool takesPart = true;
    int begun = 0, computed = 0, accepted = 0, rejected = 0;

private:
    function<double()> say;
};

/**
 * Stages are asked in order, and NaN ends a trial. Of the others, the sum of all changes decides at once, or each stage
 * by its own.
 */
static void testStages(Platform& platform, bool oneByOne)
{
    BeadChain chain(5, 0.4);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setNativeEnergies(oneByOne);
    integrator.addTorsionMove(1, M_PI);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    EnergyStages& stages = (integrator.*(&Extension::getEnergyStages))();
    const int numOwn = stages.size();
    int number = 0;
    auto first = make_unique<ToldStage>([&] {
        return ++number % 4 == 0 ? numeric_limits<double>::quiet_NaN() : number % 4 == 1 ? 1e9 : -1.0;
    });
    auto second = make_unique<ToldStage>([&] {
        return number % 4 == 2 ? 1e9 : -1e10;
    });
    auto idle = make_unique<ToldStage>([] {
        return 1e9;
    });
    idle->takesPart = false;
    ToldStage &one = *first, &two = *second, &three = *idle;
    stages.add(std::move(first));
    stages.add(std::move(second));
    stages.add(std::move(idle));
    integrator.step(4);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT(clashed > 0);
    ASSERT_EQUAL(400 - clashed, number);
    ASSERT_EQUAL(4, one.begun);
    ASSERT_EQUAL(4, two.begun);
    ASSERT_EQUAL(4, three.begun);
    ASSERT_EQUAL(number, one.computed);

    // Of four trials, the first would be made good by the second stage, if it came so far.

    const int refusedByOne = number / 4 + (oneByOne ? (number + 3) / 4 : 0);
    ASSERT_EQUAL(number - refusedByOne, two.computed);
    ASSERT_EQUAL((number + 1) / 4 + (oneByOne ? 0 : (number + 3) / 4), accepted);
    ASSERT_EQUAL(accepted, one.accepted);
    ASSERT_EQUAL(accepted, two.accepted);
    ASSERT_EQUAL(number - accepted, one.rejected);
    ASSERT_EQUAL(two.computed - accepted, two.rejected);
    ASSERT_EQUAL(0, three.computed + three.accepted + three.rejected);

    // None of the library's own takes part: the spheres are hard, and there is no other force.

    auto counts = integrator.getStageStatistics();
    ASSERT_EQUAL(numOwn + 3, counts.size());
    for (int i = 0; i < numOwn; i++) {
        ASSERT_EQUAL(0, counts[i].computed);
        ASSERT_EQUAL(0, counts[i].refused);
    }
    ASSERT_EQUAL("told", counts[numOwn].stage);
    ASSERT_EQUAL(number, counts[numOwn].computed);
    ASSERT_EQUAL(refusedByOne, counts[numOwn].refused);
    ASSERT_EQUAL(two.computed, counts[numOwn + 1].computed);
    ASSERT_EQUAL(two.rejected, counts[numOwn + 1].refused);
    ASSERT_EQUAL(0, counts[numOwn + 2].computed);
    integrator.resetMoveStatistics();
    ASSERT_EQUAL(0, integrator.getStageStatistics()[numOwn].computed);
    ASSERT_EQUAL(0, integrator.getStageStatistics()[numOwn].refused);
}

/**
 * At a temperature of 0 the sum decides: a way down that one stage sees as a way up is taken.
 */
static void testStagesAtZero(Platform& platform)
{
    BeadChain chain(5, 0);
    TorsionMonteCarloIntegrator integrator(0);
    integrator.addTorsionMove(1, M_PI);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    EnergyStages& stages = (integrator.*(&Extension::getEnergyStages))();
    int number = 0;
    stages.add(make_unique<ToldStage>([] {
        return 1.0;
    }));
    stages.add(make_unique<ToldStage>([&] {
        return ++number % 2 == 0 ? -1.5 : -0.5;
    }));
    integrator.step(1);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT_EQUAL(50, accepted);
    ASSERT_EQUAL(50, rejected);
}

/**
 * A move that draws a torsion from a density of its own, decided by three stages that share an energy of
 * height * cos(angle): what is sampled is what that energy says, though two of the stages pull elsewhere.
 */
class SharedStage : public EnergyStage {
public:
    /** By what a planted error spoils the stage. */
    enum Fault { Right, ForgetsTheOneBefore, KeepsRejectedValue };
    SharedStage(function<double(double)> energy, Fault fault) : energy(energy), fault(fault)
    {
    }
    string getName() const
    {
        return "shared";
    }
    bool begin(TrialSession& trials)
    {
        value = energy(getAngle(trials, false));
        return true;
    }
    double computeEnergyChange(TrialSession& trials)
    {
        proposed = energy(getAngle(trials, true));
        return proposed - value;
    }
    void accept()
    {
        value = proposed;
    }
    void reject()
    {
        if (fault == KeepsRejectedValue)
            value = proposed;
    }

private:
    static double getAngle(TrialSession& trials, bool isProposed)
    {
        vector<Vec3> x;
        if (isProposed)
            trials.getProposedPositions({0, 1, 2, 3}, x);
        else
            trials.getPositions({0, 1, 2, 3}, x);
        return getDihedral(x[0], x[1], x[2], x[3]);
    }
    function<double(double)> energy;
    const Fault fault;
    double value = 0, proposed = 0;
};

/**
 * Get the mean cosine of the torsion.
 *
 * @param sign  1, or 0 for a move that forgets its ratio
 */
static double sampleStages(Platform& platform, double height, double sign, SharedStage::Fault fault)
{
    BeadChain chain(4, 0);
    TorsionMonteCarloIntegrator integrator(300);
    addMove(integrator, make_unique<BiasedMove>(0.8, sign));
    integrator.setTrialsPerStep(4);
    integrator.setRandomNumberSeed(7);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    EnergyStages& stages = (integrator.*(&Extension::getEnergyStages))();
    stages.add(make_unique<SharedStage>(
        [](double angle) {
            return 1.5 * sin(angle) - cos(2 * angle);
        },
        fault));
    stages.add(make_unique<SharedStage>(
        [height](double angle) {
            return height * cos(angle) - 2 * sin(angle);
        },
        fault));
    if (fault != SharedStage::ForgetsTheOneBefore)
        stages.add(make_unique<SharedStage>(
            [](double angle) {
                return 0.5 * sin(angle) + cos(2 * angle);
            },
            fault));
    const int numSamples = 20000;
    double sum = 0;
    vector<double> angles;
    for (int i = 0; i < numSamples; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        sum += cos(angles[0]);
    }
    return sum / numSamples;
}

static void testDelayedAcceptance(Platform& platform)
{
    const double kT = 300 * 8.31446261815324e-3, height = 2;
    double weights = 0, expected = 0;
    for (int i = 0; i < 360; i++) {
        const double cosine = cos(i * M_PI / 180), weight = exp(-height * cosine / kT);
        weights += weight;
        expected += weight * cosine;
    }
    expected /= weights;
    const double error = 0.02;
    ASSERT_EQUAL_TOL(expected, sampleStages(platform, height, 1, SharedStage::Right), error);
    for (auto fault : {SharedStage::ForgetsTheOneBefore, SharedStage::KeepsRejectedValue})
        ASSERT(fabs(sampleStages(platform, height, 1, fault) - expected) > 2 * error);
    ASSERT(fabs(sampleStages(platform, height, 0, SharedStage::Right) - expected) > 2 * error);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testLogRatio(platform);
        testImpossibleWayBack(platform);
        testWhatMovesWrite(platform);
        testThrowingMove(platform);
        testStages(platform, true);
        testStages(platform, false);
        testStagesAtZero(platform);
        testDelayedAcceptance(platform);
    });
}
