#ifndef OPENMM_CHAINTREE_MOVEDECLARATION_H_
#define OPENMM_CHAINTREE_MOVEDECLARATION_H_

#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <cctype>
#include <limits>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

/**
 * How a move is declared: its file lists its parameters once, in the order of the arguments of the integrator's
 * methods.
 *
 *     #define PIVOT_MOVE(P)                      \
 *         P(Angle, maxAngle, "largest angle")     \
 *         P(Indices, ballJoints, "all")
 *
 *     MOVE_PARAMETERS(PivotMove, PIVOT_MOVE)
 *
 *     class PivotMove : public DeclaredMove<PivotMoveParameters> {
 *         ...
 *     };
 *
 *     MOVE("pivot", PivotMove, PIVOT_MOVE)
 *
 * A parameter has a kind, one of the classes below, a name, and the other arguments of the constructor of that class.
 * Checks, XML, checkpoints, messages, units in Python, its type stub and a table in docs/moves.md follow from the list.
 * TorsionMonteCarloIntegrator.h declares the three methods that MOVE defines, and the MoveType.
 */
namespace ChainTreePlugin {

/**
 * A number, by default without unit and at least 0.
 */
class Number : public MoveParameter {
public:
    typedef double Type;
    Number(const std::string& name, double value, const std::string& text, const std::string& unit = "1",
           double least = 0, double most = std::numeric_limits<double>::infinity()) :
        MoveParameter(name, value, text)
    {
        this->unit = unit;
        this->least = least;
        this->most = most;
    }
    static double read(const OpenMM::SerializationNode& node, const std::string& name)
    {
        return node.getDoubleProperty(name);
    }
};

/**
 * An angle in radians, up to pi, that the scale of the move multiplies.
 */
class Angle : public Number {
public:
    enum Least { Zero, AboveZero };
    Angle(const std::string& name, double value, const std::string& text, Least least = Zero) :
        Number(name, value, text, "rad", 0, LargestAngle)
    {
        mayBeLeast = least == Zero;
        isSize = true;
    }
};

/**
 * A length in nm that the scale of the move multiplies.
 */
class Length : public Number {
public:
    Length(const std::string& name, double value, const std::string& text) : Number(name, value, text, "nm")
    {
        isSize = true;
    }
};

/**
 * A share of the whole, above 0 and at most 1, that the scale of the move multiplies.
 */
class Fraction : public Number {
public:
    Fraction(const std::string& name, double value, const std::string& text) : Number(name, value, text, "1", 0, 1)
    {
        mayBeLeast = false;
        isSize = true;
    }
};

/**
 * A number of things.
 */
class Count : public MoveParameter {
public:
    typedef int Type;
    Count(const std::string& name, int value, const std::string& text, int least,
          double most = std::numeric_limits<double>::infinity()) :
        MoveParameter(name, value, text)
    {
        this->least = least;
        this->most = most;
    }
    static int read(const OpenMM::SerializationNode& node, const std::string& name)
    {
        return node.getIntProperty(name);
    }
};

/**
 * A choice between yes and no, which XML and checkpoints hold as 1 or 0.
 */
class Flag : public MoveParameter {
public:
    typedef bool Type;
    Flag(const std::string& name, bool value, const std::string& text) : MoveParameter(name, (int)value, text)
    {
        isFlag = true;
    }
    static bool read(const OpenMM::SerializationNode& node, const std::string& name)
    {
        return node.getIntProperty(name) != 0;
    }
};

/**
 * The indices of the joints, particles or molecules that a move chooses from; the text says which these are if the list
 * is empty. The name is a plural, such as "ballJoints"; then an index is a BallJoint in XML.
 */
class Indices : public MoveParameter {
public:
    typedef std::vector<int> Type;
    Indices(const std::string& name, const std::vector<int>& value, const std::string& text) :
        MoveParameter(name, value, text)
    {
        element = name.substr(0, name.size() - 1);
        element[0] = std::toupper(element[0]);
    }
    static std::vector<int> read(const OpenMM::SerializationNode& node, const std::string& = "")
    {
        std::vector<int> indices;
        for (auto& child : node.getChildren())
            indices.push_back(child.getIntProperty("index"));
        return indices;
    }
};

/**
 * A move with the parameters that MOVE_PARAMETERS made, which are members of it.
 */
template <class Parameters>
class DeclaredMove : public MonteCarloMove, public Parameters {
public:
    explicit DeclaredMove(const Parameters& parameters) : MonteCarloMove(Parameters::KIND), Parameters(parameters)
    {
        for (const MoveParameter& parameter : this->list()) {
            parameter.check(Parameters::KIND.name);
            if (parameter.isSize && std::get<double>(parameter.value) > 0)
                isSized = true;
        }
    }
    std::vector<MoveParameter> getParameters() const
    {
        return this->list();
    }
    bool hasSize() const
    {
        return isSized;
    }

private:
    bool isSized = false;
};

/**
 * Create a declared move from XML.
 */
template <class Move>
std::unique_ptr<MonteCarloMove> readMove(const OpenMM::SerializationNode& node)
{
    return std::make_unique<Move>(Move::read(node));
}

/**
 * How the methods of the integrator take a value.
 */
template <class Type>
using MoveArgument = std::conditional_t<std::is_arithmetic_v<Type>, Type, const Type&>;

} // namespace ChainTreePlugin

