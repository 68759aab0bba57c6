#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmm/OpenMMException.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

// ---- Kinds ----

/**
 * Get all kinds by their elements. They are registered before main() begins, in undefined order.
 */
static map<string, const MoveKind*>& knownKinds()
{
    static map<string, const MoveKind*> kinds;
    return kinds;
}

MoveKind::MoveKind(const string& name, const string& element, TorsionMonteCarloIntegrator::MoveType type,
                   const vector<MoveParameter>& parameters, Reader& read) :
    name(name),
    element(element), type(type), parameters(parameters), read(read)
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

vector<const MoveKind*> MoveKind::getAll()
{
    vector<const MoveKind*> all;
    for (auto& known : knownKinds())
        all.push_back(known.second);
    return all;
}

string MoveKind::findUnit(const string& method, const string& argument)
{
    for (const MoveKind* kind : getAll())
        if (method.find(kind->element) != string::npos)
            for (const MoveParameter& parameter : kind->parameters)
                if (parameter.name == argument)
                    return parameter.unit;
    return "1";
}

string MoveKind::withArticle(const string& name)
{
    const bool beginsWithVowel = string("aeiou").find(name[0]) != string::npos;
    return (beginsWithVowel ? "an " : "a ") + name + " move";
}

// ---- Parameters ----

static string toText(double value)
{
    stringstream text;
    text.imbue(locale::classic());
    text << value;
    return text.str();
}

string MoveParameter::getRange() const
{
    if (isFlag)
        return "True or False";
    if (!holds_alternative<double>(value) && !holds_alternative<int>(value))
        return "";
    const string low = (mayBeLeast ? "at least " : "above ") + toText(least);
    const string high = most == LargestAngle ? "pi" : toText(most);
    if (isinf(most))
        return low;
    return mayBeLeast ? "from " + toText(least) + " to " + high : low + " and at most " + high;
}

/**
 * Throw an exception if an angle is above pi. It is probably in degrees.
 */
static void checkAngle(double angle, const string& name)
{
    checkNotNegative(angle, name);
    if (angle > MoveParameter::LargestAngle)
        throw OpenMMException(name + " must be at most pi, half a turn, but is " + toText(angle) + " radians; " +
                              toText(angle) + " degrees are " + toText(angle * M_PI / 180) + " radians (in Python " +
                              toText(angle) + "*unit.degrees)");
}

void MoveParameter::check(const string& kind) const
{
    double number = 0;
    if (auto real = get_if<double>(&value))
        number = *real;
    else if (auto integer = get_if<int>(&value))
        number = *integer;
    else
        return; // bind() knows which indices exist
    const string whose = "TorsionMonteCarloIntegrator: the " + text + " of " + MoveKind::withArticle(kind);
    if (most == LargestAngle)
        checkAngle(number, whose);
    else if (holds_alternative<double>(value) && isinf(most))
        checkNotNegative(number, whose);
    if (!(mayBeLeast ? number >= least : number > least) || !(number <= most))
        throw OpenMMException(whose + " must be " + getRange() + ", but is " + toText(number));
}

// ---- Moves ----

string MonteCarloMove::summarize() const
{
    string text = getSubject();
    for (const MoveParameter& parameter : getParameters())
        if (parameter.isSize)
            text +=
                " ±" + toText(std::get<double>(parameter.value)) + (parameter.unit == "1" ? "" : " " + parameter.unit);
    return text;
}

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

void MonteCarloMove::setNumSizeClasses(size_t count, const string& name)
{
    hasClasses = true;
    if (hasEqualScales())
        scales.assign(count, scales[0]);
    if (scales.size() != count)
        throw OpenMMException(name + " has " + to_string(scales.size()) + " scales, but its trials have " +
                              to_string(count) + " classes; call setMoveScale() to give all of them one scale");
}

bool MonteCarloMove::propose(TrialSession& trials, RandomNumberGenerator& random)
{
    proposal.clear();
    return draw(trials, random, proposal) && trials.propose(proposal);
}

double MonteCarloMove::computeWork(TrialSession&)
{
    return 0;
}

double MonteCarloMove::computeLogRatio(TrialSession&)
{
    return 0;
}
