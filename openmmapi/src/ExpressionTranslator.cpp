#include "openmmchaintree/internal/ExpressionTranslator.h"
#include "lepton/CustomFunction.h"
#include "lepton/Operation.h"
#include "lepton/ParsedExpression.h"
#include "lepton/Parser.h"
#include "openmmchaintree/internal/TabulatedFunctions.h"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;
using Lepton::ExpressionTreeNode;

namespace {

/**
 * Says why an expression cannot be translated.
 */
class Untranslatable : public runtime_error {
public:
    using runtime_error::runtime_error;
};

/**
 * Replaces a function whose values the parser does not need. Its value would be NaN, which cannot be mistaken for an
 * energy.
 */
class Placeholder : public Lepton::CustomFunction {
public:
    explicit Placeholder(int numArguments) : numArguments(numArguments)
    {
    }
    int getNumArguments() const
    {
        return numArguments;
    }
    double evaluate(const double*) const
    {
        return numeric_limits<double>::quiet_NaN();
    }
    double evaluateDerivative(const double*, const int*) const
    {
        return numeric_limits<double>::quiet_NaN();
    }
    CustomFunction* clone() const
    {
        return new Placeholder(numArguments);
    }

private:
    const int numArguments;
};

/**
 * A function of particles, or of points.
 */
class MeasuringFunction {
public:
    const char* name;
    ctMeasure measure;
    int numPoints;
    /** Whether it takes the coordinates of points instead of the names of particles. */
    bool takesCoordinates;
};

} // namespace

static const MeasuringFunction MEASURING_FUNCTIONS[] = {
    {"distance", ctMeasureDistance, 2, false}, {"angle", ctMeasureAngle, 3, false},
    {"dihedral", ctMeasureDihedral, 4, false}, {"pointdistance", ctMeasureDistance, 2, true},
    {"pointangle", ctMeasureAngle, 3, true},   {"pointdihedral", ctMeasureDihedral, 4, true},
};

static const MeasuringFunction& findMeasuringFunction(const string& name)
{
    for (const MeasuringFunction& function : MEASURING_FUNCTIONS)
        if (name == function.name)
            return function;
    throw Untranslatable("its expression has an unknown function, " + name);
}

/**
 * Get the name of a variable; empty if it is something else.
 */
static string getVariable(const ExpressionTreeNode& node)
{
    return node.getOperation().getId() == Lepton::Operation::VARIABLE ? node.getOperation().getName() : "";
}

static ctOperator findOperator(Lepton::Operation::Id id)
{
    typedef Lepton::Operation In;
    static const map<In::Id, ctOperator> operators = {{In::ADD, ctAddOperator},
                                                      {In::SUBTRACT, ctSubtractOperator},
                                                      {In::MULTIPLY, ctMultiplyOperator},
                                                      {In::DIVIDE, ctDivideOperator},
                                                      {In::POWER, ctPowerOperator},
                                                      {In::NEGATE, ctNegateOperator},
                                                      {In::SQRT, ctSqrtOperator},
                                                      {In::EXP, ctExpOperator},
                                                      {In::LOG, ctLogOperator},
                                                      {In::SIN, ctSinOperator},
                                                      {In::COS, ctCosOperator},
                                                      {In::SEC, ctSecOperator},
                                                      {In::CSC, ctCscOperator},
                                                      {In::TAN, ctTanOperator},
                                                      {In::COT, ctCotOperator},
                                                      {In::ASIN, ctAsinOperator},
                                                      {In::ACOS, ctAcosOperator},
                                                      {In::ATAN, ctAtanOperator},
                                                      {In::ATAN2, ctAtan2Operator},
                                                      {In::SINH, ctSinhOperator},
                                                      {In::COSH, ctCoshOperator},
                                                      {In::TANH, ctTanhOperator},
                                                      {In::ERF, ctErfOperator},
                                                      {In::ERFC, ctErfcOperator},
                                                      {In::STEP, ctStepOperator},
                                                      {In::DELTA, ctDeltaOperator},
                                                      {In::SQUARE, ctSquareOperator},
                                                      {In::CUBE, ctCubeOperator},
                                                      {In::RECIPROCAL, ctReciprocalOperator},
                                                      {In::ADD_CONSTANT, ctAddConstantOperator},
                                                      {In::MULTIPLY_CONSTANT, ctMultiplyConstantOperator},
                                                      {In::POWER_CONSTANT, ctPowerConstantOperator},
                                                      {In::MIN, ctMinOperator},
                                                      {In::MAX, ctMaxOperator},
                                                      {In::ABS, ctAbsOperator},
                                                      {In::FLOOR, ctFloorOperator},
                                                      {In::CEIL, ctCeilOperator},
                                                      {In::SELECT, ctSelectOperator}};
    auto found = operators.find(id);
    if (found == operators.end())
        throw Untranslatable("its expression has an operation that openmm-chaintree does not know");
    return found->second;
}