// What becomes of each parameter of a list.

#define MOVE_MEMBER(KIND, NAME, ...) const KIND::Type NAME;
#define MOVE_ENTRY(KIND, NAME, ...) KIND(#NAME, NAME, __VA_ARGS__),
#define MOVE_READ(KIND, NAME, ...) KIND::read(node, #NAME),
#define MOVE_VALUE(KIND, NAME, ...) NAME,
#define MOVE_ARGUMENT(KIND, NAME, ...) , ChainTreePlugin::MoveArgument<KIND::Type> NAME
#define MOVE_RESULT(KIND, NAME, ...) , KIND::Type& NAME
#define MOVE_COPY(KIND, NAME, ...) NAME = found.NAME;

/**
 * Define the struct of the values of all parameters of a move: PivotMoveParameters for a PivotMove.
 */
#define MOVE_PARAMETERS(CLASS, LIST)                                                                                   \
    namespace {                                                                                                        \
    struct CLASS##Parameters {                                                                                         \
        static const ChainTreePlugin::MoveKind KIND;                                                                   \
        LIST(MOVE_MEMBER)                                                                                              \
        std::vector<ChainTreePlugin::MoveParameter> list() const                                                       \
        {                                                                                                              \
            return {LIST(MOVE_ENTRY)};                                                                                 \
        }                                                                                                              \
        static CLASS##Parameters read(const OpenMM::SerializationNode& node)                                           \
        {                                                                                                              \
            return {LIST(MOVE_READ)};                                                                                  \
        }                                                                                                              \
    };                                                                                                                 \
    }

/**
 * Make a move known by a name and a MoveType.
 */
#define MOVE_KIND(NAME, CLASS, TYPE)                                                                                   \
    const ChainTreePlugin::MoveKind CLASS##Parameters::KIND(NAME, #CLASS, TYPE, CLASS##Parameters{}.list(),            \
                                                            ChainTreePlugin::readMove<CLASS>);

/**
 * Make a move of this library known, and define the methods of the integrator that add it and get and set its
 * parameters.
 */
#define MOVE(NAME, CLASS, LIST)                                                                                        \
    MOVE_KIND(NAME, CLASS, ChainTreePlugin::TorsionMonteCarloIntegrator::CLASS)                                        \
    int ChainTreePlugin::TorsionMonteCarloIntegrator::add##CLASS(double weight LIST(MOVE_ARGUMENT))                    \
    {                                                                                                                  \
        return addMove(std::make_unique<::CLASS>(CLASS##Parameters{LIST(MOVE_VALUE)}), weight);                        \
    }                                                                                                                  \
    void ChainTreePlugin::TorsionMonteCarloIntegrator::get##CLASS##Parameters(int move,                                \
                                                                              double& weight LIST(MOVE_RESULT)) const  \
    {                                                                                                                  \
        const CLASS##Parameters& found = moves->get<::CLASS>(move, weight);                                            \
        LIST(MOVE_COPY)                                                                                                \
    }                                                                                                                  \
    void ChainTreePlugin::TorsionMonteCarloIntegrator::set##CLASS##Parameters(int move,                                \
                                                                              double weight LIST(MOVE_ARGUMENT))       \
    {                                                                                                                  \
        setMove(move, std::make_unique<::CLASS>(CLASS##Parameters{LIST(MOVE_VALUE)}), weight);                         \
    }

#endif /*OPENMM_CHAINTREE_MOVEDECLARATION_H_*/
