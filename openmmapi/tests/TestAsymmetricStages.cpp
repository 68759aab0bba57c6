/**
 * This tests a stage whose change depends on the state that it starts from, and the one that makes it good: together
 * they sample what their energy says, though the change of the way back is not the opposite one.
 */

#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/MoveDeclaration.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <limits>
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

class Extension : public TorsionMonteCarloIntegrator {
public:
    using TorsionMonteCarloIntegrator::addMove;
    using TorsionMonteCarloIntegrator::getEnergyStages;
};

static const double kT = 300 * 8.31446261815324e-3;

/** What a test can spoil. */
enum Fault {
    Right,
    /** The radii of one direction are used for both. */
    OneDirection,
    /** The first stage does not tell what it is, so that the ratio of proposals is made a part of it. */
    RatioInFirstStage
};

// ---- An energy of an angle: a cheap part that depends on a radius, which depends on the angle, too ----

static double getRadius(double angle)
{
    return 1 + 0.9 * sin(angle);
}

static double getNearEnergy(double angle, double radius)
{
    return 4 * radius * cos(angle - 1.5);
}

static double getEnergy(double angle)
{
    return getNearEnergy(angle, getRadius(angle)) + 1.5 * sin(2 * angle);
}

/**
 * What both stages know of a trial.
 */
class Trial {
public:
    double before, after;
    double getNearChange() const
    {
        return getNearEnergy(after, getRadius(before)) - getNearEnergy(before, getRadius(before));
    }
    double getNearChangeBack() const
    {
        return getNearEnergy(before, getRadius(after)) - getNearEnergy(after, getRadius(after));
    }
};

static double getAngle(const TrialSession& trials, bool isProposed)
{
    vector<Vec3> x;
    if (isProposed)
        trials.getProposedPositions({0, 1, 2, 3}, x);
    else
        trials.getPositions({0, 1, 2, 3}, x);
    return getDihedral(x[0], x[1], x[2], x[3]);
}

class NearStage : public EnergyStage {
public:
    NearStage(Trial& trial, Fault fault) : trial(trial), fault(fault)
    {
    }
    string getName() const
    {
        return "near";
    }
    bool begin(TrialSession&)
    {
        return true;
    }
    bool isAntisymmetric() const
    {
        return fault == RatioInFirstStage;
    }
    double computeEnergyChange(TrialSession& trials)
    {
        trial = {getAngle(trials, false), getAngle(trials, true)};
        return trial.getNearChange();
    }

private:
    Trial& trial;
    const Fault fault;
};

class OtherStage : public EnergyStage {
public:
    OtherStage(Trial& trial, Fault fault) : trial(trial), fault(fault)
    {
    }
    string getName() const
    {
        return "other";
    }
    bool begin(TrialSession&)
    {
        return true;
    }
    double computeEnergyChange(TrialSession&)
    {
        return getEnergy(trial.after) - getEnergy(trial.before) - trial.getNearChange();
    }
    double getCorrection()
    {
        numCorrections++;
        return fault == OneDirection ? 0 : max(0.0, trial.getNearChangeBack()) - max(0.0, -trial.getNearChange());
    }
    int numCorrections = 0;

private:
    Trial& trial;
    const Fault fault;
};

// ---- A move that is not as likely as its reverse ----

#define LEANING_MOVE(P) P(Number, lean, "lean", "1", 0, 1)

MOVE_PARAMETERS(LeaningMove, LEANING_MOVE)

/**
 * Redraws torsion 0 with a density of 1 + lean cos(angle).
 */
class LeaningMove : public DeclaredMove<LeaningMoveParameters> {
public:
    using DeclaredMove::DeclaredMove;
    void bind(const LinkStructure&, const string&)
    {
    }
    bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal)
    {
        do
            angle = random.drawSymmetric(M_PI);
        while (random.drawUniform() * (1 + lean) > 1 + lean * cos(angle));
        former = getAngle(trials, false);
        proposal.addTorsion(0, angle - former);
        return true;
    }
    double computeLogRatio(TrialSession&)
    {
        return log((1 + lean * cos(former)) / (1 + lean * cos(angle)));
    }

private:
    double angle, former;
};

MOVE_KIND("leaning", LeaningMove, (TorsionMonteCarloIntegrator::MoveType)1001)

// ---- Sampling ----

/** Of the angle, the means of its cosine and sine, and of those of twice of it. */
typedef array<double, 4> Means;

static void add(Means& sums, double angle, double weight)
{
    const double values[] = {cos(angle), sin(angle), cos(2 * angle), sin(2 * angle)};
    for (int i = 0; i < 4; i++)
        sums[i] += weight * values[i];
}

static Means computeMeans()
{
    Means means = {};
    double weights = 0;
    for (int i = 0; i < 3600; i++) {
        const double angle = i * M_PI / 1800, weight = exp(-getEnergy(angle) / kT);
        weights += weight;
        add(means, angle, weight);
    }
    for (double& mean : means)
        mean /= weights;
    return means;
}