/**
 * Get the constant of an operation; 0 if it has none.
 */
static double getOwnConstant(const Lepton::Operation& operation)
{
    switch (operation.getId()) {
    case Lepton::Operation::ADD_CONSTANT:
        return dynamic_cast<const Lepton::Operation::AddConstant&>(operation).getValue();
    case Lepton::Operation::MULTIPLY_CONSTANT:
        return dynamic_cast<const Lepton::Operation::MultiplyConstant&>(operation).getValue();
    case Lepton::Operation::POWER_CONSTANT:
        return dynamic_cast<const Lepton::Operation::PowerConstant&>(operation).getValue();
    default:
        return 0;
    }
}

// ---- Names ----

ExpressionTranslator::ExpressionTranslator(EnergyTerms::TermSet& set) :
    writtenInputs(set.inputs), operations(set.operations), writtenTables(noTables)
{
}

ExpressionTranslator::ExpressionTranslator(EnergyTerms::PairSet& set) :
    writtenInputs(noInputs), operations(set.operations), writtenTables(set.tables)
{
}

ExpressionTranslator::ExpressionTranslator(EnergyTerms::ValueExpression& expression) :
    writtenInputs(noInputs), operations(expression.operations), writtenTables(expression.tables)
{
}

void ExpressionTranslator::addName(const string& name)
{
    if (!names.insert(name).second)
        repeatedName = name;
}

void ExpressionTranslator::addInput(const string& name, const ctInput& input)
{
    addName(name);
    inputs[name] = input;
}

void ExpressionTranslator::addParameter(const string& name, double low, double high)
{
    addName(name);
    parameters[name] = parameterRanges.size();
    parameterRanges.push_back(make_pair(low, high));
}

void ExpressionTranslator::skipParameters(int count)
{
    parameterRanges.insert(parameterRanges.end(), count, make_pair(-INFINITY, INFINITY));
}

void ExpressionTranslator::addConstant(const string& name, double value)
{
    addName(name);
    constants[name] = value;
}

void ExpressionTranslator::addParticle(const string& name, const array<string, 3>& coordinates, int particle)
{
    particles[name] = particle;
    points[coordinates] = particle;
    addInput(coordinates[0], {ctMeasureX, {particle}});
    addInput(coordinates[1], {ctMeasureY, {particle}});
    addInput(coordinates[2], {ctMeasureZ, {particle}});
}

void ExpressionTranslator::addDistanceFunction(const string& name)
{
    distanceFunctions.insert(name);
}

void ExpressionTranslator::addForeignFunction(const string& name, int numArguments, const string& description)
{
    foreignFunctions[name] = make_pair(numArguments, description);
}

void ExpressionTranslator::addTable(const string& name, const TabulatedFunction& function)
{
    NamedTable& entry = tables[name];
    if (!ChainTreePlugin::translateTable(function, entry.table)) {
        tables.erase(name);
        addForeignFunction(name, countArguments(function), "the tabulated function " + name);
        return;
    }
    entry.function = createFunction(function);
    entry.index = -1;
}

