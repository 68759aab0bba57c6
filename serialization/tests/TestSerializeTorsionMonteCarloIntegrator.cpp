/**
 * This tests that the XML of a TorsionMonteCarloIntegrator preserves all settings.
 */

#include "openmm/CompoundIntegrator.h"
#include "openmm/internal/AssertionUtilities.h"
#include "openmm/OpenMMException.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmm/serialization/SerializationProxy.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <iostream>
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * Give each setting a value that is not the default.
 */
void setUp(TorsionMonteCarloIntegrator& integrator)
{
    integrator.setStepSize(0.1 / 3);
    integrator.setConstraintTolerance(1e-5 / 3);
    integrator.setIntegrationForceGroups(6);
    integrator.setRandomNumberSeed(-17);
    integrator.setTrialsPerStep(33);
    integrator.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    integrator.setNativeEnergies(false);
    integrator.setTrialsPerOuterTest(29);
    integrator.setStandInCutoffs(0.7 / 3, 1.1 / 3);
    integrator.setStandInGridWidth(0.01 / 3);
    integrator.addTorsionMove(1.0 / 3, 0.2, {4, 0, 2}, 3);
    integrator.addRigidBodyMove(0.5, 1.0 / 7, 0.3, {9, 1});
    integrator.addTorsionMove(0, 0.7);
    integrator.addRigidBodyMove(2, 0, 0.4);
    integrator.addClosedMove(0.25, 0.1 / 3, {3, 1}, 0.7 / 3);
    integrator.addLocalMove(0.75, 1.0 / 9, 1.0 / 11, {3, 4}, 5);
    integrator.addPivotMove(0.7, 0.1 / 3, {5, 3});
    integrator.addPivotMove(0, M_PI);
    integrator.addAtomMove(1.5, 0.1 / 3, {7, 0}, false);
    integrator.setMoveScales(8, {0.1, 1.0 / 3});
    integrator.addAtomMove(0.5, 0.02);
}

void assertSameMoves(const TorsionMonteCarloIntegrator& expected, const TorsionMonteCarloIntegrator& found)
{
    ASSERT_EQUAL(expected.getNumMoves(), found.getNumMoves());
    for (int i = 0; i < expected.getNumMoves(); i++) {
        ASSERT_EQUAL(expected.getMoveType(i), found.getMoveType(i));
        double weight1, weight2, angle1, angle2, translation1, translation2;
        vector<int> choices1, choices2;
        int count1, count2;
        double hop1, hop2;
        if (expected.getMoveType(i) == TorsionMonteCarloIntegrator::TorsionMove) {
            expected.getTorsionMoveParameters(i, weight1, angle1, choices1, count1);
            found.getTorsionMoveParameters(i, weight2, angle2, choices2, count2);
            ASSERT_EQUAL(count1, count2);
        }
        else if (expected.getMoveType(i) == TorsionMonteCarloIntegrator::ClosedMove) {
            expected.getClosedMoveParameters(i, weight1, angle1, choices1, hop1);
            found.getClosedMoveParameters(i, weight2, angle2, choices2, hop2);
            ASSERT_EQUAL(hop1, hop2);
        }
        else if (expected.getMoveType(i) == TorsionMonteCarloIntegrator::LocalMove) {
            double stiffness1, stiffness2;
            expected.getLocalMoveParameters(i, weight1, angle1, stiffness1, choices1, count1);
            found.getLocalMoveParameters(i, weight2, angle2, stiffness2, choices2, count2);
            ASSERT_EQUAL(stiffness1, stiffness2);
            ASSERT_EQUAL(count1, count2);
        }
        else if (expected.getMoveType(i) == TorsionMonteCarloIntegrator::AtomMove) {
            bool withHydrogens1, withHydrogens2;
            vector<double> scales1, scales2;
            expected.getAtomMoveParameters(i, weight1, angle1, choices1, withHydrogens1);
            found.getAtomMoveParameters(i, weight2, angle2, choices2, withHydrogens2);
            expected.getMoveScales(i, scales1);
            found.getMoveScales(i, scales2);
            ASSERT_EQUAL(withHydrogens1, withHydrogens2);
            ASSERT_EQUAL_CONTAINERS(scales1, scales2);
        }
        else if (expected.getMoveType(i) == TorsionMonteCarloIntegrator::PivotMove) {
            expected.getPivotMoveParameters(i, weight1, angle1, choices1);
            found.getPivotMoveParameters(i, weight2, angle2, choices2);
        }
        else {
            expected.getRigidBodyMoveParameters(i, weight1, translation1, angle1, choices1);
            found.getRigidBodyMoveParameters(i, weight2, translation2, angle2, choices2);
            ASSERT_EQUAL(translation1, translation2);
        }
        ASSERT_EQUAL(weight1, weight2);
        ASSERT_EQUAL(angle1, angle2);
        ASSERT_EQUAL_CONTAINERS(choices1, choices2);
    }
}