/**
 * Get the largest error of the means.
 */
static double sample(Platform& platform, bool oneByOne, double lean, Fault fault)
{
    BeadChain chain(4, 0);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.setNativeEnergies(oneByOne);
    (integrator.*(&Extension::addMove))(make_unique<LeaningMove>(LeaningMoveParameters{lean}), 1);
    integrator.setTrialsPerStep(5);
    integrator.setRandomNumberSeed(11);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    Trial trial;
    EnergyStages& stages = (integrator.*(&Extension::getEnergyStages))();
    auto other = make_unique<OtherStage>(trial, fault);
    const OtherStage& made = *other;
    stages.add(make_unique<NearStage>(trial, fault));
    stages.add(std::move(other));
    const int numSamples = 40000;
    Means means = {};
    vector<double> angles;
    for (int i = 0; i < numSamples; i++) {
        integrator.step(1);
        integrator.getTorsionAngles(context, angles);
        add(means, angles[0], 1.0 / numSamples);
    }
    ASSERT_EQUAL(oneByOne, made.numCorrections > 0);
    const Means expected = computeMeans();
    double error = 0;
    for (int i = 0; i < 4; i++)
        error = max(error, fabs(means[i] - expected[i]));
    return error;
}

static void testDistribution(Platform& platform)
{
    // Five standard deviations of the mean of samples of which two are worth one.

    const double error = 0.017;
    for (bool oneByOne : {true, false})
        for (double lean : {0.0, 0.8})
            ASSERT(sample(platform, oneByOne, lean, Right) < error);
    ASSERT(sample(platform, true, 0, OneDirection) > 2 * error);
    ASSERT(sample(platform, true, 0.8, RatioInFirstStage) > 2 * error);
}

/**
 * Says what it is told to.
 */
class ToldStage : public EnergyStage {
public:
    ToldStage(bool antisymmetric, double change, double correction) :
        antisymmetric(antisymmetric), change(change), correction(correction)
    {
    }
    string getName() const
    {
        return "told";
    }
    bool begin(TrialSession&)
    {
        return true;
    }
    bool isAntisymmetric() const
    {
        return antisymmetric;
    }
    double computeEnergyChange(TrialSession&)
    {
        return change;
    }
    double getCorrection()
    {
        return correction;
    }

private:
    const bool antisymmetric;
    const double change, correction;
};

static void testNumbers(Platform& platform)
{
    // A correction that is no number refuses a trial, one that is minus infinity makes up for what is finite.

    const double infinity = numeric_limits<double>::infinity();
    for (double correction : {0.0, -infinity, infinity, numeric_limits<double>::quiet_NaN()}) {
        BeadChain chain(4, 0);
        TorsionMonteCarloIntegrator integrator(300);
        integrator.addTorsionMove(1, 1);
        Context context(chain.system, integrator, platform);
        context.setPositions(chain.positions);
        EnergyStages& stages = (integrator.*(&Extension::getEnergyStages))();
        stages.add(make_unique<ToldStage>(false, -1, 0));
        stages.add(make_unique<ToldStage>(true, -1, correction));
        integrator.step(1);
        long long attempted, clashed, rejected, accepted;
        integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
        ASSERT_EQUAL(correction <= 0 ? 100 : 0, accepted);
    }
}

/**
 * A trial rejected by the ratio of proposals has reached no stage.
 */
static void testRatioAlone(Platform& platform)
{
    class OneWay : public LeaningMove {
    public:
        OneWay() : LeaningMove({0})
        {
        }
        double computeLogRatio(TrialSession&)
        {
            return -numeric_limits<double>::infinity();
        }
    };
    BeadChain chain(4, 0);
    TorsionMonteCarloIntegrator integrator(300);
    (integrator.*(&Extension::addMove))(make_unique<OneWay>(), 1);
    Context context(chain.system, integrator, platform);
    context.setPositions(chain.positions);
    EnergyStages& stages = (integrator.*(&Extension::getEnergyStages))();
    stages.add(make_unique<ToldStage>(false, -1, 0));
    integrator.step(1);
    ASSERT_EQUAL(0, integrator.getStageStatistics().back().computed);
    ASSERT_EQUAL(0, integrator.getStageStatistics().back().refused);
    long long attempted, clashed, rejected, accepted;
    integrator.getMoveStatistics(0, attempted, clashed, rejected, accepted);
    ASSERT_EQUAL(100, attempted);
    ASSERT_EQUAL(0, clashed + rejected + accepted);
}

int main()
{
    return runOnPlatform("Reference", [](Platform& platform) {
        testDistribution(platform);
        testNumbers(platform);
        testRatioAlone(platform);
    });
}