// ---- Operations ----

int ExpressionTranslator::addOperation(ctOperator kind, const array<int, 3>& arguments, double constant)
{
    unsigned long long bits;
    static_assert(sizeof bits == sizeof constant, "the key holds the bits of a double");
    memcpy(&bits, &constant, sizeof bits);
    const Key key(kind, arguments[0], arguments[1], arguments[2], bits);
    auto found = known.find(key);
    if (found != known.end())
        return found->second;
    const int index = operations.size();
    operations.push_back({kind, {arguments[0], arguments[1], arguments[2]}, constant});
    known[key] = index;
    return index;
}

int ExpressionTranslator::addMeasure(const ctInput& added)
{
    auto found = find_if(writtenInputs.begin(), writtenInputs.end(), [&](const ctInput& input) {
        return input.measure == added.measure && equal(begin(input.particles), end(input.particles), added.particles);
    });
    const int index = found - writtenInputs.begin();
    if (found == writtenInputs.end())
        writtenInputs.push_back(added);
    return addOperation(ctInputOperator, {index});
}

int ExpressionTranslator::translateVariable(const string& name)
{
    auto input = inputs.find(name);
    if (input != inputs.end())
        return addMeasure(input->second);
    auto parameter = parameters.find(name);
    if (parameter != parameters.end())
        return addOperation(ctParameterOperator, {parameter->second});
    auto constant = constants.find(name);
    if (constant != constants.end())
        return addOperation(ctConstantOperator, {}, constant->second);
    throw Untranslatable("its expression has an unknown variable, " + name);
}

/**
 * Measure the distance of points from their coordinates.
 */
int ExpressionTranslator::translateDistance(const vector<ExpressionTreeNode>& coordinates)
{
    array<int, 3> differences;
    for (int i = 0; i < 3; i++) {
        const int first = translateNode(coordinates[i]), second = translateNode(coordinates[i + 3]);
        differences[i] = addOperation(ctSubtractOperator, {first, second});
    }
    return addOperation(ctImageLengthOperator, differences);
}

/**
 * Clamp the index of a discrete table to its range, as OpenMM does.
 */
int ExpressionTranslator::keepWithin(int operation, int size)
{
    const ctOperation& index = operations[operation];
    if (index.kind == ctParameterOperator) {
        const pair<double, double>& range = parameterRanges[index.arguments[0]];
        if (range.first >= 0 && range.second <= size - 1)
            return operation;
    }
    const int first = addOperation(ctConstantOperator, {}, 0);
    const int last = addOperation(ctConstantOperator, {}, size - 1);
    return addOperation(ctMinOperator, {addOperation(ctMaxOperator, {operation, first}), last});
}

int ExpressionTranslator::translateTable(NamedTable& table, const vector<ExpressionTreeNode>& children)
{
    array<int, 3> arguments = {};
    double values[3] = {};
    bool allAreKnown = true;
    for (size_t i = 0; i < children.size(); i++) {
        arguments[i] = translateNode(children[i]);
        const ctOperation& argument = operations[arguments[i]];
        values[i] = argument.constant;
        allAreKnown &= argument.kind == ctConstantOperator;
    }
    if (allAreKnown)
        return addOperation(ctConstantOperator, {}, table.function->evaluate(values));
    if (table.index == -1) {
        table.index = writtenTables.size();
        writtenTables.push_back(table.table);
    }
    for (size_t i = 0; i < children.size() && table.table.discrete; i++)
        arguments[i] = keepWithin(arguments[i], table.table.sizes[i]);
    return addOperation(ctTableOperator, arguments, table.index);
}

