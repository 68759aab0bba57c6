#include "TorsionMonteCarloIntegratorProxy.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NEWEST_VERSION = 4;

TorsionMonteCarloIntegratorProxy::TorsionMonteCarloIntegratorProxy() : SerializationProxy("TorsionMonteCarloIntegrator")
{
}

void TorsionMonteCarloIntegratorProxy::serialize(const void* object, SerializationNode& node) const
{
    const TorsionMonteCarloIntegrator& integrator = *reinterpret_cast<const TorsionMonteCarloIntegrator*>(object);
    node.setIntProperty("version", NEWEST_VERSION);
    node.setDoubleProperty("stepSize", integrator.getStepSize());
    node.setDoubleProperty("constraintTolerance", integrator.getConstraintTolerance());
    node.setIntProperty("integrationForceGroups", integrator.getIntegrationForceGroups());
    node.setDoubleProperty("temperature", integrator.getTemperature());
    node.setIntProperty("randomSeed", integrator.getRandomNumberSeed());
    node.setIntProperty("trialsPerStep", integrator.getTrialsPerStep());
    node.setIntProperty("initialClashPolicy", integrator.getInitialClashPolicy());
    node.setIntProperty("stericMode", integrator.getStericMode());
    node.setBoolProperty("nativeEnergies", integrator.getNativeEnergies());
    double bornCutoff, pairCutoff;
    integrator.getStandInCutoffs(bornCutoff, pairCutoff);
    node.setIntProperty("trialsPerOuterTest", integrator.getTrialsPerOuterTest());
    node.setDoubleProperty("standInBornCutoff", bornCutoff);
    node.setDoubleProperty("standInPairCutoff", pairCutoff);
    node.setDoubleProperty("standInGridWidth", integrator.getStandInGridWidth());
    node.setBoolProperty("adaptMoveSizes", integrator.getAdaptMoveSizes());
    integrator.moves->writeMoves(node.createChildNode("Moves"));
}

void* TorsionMonteCarloIntegratorProxy::deserialize(const SerializationNode& node) const
{
    const int version = node.getIntProperty("version");
    checkVersion(version, NEWEST_VERSION, "the XML of a TorsionMonteCarloIntegrator");
    unique_ptr<TorsionMonteCarloIntegrator> integrator(
        new TorsionMonteCarloIntegrator(node.getDoubleProperty("temperature")));
    integrator->setStepSize(node.getDoubleProperty("stepSize"));
    integrator->setConstraintTolerance(node.getDoubleProperty("constraintTolerance"));
    integrator->setIntegrationForceGroups(node.getIntProperty("integrationForceGroups"));
    integrator->setRandomNumberSeed(node.getIntProperty("randomSeed"));
    integrator->setTrialsPerStep(node.getIntProperty("trialsPerStep"));
    integrator->setInitialClashPolicy(
        (TorsionMonteCarloIntegrator::InitialClashPolicy)node.getIntProperty("initialClashPolicy"));
    integrator->setStericMode(TorsionMonteCarloIntegrator::Hard); // the only mode of version 1
    if (version > 1)
        integrator->setStericMode((TorsionMonteCarloIntegrator::StericMode)node.getIntProperty("stericMode"));
    if (version > 2)
        integrator->setNativeEnergies(node.getBoolProperty("nativeEnergies"));
    if (version > 3) {
        integrator->setTrialsPerOuterTest(node.getIntProperty("trialsPerOuterTest"));
        integrator->setStandInCutoffs(node.getDoubleProperty("standInBornCutoff"),
                                      node.getDoubleProperty("standInPairCutoff"));
        integrator->setStandInGridWidth(node.getDoubleProperty("standInGridWidth"));
    }
    integrator->setAdaptMoveSizes(node.getBoolProperty("adaptMoveSizes", false));
    integrator->moves->readMoves(node.getChildNode("Moves"));
    return integrator.release();
}
