#include "openmmchaintree/internal/StateSeal.h"
#include "openmm/OpenMMException.h"
#include "openmm/reference/ReferencePlatform.h"
#include "openmmchaintree/internal/BoxVectors.h"
#include "openmmchaintree/internal/Fingerprint.h"
#include "openmmchaintree/internal/StateNumber.h"
#include <array>
#include <cmath>
#include <cstring>
#include <sstream>
#include <vector>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

static const char SEAL[] = "seal";

[[noreturn]] static void fail(const string& what)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: the State is damaged: " + what);
}

// ---- The seal of a node ----

/**
 * Write a node without its name, which its parent writes, and without its seal. Lengths come in front, so that
 * different nodes have different texts.
 */
static void append(string& text, const SerializationNode& node)
{
    auto add = [&text](const string& part) {
        text += to_string(part.size()) + " " + part;
    };
    for (auto& property : node.getProperties())
        if (property.first != SEAL) {
            add(property.first);
            add(property.second);
        }
    text += to_string(node.getChildren().size()) + "/";
    for (const SerializationNode& child : node.getChildren()) {
        add(child.getName());
        append(text, child);
    }
}

static string sealOf(const SerializationNode& node)
{
    string text;
    append(text, node);
    return fingerprint(text.data(), text.size());
}

void ChainTreePlugin::seal(SerializationNode& node)
{
    node.setStringProperty(SEAL, sealOf(node));
}

void ChainTreePlugin::checkSeal(const SerializationNode& node)
{
    if (node.getStringProperty(SEAL, "") != sealOf(node))
        fail("its integrator parameters have another checksum");
}

// ---- The traits of a Context ----

/**
 * Checksums of the bits of many numbers. If a single number differs, they show which one, and its former value.
 */
class NumberSums {
public:
    explicit NumberSums(const vector<Vec3>& vectors)
    {
        for (size_t i = 0; i < 3 * vectors.size(); i++)
            add(i, getBits(vectors[i / 3][i % 3]));
    }
    explicit NumberSums(const string& text) : sums()
    {
        stringstream stream(text);
        stream.imbue(locale::classic());
        for (uint64_t& sum : sums)
            stream >> sum;
    }
    string toText() const
    {
        return to_string(sums[0]) + " " + to_string(sums[1]) + " " + to_string(sums[2]);
    }
    bool operator==(const NumberSums& other) const
    {
        return sums == other.sums;
    }
    /**
     * Find the only number that differs from the numbers of other sums. Returns false if none or several differ.
     */
    bool findLoneChange(const vector<Vec3>& vectors, const NumberSums& other, size_t& index, double& former) const
    {
        const uint64_t change = sums[0] - other.sums[0];
        if (change == 0)
            return false;
        for (index = 0; index < 3 * vectors.size(); index++)
            if (sums[1] - other.sums[1] == (index + 1) * change &&
                sums[2] - other.sums[2] == (index + 1) * (index + 1) * change) {
                const uint64_t bits = getBits(vectors[index / 3][index % 3]) - change;
                memcpy(&former, &bits, sizeof(former));
                return true;
            }
        return false;
    }

private:
    static uint64_t getBits(double number)
    {
        uint64_t bits;
        memcpy(&bits, &number, sizeof(bits));
        return bits;
    }
    void add(uint64_t index, uint64_t bits)
    {
        sums[0] += bits;
        sums[1] += (index + 1) * bits;
        sums[2] += (index + 1) * (index + 1) * bits;
    }
    array<uint64_t, 3> sums = {};
};

/** The largest change of a number that a platform stores as two numbers of single precision. */
static const double LARGEST_ROUNDING = 1e-10;

/**
 * Check numbers of particles. Returns whether they are equal to the written ones, up to periodic images.
 *
 * @param period    the shift of a periodic image in each direction; 0 if images are not allowed
 * @param rounding  by how much a number may differ
 */
static bool checkNumbers(const SerializationNode& node, const string& name, const vector<Vec3>& present,
                         const Vec3& period, double rounding)
{
    const NumberSums written(node.getStringProperty(name)), sums(present);
    if (sums == written)
        return true;
    size_t index;
    double former;
    if (!sums.findLoneChange(present, written, index, former))
        return false;
    const double change = present[index / 3][index % 3] - former, width = period[index % 3];
    if (fabs(change) <= rounding)
        return true;
    const bool isImage = width > 0 && fabs(change) >= 0.5 * width && fabs(remainder(change, width)) <= 1e-5 * width;
    if (!isImage)
        fail("a single number of its " + name + " was changed, for particle " + to_string(index / 3));
    return true;
}

static string joinNumbers(const BoxVectors& box)
{
    string text;
    for (int i = 0; i < 9; i++)
        text += (i == 0 ? "" : " ") + writeNumber(box[i / 3][i % 3]);
    return text;
}

void ChainTreePlugin::writeTraits(SerializationNode& node, ContextImpl& context)
{
    vector<Vec3> vectors;
    node.setStringProperty("time", writeNumber(context.getTime()))
        .setLongProperty("stepCount", context.getStepCount())
        .setStringProperty("box", joinNumbers(getBoxVectors(context)));
    context.getPositions(vectors);
    node.setStringProperty("positions", NumberSums(vectors).toText());
    context.getVelocities(vectors);
    node.setStringProperty("velocities", NumberSums(vectors).toText());
    for (auto& parameter : context.getParameters())
        setNumber(node.createChildNode("Parameter").setStringProperty("name", parameter.first), "value",
                  parameter.second);
}

void ChainTreePlugin::checkTraits(const SerializationNode& node, ContextImpl& context, string& others)
{
    const BoxVectors box = getBoxVectors(context);
    if (node.getStringProperty("time") != writeNumber(context.getTime()) ||
        node.getLongProperty("stepCount") != context.getStepCount())
        fail("its time or step count was changed (or another thread used the Context while it was saved or loaded)");
    if (node.getStringProperty("box") != joinNumbers(box))
        fail("its periodic box was changed");
    const bool isDouble = dynamic_cast<const ReferencePlatform*>(&context.getPlatform()) != NULL;
    const double rounding = isDouble ? 0 : LARGEST_ROUNDING;
    vector<Vec3> vectors;
    vector<string> different;
    context.getPositions(vectors);
    if (!checkNumbers(node, "positions", vectors, Vec3(box[0][0], box[1][1], box[2][2]), rounding))
        different.push_back("positions");
    context.getVelocities(vectors);
    if (!checkNumbers(node, "velocities", vectors, Vec3(), rounding))
        different.push_back("velocities");
    const map<string, double>& parameters = context.getParameters();
    for (const SerializationNode& parameter : node.getChildren()) {
        auto found = parameters.find(parameter.getStringProperty("name"));
        if (found != parameters.end() && found->second != getNumber(parameter, "value"))
            different.push_back("parameter " + found->first);
    }
    others.clear();
    for (const string& what : different)
        others += (others.empty() ? "" : ", ") + what;
}