void assertSameOuterTests(const TorsionMonteCarloIntegrator& expected, const TorsionMonteCarloIntegrator& found)
{
    ASSERT_EQUAL(expected.getTrialsPerOuterTest(), found.getTrialsPerOuterTest());
    double expectedCutoffs[2], foundCutoffs[2];
    expected.getStandInCutoffs(expectedCutoffs[0], expectedCutoffs[1]);
    found.getStandInCutoffs(foundCutoffs[0], foundCutoffs[1]);
    ASSERT_EQUAL(expectedCutoffs[0], foundCutoffs[0]);
    ASSERT_EQUAL(expectedCutoffs[1], foundCutoffs[1]);
    ASSERT_EQUAL(expected.getStandInGridWidth(), found.getStandInGridWidth());
}

void assertSameIntegrators(const TorsionMonteCarloIntegrator& expected, const TorsionMonteCarloIntegrator& found)
{
    ASSERT_EQUAL(expected.getTemperature(), found.getTemperature());
    ASSERT_EQUAL(expected.getStepSize(), found.getStepSize());
    ASSERT_EQUAL(expected.getConstraintTolerance(), found.getConstraintTolerance());
    ASSERT_EQUAL(expected.getIntegrationForceGroups(), found.getIntegrationForceGroups());
    ASSERT_EQUAL(expected.getRandomNumberSeed(), found.getRandomNumberSeed());
    ASSERT_EQUAL(expected.getTrialsPerStep(), found.getTrialsPerStep());
    ASSERT_EQUAL(expected.getInitialClashPolicy(), found.getInitialClashPolicy());
    ASSERT_EQUAL(expected.getStericMode(), found.getStericMode());
    ASSERT_EQUAL(expected.getNativeEnergies(), found.getNativeEnergies());
    assertSameOuterTests(expected, found);
    assertSameMoves(expected, found);
}

string toXml(const Integrator& integrator)
{
    stringstream xml;
    XmlSerializer::serialize<Integrator>(&integrator, "Integrator", xml);
    return xml.str();
}

unique_ptr<Integrator> fromXml(const string& xml)
{
    stringstream stream(xml);
    return unique_ptr<Integrator>(XmlSerializer::deserialize<Integrator>(stream));
}

void testGetters()
{
    TorsionMonteCarloIntegrator integrator(310);
    setUp(integrator);
    double weight, angle, translation;
    vector<int> choices;
    int count;
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::TorsionMove, integrator.getMoveType(0));
    integrator.getTorsionMoveParameters(0, weight, angle, choices, count);
    ASSERT_EQUAL(1.0 / 3, weight);
    ASSERT_EQUAL(0.2, angle);
    ASSERT_EQUAL_CONTAINERS(vector<int>({4, 0, 2}), choices);
    ASSERT_EQUAL(3, count);
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::RigidBodyMove, integrator.getMoveType(1));
    integrator.getRigidBodyMoveParameters(1, weight, translation, angle, choices);
    ASSERT_EQUAL(0.5, weight);
    ASSERT_EQUAL(1.0 / 7, translation);
    ASSERT_EQUAL(0.3, angle);
    ASSERT_EQUAL_CONTAINERS(vector<int>({9, 1}), choices);
    integrator.getTorsionMoveParameters(2, weight, angle, choices, count);
    ASSERT(choices.empty());
    ASSERT_EQUAL(1, count);
    integrator.getRigidBodyMoveParameters(3, weight, translation, angle, choices);
    ASSERT(choices.empty());
    double hop;
    ASSERT_EQUAL(TorsionMonteCarloIntegrator::ClosedMove, integrator.getMoveType(4));
    integrator.getClosedMoveParameters(4, weight, angle, choices, hop);
    ASSERT_EQUAL(0.25, weight);
    ASSERT_EQUAL(0.1 / 3, angle);
    ASSERT_EQUAL_CONTAINERS(vector<int>({3, 1}), choices);
    ASSERT_EQUAL(0.7 / 3, hop);
    assertThrows("move 1 is not a torsion move", [&] {
        integrator.getTorsionMoveParameters(1, weight, angle, choices, count);
    });
    assertThrows("move 0 is not a rigid body move", [&] {
        integrator.getRigidBodyMoveParameters(0, weight, translation, angle, choices);
    });
    assertThrows("Index out of range", [&] {
        integrator.getMoveType(integrator.getNumMoves());
    });
    assertThrows("Index out of range", [&] {
        integrator.getTorsionMoveParameters(-1, weight, angle, choices, count);
    });
}

void testRoundTrip()
{
    TorsionMonteCarloIntegrator integrator(310.0 / 3), plain(300);
    setUp(integrator);
    auto copy = fromXml(toXml(integrator));
    assertSameIntegrators(integrator, dynamic_cast<TorsionMonteCarloIntegrator&>(*copy));
    copy = fromXml(toXml(plain));
    assertSameIntegrators(plain, dynamic_cast<TorsionMonteCarloIntegrator&>(*copy));
}

