#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include <cmath>
#include <locale>
#include <map>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

// ---- Kinds ----

/**
 * Get all kinds by their elements. Kinds make themselves known before main() begins, in an order that nobody knows.
 */
static map<string, const MoveKind*>& knownKinds()
{
    static map<string, const MoveKind*> kinds;
    return kinds;
}

MoveKind::MoveKind(const string& name, const string& element, TorsionMonteCarloIntegrator::MoveType type,
                   Reader& read) :
    name(name),
    element(element), type(type), read(read)
{
    knownKinds()[element] = this;
}

const MoveKind& MoveKind::find(const string& element)
{
    auto found = knownKinds().find(element);
    if (found == knownKinds().end())
        throw OpenMMException("the XML of a TorsionMonteCarloIntegrator has a move of unknown kind: " + element);
    return *found->second;
}

// ---- Moves ----

void MonteCarloMove::write(SerializationNode& node) const
{
    for (const MoveParameter& parameter : getParameters()) {
        if (auto real = get_if<double>(&parameter.value))
            node.setDoubleProperty(parameter.name, *real);
        else if (auto integer = get_if<int>(&parameter.value))
            node.setIntProperty(parameter.name, *integer);
        else if (auto indices = get_if<vector<int>>(&parameter.value))
            for (int index : *indices)
                node.createChildNode(parameter.element).setIntProperty("index", index);
        else
            for (double number : std::get<vector<double>>(parameter.value))
                node.createChildNode(parameter.element).setDoubleProperty("value", number);
    }
}

double MonteCarloMove::computeLogRatio(TrialSession&)
{
    return 0;
}

// ---- What moves share ----

vector<int> ChainTreePlugin::readIndices(const SerializationNode& node)
{
    vector<int> indices;
    for (auto& child : node.getChildren())
        indices.push_back(child.getIntProperty("index"));
    return indices;
}

string ChainTreePlugin::toSize(double largest, const string& unit)
{
    stringstream text;
    text.imbue(locale::classic());
    text << "±" << largest << " " << unit;
    return text.str();
}

void ChainTreePlugin::checkAngle(double angle, const string& name)
{
    checkNotNegative(angle, name);
    const double rounding = 1e-9; // of a half turn that was computed
    if (angle > M_PI * (1 + rounding)) {
        stringstream message;
        message << name << " must be at most pi, half a turn, but is " << angle << " radians; " << angle
                << " degrees are " << angle * M_PI / 180 << " radians (in Python " << angle << "*unit.degrees)";
        throw OpenMMException(message.str());
    }
}

void ChainTreePlugin::checkLargestAngle(double angle, const string& kind)
{
    checkAngle(angle, "TorsionMonteCarloIntegrator: the largest angle of a " + kind + " move");
}
