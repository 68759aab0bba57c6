/**
 * This tests that the XML of a StericExclusionForce preserves all parameters.
 */

#include "openmm/internal/AssertionUtilities.h"
#include "openmm/OpenMMException.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmm/serialization/SerializationProxy.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/System.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "TestSupport.h"
#include <iostream>
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Make a force in which each parameter has a different value, and none its default.
 */
unique_ptr<StericExclusionForce> createForce()
{
    unique_ptr<StericExclusionForce> force(new StericExclusionForce());
    force->setForceGroup(7);
    force->setName("spheres");
    force->setOverlapTolerance(0.1 / 3);
    force->setHydrogenBondAllowance(0.05 / 3);
    force->setForceConstant(1e5 / 7);
    force->setUsesPeriodicBoundaryConditions(true);
    force->addParticle(0.17, StericExclusionForce::Donor);
    force->addParticle(0.0);
    force->addParticle(1.0 / 3, StericExclusionForce::Acceptor);
    force->addParticle(5e-300, StericExclusionForce::DonorAndAcceptor);
    force->addBond(0, 1);
    force->addBond(1, 2);
    force->addBond(3, 2);
    force->addTorsion(0, 1, 2, 3);
    force->addTorsion(3, 2, 1, 0);
    force->addBallJoint(2, 1);
    force->addBallJoint(0, 3);
    force->addClosure(1, 0, 3, 2);
    force->addClosure(3, 2, 0, 1);
    force->addExclusion(2, 0);
    force->addExclusion(1, 3);
    return force;
}

void assertSameForces(const StericExclusionForce& expected, const StericExclusionForce& found)
{
    ASSERT_EQUAL(expected.getForceGroup(), found.getForceGroup());
    ASSERT_EQUAL(expected.getName(), found.getName());
    ASSERT_EQUAL(expected.getOverlapTolerance(), found.getOverlapTolerance());
    ASSERT_EQUAL(expected.getHydrogenBondAllowance(), found.getHydrogenBondAllowance());
    ASSERT_EQUAL(expected.getForceConstant(), found.getForceConstant());
    ASSERT_EQUAL(expected.usesPeriodicBoundaryConditions(), found.usesPeriodicBoundaryConditions());
    ASSERT_EQUAL(expected.getNumParticles(), found.getNumParticles());
    for (int i = 0; i < expected.getNumParticles(); i++) {
        double radius1, radius2;
        StericExclusionForce::HydrogenBondRole role1, role2;
        expected.getParticleParameters(i, radius1, role1);
        found.getParticleParameters(i, radius2, role2);
        ASSERT_EQUAL(radius1, radius2);
        ASSERT_EQUAL(role1, role2);
    }
    ASSERT_EQUAL(expected.getNumBonds(), found.getNumBonds());
    for (int i = 0; i < expected.getNumBonds(); i++) {
        int a[2], b[2];
        expected.getBondParticles(i, a[0], a[1]);
        found.getBondParticles(i, b[0], b[1]);
        ASSERT(equal(a, a + 2, b));
    }
    ASSERT_EQUAL(expected.getNumTorsions(), found.getNumTorsions());
    for (int i = 0; i < expected.getNumTorsions(); i++) {
        int a[4], b[4];
        expected.getTorsionParticles(i, a[0], a[1], a[2], a[3]);
        found.getTorsionParticles(i, b[0], b[1], b[2], b[3]);
        ASSERT(equal(a, a + 4, b));
    }
    ASSERT_EQUAL(expected.getNumBallJoints(), found.getNumBallJoints());
    for (int i = 0; i < expected.getNumBallJoints(); i++) {
        int a[2], b[2];
        expected.getBallJointParticles(i, a[0], a[1]);
        found.getBallJointParticles(i, b[0], b[1]);
        ASSERT(equal(a, a + 2, b));
    }
    ASSERT_EQUAL(expected.getNumClosures(), found.getNumClosures());
    for (int i = 0; i < expected.getNumClosures(); i++) {
        int a[4], b[4];
        expected.getClosureParticles(i, a[0], a[1], a[2], a[3]);
        found.getClosureParticles(i, b[0], b[1], b[2], b[3]);
        ASSERT(equal(a, a + 4, b));
    }
    ASSERT_EQUAL(expected.getNumExclusions(), found.getNumExclusions());
    for (int i = 0; i < expected.getNumExclusions(); i++) {
        int a[2], b[2];
        expected.getExclusionParticles(i, a[0], a[1]);
        found.getExclusionParticles(i, b[0], b[1]);
        ASSERT(equal(a, a + 2, b));
    }
}

string toXml(const Force& force)
{
    stringstream xml;
    XmlSerializer::serialize<Force>(&force, "Force", xml);
    return xml.str();
}

unique_ptr<Force> fromXml(const string& xml)
{
    stringstream stream(xml);
    return unique_ptr<Force>(XmlSerializer::deserialize<Force>(stream));
}

void testRoundTrip()
{
    auto force = createForce();
    auto copy = fromXml(toXml(*force));
    assertSameForces(*force, dynamic_cast<StericExclusionForce&>(*copy));
    StericExclusionForce empty;
    copy = fromXml(toXml(empty));
    assertSameForces(empty, dynamic_cast<StericExclusionForce&>(*copy));
}

void testInSystem()
{
    System system;
    system.addForce(createForce().release());
    unique_ptr<System> copy(XmlSerializer::clone(system));
    assertSameForces(*createForce(), dynamic_cast<StericExclusionForce&>(copy->getForce(0)));
}

void testBadXml()
{
    string xml = toXml(*createForce());
    auto readWith = [&](const string& good, const string& bad) {
        string changed = xml;
        ASSERT(changed.find(good) != string::npos);
        changed.replace(changed.find(good), good.size(), bad);
        fromXml(changed);
    };
    string version = "usesPeriodicBoundaryConditions=\"1\" version=\"";
    assertThrows(
        "the XML of a StericExclusionForce has version 4, but this openmm-chaintree reads only versions 1 to 3", [&] {
            readWith(version + "3", version + "4");
        });
    assertThrows("has version 0", [&] {
        readWith(version + "3", version + "0");
    });
    assertThrows("the radius of particle 0", [&] {
        readWith("radius=\".17\"", "radius=\"-1\"");
    });
    assertThrows("the hydrogen bond role of particle 0", [&] {
        readWith("hydrogenBondRole=\"1\"", "hydrogenBondRole=\"9\"");
    });
    assertThrows("p4", [&] {
        readWith("p4=\"3\"", "");
    });
}

/**
 * Without ball joints, closures and periodic boundary conditions, the XML is that of releases without these features.
 */
void testFormerVersion()
{
    StericExclusionForce force;
    force.addParticle(0.1);
    const string xml = toXml(force);
    ASSERT(xml.find("version=\"1\"") != string::npos && xml.find("BallJoint") == string::npos &&
           xml.find("eriodic") == string::npos);
    assertSameForces(force, dynamic_cast<StericExclusionForce&>(*fromXml(xml)));
    force.addClosure(0, 1, 2, 3);
    ASSERT(toXml(force).find("version=\"2\"") != string::npos);
    assertSameForces(force, dynamic_cast<StericExclusionForce&>(*fromXml(toXml(force))));
    StericExclusionForce periodic;
    periodic.setUsesPeriodicBoundaryConditions(true);
    ASSERT(toXml(periodic).find("version=\"3\"") != string::npos);
    assertSameForces(periodic, dynamic_cast<StericExclusionForce&>(*fromXml(toXml(periodic))));
}

int main()
{
    try {
        testRoundTrip();
        testFormerVersion();
        testInSystem();
        testBadXml();
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
