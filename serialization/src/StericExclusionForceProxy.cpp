#include "StericExclusionForceProxy.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/StericExclusionForce.h"
#include <initializer_list>
#include <memory>
#include <string>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const int NEWEST_VERSION = 3;
/** The version of forces without ball joints, closures and periodic boundary conditions. */
static const int VERSION_OF_TORSIONS = 1;
/** The version of other forces without periodic boundary conditions. */
static const int VERSION_WITHOUT_BOX = 2;

StericExclusionForceProxy::StericExclusionForceProxy() : SerializationProxy("StericExclusionForce")
{
}

/**
 * Write particles as the properties p1, p2 and so on.
 */
static void writeParticles(SerializationNode& node, initializer_list<int> particles)
{
    int number = 0;
    for (int particle : particles)
        node.setIntProperty("p" + to_string(++number), particle);
}

void StericExclusionForceProxy::serialize(const void* object, SerializationNode& node) const
{
    const StericExclusionForce& force = *reinterpret_cast<const StericExclusionForce*>(object);
    // Earlier releases can read a force without what they do not know.

    int version = VERSION_OF_TORSIONS;
    if (force.usesPeriodicBoundaryConditions())
        version = NEWEST_VERSION;
    else if (force.getNumBallJoints() > 0 || force.getNumClosures() > 0)
        version = VERSION_WITHOUT_BOX;
    node.setIntProperty("version", version);
    node.setIntProperty("forceGroup", force.getForceGroup());
    node.setStringProperty("name", force.getName());
    node.setDoubleProperty("overlapTolerance", force.getOverlapTolerance());
    node.setDoubleProperty("hydrogenBondAllowance", force.getHydrogenBondAllowance());
    node.setDoubleProperty("forceConstant", force.getForceConstant());
    if (version > VERSION_WITHOUT_BOX)
        node.setBoolProperty("usesPeriodicBoundaryConditions", true);
    SerializationNode& particles = node.createChildNode("Particles");
    for (int i = 0; i < force.getNumParticles(); i++) {
        double radius;
        StericExclusionForce::HydrogenBondRole role;
        force.getParticleParameters(i, radius, role);
        particles.createChildNode("Particle")
            .setDoubleProperty("radius", radius)
            .setIntProperty("hydrogenBondRole", role);
    }
    SerializationNode& bonds = node.createChildNode("Bonds");
    for (int i = 0; i < force.getNumBonds(); i++) {
        int p1, p2;
        force.getBondParticles(i, p1, p2);
        writeParticles(bonds.createChildNode("Bond"), {p1, p2});
    }
    SerializationNode& torsions = node.createChildNode("Torsions");
    for (int i = 0; i < force.getNumTorsions(); i++) {
        int p1, p2, p3, p4;
        force.getTorsionParticles(i, p1, p2, p3, p4);
        writeParticles(torsions.createChildNode("Torsion"), {p1, p2, p3, p4});
    }
    if (version > VERSION_OF_TORSIONS) {
        SerializationNode& ballJoints = node.createChildNode("BallJoints");
        for (int i = 0; i < force.getNumBallJoints(); i++) {
            int p1, p2;
            force.getBallJointParticles(i, p1, p2);
            writeParticles(ballJoints.createChildNode("BallJoint"), {p1, p2});
        }
        SerializationNode& closures = node.createChildNode("Closures");
        for (int i = 0; i < force.getNumClosures(); i++) {
            int p1, p2, p3, p4;
            force.getClosureParticles(i, p1, p2, p3, p4);
            writeParticles(closures.createChildNode("Closure"), {p1, p2, p3, p4});
        }
    }
    SerializationNode& exclusions = node.createChildNode("Exclusions");
    for (int i = 0; i < force.getNumExclusions(); i++) {
        int p1, p2;
        force.getExclusionParticles(i, p1, p2);
        writeParticles(exclusions.createChildNode("Exclusion"), {p1, p2});
    }
}

void* StericExclusionForceProxy::deserialize(const SerializationNode& node) const
{
    const int version = node.getIntProperty("version");
    checkVersion(version, NEWEST_VERSION, "the XML of a StericExclusionForce");
    unique_ptr<StericExclusionForce> force(new StericExclusionForce());
    force->setForceGroup(node.getIntProperty("forceGroup"));
    force->setName(node.getStringProperty("name"));
    force->setOverlapTolerance(node.getDoubleProperty("overlapTolerance"));
    force->setHydrogenBondAllowance(node.getDoubleProperty("hydrogenBondAllowance"));
    force->setForceConstant(node.getDoubleProperty("forceConstant"));
    if (version > VERSION_WITHOUT_BOX)
        force->setUsesPeriodicBoundaryConditions(node.getBoolProperty("usesPeriodicBoundaryConditions"));
    for (auto& particle : node.getChildNode("Particles").getChildren())
        force->addParticle(particle.getDoubleProperty("radius"),
                           (StericExclusionForce::HydrogenBondRole)particle.getIntProperty("hydrogenBondRole"));
    for (auto& bond : node.getChildNode("Bonds").getChildren())
        force->addBond(bond.getIntProperty("p1"), bond.getIntProperty("p2"));
    for (auto& torsion : node.getChildNode("Torsions").getChildren())
        force->addTorsion(torsion.getIntProperty("p1"), torsion.getIntProperty("p2"), torsion.getIntProperty("p3"),
                          torsion.getIntProperty("p4"));
    if (version > VERSION_OF_TORSIONS) {
        for (auto& joint : node.getChildNode("BallJoints").getChildren())
            force->addBallJoint(joint.getIntProperty("p1"), joint.getIntProperty("p2"));
        for (auto& closure : node.getChildNode("Closures").getChildren())
            force->addClosure(closure.getIntProperty("p1"), closure.getIntProperty("p2"), closure.getIntProperty("p3"),
                              closure.getIntProperty("p4"));
    }
    for (auto& exclusion : node.getChildNode("Exclusions").getChildren())
        force->addExclusion(exclusion.getIntProperty("p1"), exclusion.getIntProperty("p2"));
    return force.release();
}