int ExpressionTranslator::translateFunction(const ExpressionTreeNode& node)
{
    const string name = node.getOperation().getName();
    auto foreign = foreignFunctions.find(name);
    if (foreign != foreignFunctions.end())
        throw Untranslatable("its expression uses " + foreign->second.second);
    auto table = tables.find(name);
    if (table != tables.end())
        return translateTable(table->second, node.getChildren());
    if (distanceFunctions.count(name) != 0)
        return translateDistance(node.getChildren());
    const MeasuringFunction& function = findMeasuringFunction(name);
    const vector<ExpressionTreeNode>& arguments = node.getChildren();
    vector<int> measured;
    for (int i = 0; i < function.numPoints; i++)
        if (!function.takesCoordinates) {
            auto particle = particles.find(getVariable(arguments[i]));
            if (particle != particles.end())
                measured.push_back(particle->second);
        }
        else {
            array<string, 3> point;
            for (int j = 0; j < 3; j++)
                point[j] = getVariable(arguments[3 * i + j]);
            auto particle = points.find(point);
            if (particle != points.end())
                measured.push_back(particle->second);
        }
    if ((int)measured.size() < function.numPoints) {
        if (function.takesCoordinates && function.measure == ctMeasureDistance)
            return translateDistance(arguments);
        throw Untranslatable("its expression takes " + name + " of points that are not particles");
    }
    if (std::set<int>(measured.begin(), measured.end()).size() < measured.size())
        throw Untranslatable("its expression takes " + name + " of one particle twice");

    // The values are the same for the reverse order.

    if (measured.front() > measured.back())
        reverse(measured.begin(), measured.end());
    ctInput ordered = {function.measure, {}};
    copy(measured.begin(), measured.end(), ordered.particles);
    return addMeasure(ordered);
}

/**
 * Append the shorter form of an operation with a known number. Returns -1 if there is none.
 */
int ExpressionTranslator::shorten(ctOperator kind, const array<int, 3>& arguments)
{
    const ctOperation first = operations[arguments[0]], second = operations[arguments[1]];
    const bool firstIsKnown = first.kind == ctConstantOperator, secondIsKnown = second.kind == ctConstantOperator;
    switch (kind) {
    case ctAddOperator:
        if (secondIsKnown)
            return addOperation(ctAddConstantOperator, {arguments[0]}, second.constant);
        return firstIsKnown ? addOperation(ctAddConstantOperator, {arguments[1]}, first.constant) : -1;
    case ctSubtractOperator:
        return secondIsKnown ? addOperation(ctAddConstantOperator, {arguments[0]}, -second.constant) : -1;
    case ctMultiplyOperator:
        if (secondIsKnown)
            return addOperation(ctMultiplyConstantOperator, {arguments[0]}, second.constant);
        return firstIsKnown ? addOperation(ctMultiplyConstantOperator, {arguments[1]}, first.constant) : -1;
    case ctPowerOperator:
        if (!secondIsKnown)
            return -1;
        if (second.constant == 1)
            return arguments[0];
        if (second.constant == 2)
            return addOperation(ctSquareOperator, {arguments[0]});
        if (second.constant == 3)
            return addOperation(ctCubeOperator, {arguments[0]});
        return addOperation(ctPowerConstantOperator, {arguments[0]}, second.constant);
    case ctSelectOperator:
        return firstIsKnown ? arguments[first.constant != 0 ? 1 : 2] : -1;
    default:
        return -1;
    }
}

int ExpressionTranslator::translateNode(const ExpressionTreeNode& node)
{
    const Lepton::Operation& operation = node.getOperation();
    switch (operation.getId()) {
    case Lepton::Operation::CONSTANT:
        return addOperation(ctConstantOperator, {},
                            dynamic_cast<const Lepton::Operation::Constant&>(operation).getValue());
    case Lepton::Operation::VARIABLE:
        return translateVariable(operation.getName());
    case Lepton::Operation::CUSTOM:
        return translateFunction(node);
    default:
        break;
    }
    const ctOperator kind = findOperator(operation.getId());
    array<int, 3> arguments = {};
    double values[3] = {};
    bool allAreKnown = true;
    for (size_t i = 0; i < node.getChildren().size(); i++) {
        arguments[i] = translateNode(node.getChildren()[i]);
        const ctOperation& argument = operations[arguments[i]];
        values[i] = argument.constant;
        allAreKnown &= argument.kind == ctConstantOperator;
    }
    if (allAreKnown)
        return addOperation(ctConstantOperator, {}, operation.evaluate(values, {}));
    if (node.getChildren().size() > 1) {
        const int shorter = shorten(kind, arguments);
        if (shorter != -1)
            return shorter;
    }

    // Sums and products are symmetric.

    if ((kind == ctAddOperator || kind == ctMultiplyOperator) && arguments[0] > arguments[1])
        swap(arguments[0], arguments[1]);
    return addOperation(kind, arguments, getOwnConstant(operation));
}