void testOldXml()
{
    // Version 1 had no steric mode: all sampling was hard. In versions 1 and 2, OpenMM evaluated all energies; native
    // ones sample the same distribution. Versions 1 to 3 had no outer tests.

    TorsionMonteCarloIntegrator integrator(310);
    integrator.setStericMode(TorsionMonteCarloIntegrator::Soft);
    integrator.setNativeEnergies(false);
    integrator.setTrialsPerOuterTest(7);
    integrator.setStandInCutoffs(0.25, 0.5);
    integrator.setStandInGridWidth(0.125);
    const vector<string> outer = {" trialsPerOuterTest=\"7\"", " standInBornCutoff=\".25\"",
                                  " standInPairCutoff=\".5\"", " standInGridWidth=\".125\""};
    const string xml = toXml(integrator);
    auto readWithout = [&](const string& version, vector<string> properties) {
        properties.insert(properties.end(), outer.begin(), outer.end());
        string changed = xml;
        auto replace = [&](const string& text, const string& with) {
            ASSERT(changed.find(text) != string::npos);
            changed.replace(changed.find(text), text.size(), with);
        };
        replace("version=\"4\"", "version=\"" + version + "\"");
        for (const string& property : properties)
            replace(property, "");
        return fromXml(changed);
    };
    auto first = readWithout("1", {" stericMode=\"1\"", " nativeEnergies=\"0\""});
    auto second = readWithout("2", {" nativeEnergies=\"0\""});
    auto third = readWithout("3", {});
    assertSameOuterTests(TorsionMonteCarloIntegrator(310), dynamic_cast<TorsionMonteCarloIntegrator&>(*third));
    ASSERT(!dynamic_cast<TorsionMonteCarloIntegrator&>(*third).getNativeEnergies());
    auto& firstCopy = dynamic_cast<TorsionMonteCarloIntegrator&>(*first);
    auto& secondCopy = dynamic_cast<TorsionMonteCarloIntegrator&>(*second);
    ASSERT(firstCopy.getStericMode() == TorsionMonteCarloIntegrator::Hard);
    ASSERT(secondCopy.getStericMode() == TorsionMonteCarloIntegrator::Soft);
    ASSERT(firstCopy.getNativeEnergies() && secondCopy.getNativeEnergies());
}

void testInCompoundIntegrator()
{
    CompoundIntegrator compound;
    compound.addIntegrator(new VerletIntegrator(0.001));
    TorsionMonteCarloIntegrator* integrator = new TorsionMonteCarloIntegrator(310);
    setUp(*integrator);
    compound.addIntegrator(integrator);
    auto copy = fromXml(toXml(compound));
    Integrator& found = dynamic_cast<CompoundIntegrator&>(*copy).getIntegrator(1);
    assertSameIntegrators(*integrator, dynamic_cast<TorsionMonteCarloIntegrator&>(found));
}

void testBadXml()
{
    TorsionMonteCarloIntegrator integrator(310);
    setUp(integrator);
    string xml = toXml(integrator);
    auto readWith = [&](const string& good, const string& bad) {
        string changed = xml;
        ASSERT(changed.find(good) != string::npos);
        changed.replace(changed.find(good), good.size(), bad);
        fromXml(changed);
    };
    assertThrows("the XML of a TorsionMonteCarloIntegrator has version 5, but this openmm-chaintree reads only "
                 "versions 1 to 4",
                 [&] {
                     readWith("version=\"4\"", "version=\"5\"");
                 });
    assertThrows("move of unknown kind: JumpMove", [&] {
        readWith("<RigidBodyMove", "<JumpMove");
    });
    assertThrows("trialsPerStep", [&] {
        readWith("trialsPerStep=\"33\"", "");
    });
    assertThrows("the number of trials per step", [&] {
        readWith("trialsPerStep=\"33\"", "trialsPerStep=\"0\"");
    });
    assertThrows("the steric mode", [&] {
        readWith("stericMode=\"1\"", "stericMode=\"4\"");
    });
    assertThrows("the number of trials to an outer test must be at least 0, but is -1", [&] {
        readWith("trialsPerOuterTest=\"29\"", "trialsPerOuterTest=\"-1\"");
    });
    assertThrows("the bornCutoff of stand-ins must be a finite number above 0", [&] {
        readWith("standInBornCutoff=\"", "standInBornCutoff=\"-");
    });
    assertThrows("the pairCutoff of stand-ins must be a finite number above 0", [&] {
        readWith("standInPairCutoff=\"", "standInPairCutoff=\"-");
    });
    assertThrows("the grid width of stand-ins must be a finite number above 0", [&] {
        readWith("standInGridWidth=\"", "standInGridWidth=\"-");
    });
    assertThrows("the initial clash policy", [&] {
        readWith("initialClashPolicy=\"1\"", "initialClashPolicy=\"5\"");
    });
}

int main()
{
    try {
        testGetters();
        testRoundTrip();
        testOldXml();
        testInCompoundIntegrator();
        testBadXml();
    }
    catch (const exception& e) {
        cout << "exception: " << e.what() << endl;
        return 1;
    }
    cout << "Done" << endl;
    return 0;
}
