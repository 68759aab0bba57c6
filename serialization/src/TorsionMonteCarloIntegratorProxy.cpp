#include "TorsionMonteCarloIntegratorProxy.h"
#include "openmm/OpenMMException.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <memory>
#include <string>
#include <vector>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NEWEST_VERSION = 2;

TorsionMonteCarloIntegratorProxy::TorsionMonteCarloIntegratorProxy() : SerializationProxy("TorsionMonteCarloIntegrator")
{
}

static void writeIndices(SerializationNode& node, const string& name, const vector<int>& indices)
{
    for (int index : indices)
        node.createChildNode(name).setIntProperty("index", index);
}

static vector<int> readIndices(const SerializationNode& node)
{
    vector<int> indices;
    for (auto& child : node.getChildren())
        indices.push_back(child.getIntProperty("index"));
    return indices;
}

static void writeTorsionMove(SerializationNode& moves, const TorsionMonteCarloIntegrator& integrator, int move)
{
    double weight, maxAngle;
    vector<int> torsions;
    int count;
    integrator.getTorsionMoveParameters(move, weight, maxAngle, torsions, count);
    SerializationNode& node = moves.createChildNode("TorsionMove");
    node.setDoubleProperty("weight", weight);
    node.setDoubleProperty("maxAngle", maxAngle);
    node.setIntProperty("count", count);
    writeIndices(node, "Torsion", torsions);
}

static void writeRigidBodyMove(SerializationNode& moves, const TorsionMonteCarloIntegrator& integrator, int move)
{
    double weight, maxTranslation, maxAngle;
    vector<int> molecules;
    integrator.getRigidBodyMoveParameters(move, weight, maxTranslation, maxAngle, molecules);
    SerializationNode& node = moves.createChildNode("RigidBodyMove");
    node.setDoubleProperty("weight", weight);
    node.setDoubleProperty("maxTranslation", maxTranslation);
    node.setDoubleProperty("maxAngle", maxAngle);
    writeIndices(node, "Molecule", molecules);
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
    SerializationNode& moves = node.createChildNode("Moves");
    for (int i = 0; i < integrator.getNumMoves(); i++)
        switch (integrator.getMoveType(i)) {
        case TorsionMonteCarloIntegrator::TorsionMove:
            writeTorsionMove(moves, integrator, i);
            break;
        case TorsionMonteCarloIntegrator::RigidBodyMove:
            writeRigidBodyMove(moves, integrator, i);
            break;
        }
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
    if (version > 1)
        integrator->setStericMode((TorsionMonteCarloIntegrator::StericMode)node.getIntProperty("stericMode"));
    for (auto& move : node.getChildNode("Moves").getChildren()) {
        double weight = move.getDoubleProperty("weight");
        if (move.getName() == "TorsionMove")
            integrator->addTorsionMove(weight, move.getDoubleProperty("maxAngle"), readIndices(move),
                                       move.getIntProperty("count"));
        else if (move.getName() == "RigidBodyMove")
            integrator->addRigidBodyMove(weight, move.getDoubleProperty("maxTranslation"),
                                         move.getDoubleProperty("maxAngle"), readIndices(move));
        else
            throw OpenMMException("the XML of a TorsionMonteCarloIntegrator has a move of unknown kind: " +
                                  move.getName());
    }
    return integrator.release();
}