// ---- Expressions ----

/**
 * Get the number of arguments that are earlier operations.
 */
static int countResults(const ctOperation& operation, const vector<EnergyTerms::TableFunction>& tables)
{
#define COUNT_CASE(name, count, value)                                                                                 \
    case ct##name##Operator:                                                                                           \
        return count;
    switch (operation.kind) {
        CT_OPERATORS(COUNT_CASE)
    case ctImageLengthOperator:
        return 3;
    case ctTableOperator:
        return tables[(int)operation.constant].dimensions;
    default:
        return 0;
    }
#undef COUNT_CASE
}

/**
 * Keep the operations and inputs that a result depends on, and make it the last one.
 */
void ExpressionTranslator::keepWhatIsUsed(int result)
{
    const vector<ctOperation> all(operations.begin(), operations.begin() + result + 1);
    const vector<ctInput> allInputs = writtenInputs;
    vector<bool> isUsed(all.size());
    isUsed[result] = true;
    for (int i = result; i >= 0; i--)
        for (int j = 0; isUsed[i] && j < countResults(all[i], writtenTables); j++)
            isUsed[all[i].arguments[j]] = true;
    operations.clear();
    writtenInputs.clear();
    vector<int> newIndex(all.size()), newInput(allInputs.size(), -1);
    for (int i = 0; i <= result; i++) {
        if (!isUsed[i])
            continue;
        ctOperation operation = all[i];
        for (int j = 0; j < countResults(operation, writtenTables); j++)
            operation.arguments[j] = newIndex[operation.arguments[j]];
        if (operation.kind == ctInputOperator) {
            int& input = newInput[operation.arguments[0]];
            if (input == -1) {
                input = writtenInputs.size();
                writtenInputs.push_back(allInputs[operation.arguments[0]]);
            }
            operation.arguments[0] = input;
        }
        newIndex[i] = operations.size();
        operations.push_back(operation);
    }
}

string ExpressionTranslator::translate(const string& expression)
{
    vector<unique_ptr<Placeholder>> placeholders;
    map<string, Lepton::CustomFunction*> functions;
    auto addFunction = [&](const string& name, Lepton::CustomFunction* function) {
        if (!functions.insert(make_pair(name, function)).second)
            repeatedName = name;
    };
    auto addPlaceholder = [&](const string& name, int numArguments) {
        placeholders.push_back(make_unique<Placeholder>(numArguments));
        addFunction(name, placeholders.back().get());
    };
    for (const string& name : distanceFunctions)
        addPlaceholder(name, 6);
    for (auto& foreign : foreignFunctions)
        addPlaceholder(foreign.first, foreign.second.first);
    for (auto& table : tables)
        addFunction(table.first, table.second.function.get());
    if (!particles.empty())
        for (const MeasuringFunction& function : MEASURING_FUNCTIONS)
            addPlaceholder(function.name, function.numPoints * (function.takesCoordinates ? 3 : 1));
    if (!repeatedName.empty())
        return "the name " + repeatedName + " means two things in its expression";
    try {
        Lepton::ParsedExpression parsed = Lepton::Parser::parse(expression, functions).optimize();
        keepWhatIsUsed(translateNode(parsed.getRootNode()));
    }
    catch (const Untranslatable& reason) {
        return reason.what();
    }
    return "";
}
