/**
 * This tests that XML of earlier releases is read, and written back byte for byte.
 *
 * The argument is the folder of the files. Each file name ends with the version of its XML.
 */

#include "FreeChain.h"
#include "openmm/internal/AssertionUtilities.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/StericExclusionForce.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static string folder;

static string readFile(const string& name)
{
    ifstream file(folder + "/" + name, ios::binary);
    ASSERT(file.good());
    stringstream text;
    text << file.rdbuf();
    return text.str();
}

template <class Base>
unique_ptr<Base> fromXml(const string& xml)
{
    stringstream stream(xml);
    return unique_ptr<Base>(XmlSerializer::deserialize<Base>(stream));
}

template <class Object>
string toXml(const Object& object, const string& root)
{
    stringstream xml;
    XmlSerializer::serialize<Object>(&object, root, xml);
    return xml.str();
}

/**
 * Forces without ball joints and closures are still written as version 1, others that ignore periodic images as
 * version 2.
 */
void testForces()
{
    for (const char* name :
         {"StericExclusionForce-1.xml", "StericExclusionForce-2.xml", "StericExclusionForce-3.xml"}) {
        const string xml = readFile(name);
        const unique_ptr<Force> force = fromXml<Force>(xml);
        ASSERT_EQUAL(xml, toXml(*force, "Force"));
        ASSERT_EQUAL(string(name) == "StericExclusionForce-3.xml", force->usesPeriodicBoundaryConditions());
    }
}

/**
 * The file contains each kind of move twice, and each kind of density, with values that are not the defaults.
 */
void testIntegrator()
{
    const string xml = readFile("TorsionMonteCarloIntegrator-4.xml");
    ASSERT_EQUAL(xml, toXml(*fromXml<Integrator>(xml), "Integrator"));
}

void testOldestIntegrator()
{
    TorsionMonteCarloIntegrator expected(310.0 / 3);
    expected.setStepSize(0.1 / 3);
    expected.setConstraintTolerance(1e-5 / 3);
    expected.setIntegrationForceGroups(6);
    expected.setRandomNumberSeed(-17);
    expected.setTrialsPerStep(33);
    expected.setInitialClashPolicy(TorsionMonteCarloIntegrator::Refuse);
    expected.setStericMode(TorsionMonteCarloIntegrator::Hard);
    expected.addTorsionMove(1.0 / 3, 0.2, {4, 0, 2}, 3);
    expected.addRigidBodyMove(0.5, 1.0 / 7, 0.3, {9, 1});
    auto found = fromXml<Integrator>(readFile("TorsionMonteCarloIntegrator-1.xml"));
    ASSERT_EQUAL(toXml<Integrator>(expected, "Integrator"), toXml(*found, "Integrator"));
}

/**
 * Checkpoints and States identify moves by the text that describes them. The file contains the lines of a State that
 * describe moves.
 */
void testMovesOfStates()
{
    BeadChain chain(14, 0.1);
    FreeChain beads(6, 0.1);
    const int first = chain.system.getNumParticles();
    for (int i = 0; i < beads.system.getNumParticles(); i++) {
        chain.system.addParticle(1);
        chain.force->addParticle(0.1);
        chain.positions.push_back(beads.positions[i] + Vec3(20, 0, 0));
        if (i > 0) {
            chain.force->addBond(first + i - 1, first + i);
            chain.force->addBallJoint(first + i - 1, first + i);
        }
    }
    const vector<int> torsions = {0, 1, 2, 3, 4, 5, 6, 7, 9, 10};
    const TorsionDensity table = TorsionDensity::fromTable({3}, {1.0 / 3, 0, 2}, 0.1);
    const TorsionDensity grid = TorsionDensity::fromTable({2, 3}, {1, 2, 3.5, 4, 1e-5, 1.0 / 7});
    const TorsionDensity rotamers = TorsionDensity::fromRotamers({0.25}, {-1.1}, {0.2}, 1.0 / 3);
    const TorsionDensity pairs =
        TorsionDensity::fromRotamers({0.25, 2.0 / 3}, {-1.1, 3, 1.0 / 9, 0}, {0.2, 0.3, 0.5, 1.0 / 7}, 0.01);
    TorsionMonteCarloIntegrator integrator(300);
    integrator.addTorsionMove(1.0 / 3, 0.2, {4, 0, 2}, 3);
    integrator.addTorsionMove(0, M_PI);
    integrator.addRigidBodyMove(0.5, 1.0 / 7, 0.3, {15, 1});
    integrator.addRigidBodyMove(2, 0, 0.4);
    integrator.addClosedMove(0.25, 0.1 / 3, torsions, 0.7 / 3);
    integrator.addClosedMove(1, 0.1, {}, 0);
    integrator.addLocalMove(0.75, 1.0 / 9, 1.0 / 11, {3, 4}, 5);
    integrator.addLocalMove(1, 0.05, 400);
    integrator.addDrawnMove(1.5, {{3}, {4, 1}, {0}, {2, 0}, {1}}, {table, grid, table, pairs, rotamers});
    integrator.addDrawnMove(0.125, {{3}, {1}}, {table});
    integrator.addPivotMove(0.7, 0.1 / 3, {4, 3});
    integrator.addPivotMove(0, M_PI);
    integrator.setMoveScale(4, 1.0 / 3);
    Context context(chain.system, integrator, Platform::getPlatform("Reference"));
    context.setPositions(chain.positions);
    const State state = context.getState(State::Positions | State::IntegratorParameters);
    stringstream xml(toXml(state, "State"));
    string lines;
    for (string line; getline(xml, line);)
        if (line.find("<Move ") != string::npos)
            lines += line.substr(line.find('<')) + "\n";
    ASSERT_EQUAL(readFile("moves-of-a-state.txt"), lines);

    // A checkpoint contains the same texts, in the order of the arguments.

    stringstream stream;
    context.createCheckpoint(stream);
    const string checkpoint = stream.str();
    size_t position = 0;
    for (const char* text :
         {"kind",       "torsion",   "weight",         "maxAngle", "torsions",  "count",    "kind",
          "rigid body", "weight",    "maxTranslation", "maxAngle", "molecules", "kind",     "closed",
          "weight",     "maxAngle",  "torsions",       "hop",      "kind",      "local",    "weight",
          "sigma",      "stiffness", "torsions",       "window",   "kind",      "drawn",    "weight",
          "torsions",   "densities", "kind",           "pivot",    "weight",    "maxAngle", "ballJoints"}) {
        position = checkpoint.find(text, position);
        ASSERT(position != string::npos);
        position += string(text).size();
    }
}

int main(int argc, char** argv)
{
    folder = argc > 1 ? argv[1] : ".";
    return runOnPlatform("Reference", [](Platform&) {
        testForces();
        testIntegrator();
        testOldestIntegrator();
        testMovesOfStates();
    });
}
