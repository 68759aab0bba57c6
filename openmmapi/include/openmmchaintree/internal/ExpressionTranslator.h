#ifndef OPENMM_CHAINTREE_EXPRESSIONTRANSLATOR_H_
#define OPENMM_CHAINTREE_EXPRESSIONTRANSLATOR_H_

#include "lepton/CustomFunction.h"
#include "lepton/ExpressionTreeNode.h"
#include "openmm/TabulatedFunction.h"
#include "openmmchaintree/internal/EnergyTerms.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * Turns an expression, as custom Forces have it, into the inputs and operations of a set of terms or of pairs. First
 * say what each name means, then translate(). The expression is simplified as OpenMM does it; what appears more than
 * once is computed once.
 */
class OPENMM_EXPORT_CHAINTREE ExpressionTranslator {
public:
    explicit ExpressionTranslator(EnergyTerms::TermSet& set);
    /**
     * Of pairs, the one input there may be is the distance.
     */
    explicit ExpressionTranslator(EnergyTerms::PairSet& set);
    /**
     * The same of a value or term of a ValueEnergy, which may be of particles: then it has no input.
     */
    explicit ExpressionTranslator(EnergyTerms::ValueExpression& expression);
    ExpressionTranslator(const ExpressionTranslator&) = delete;
    ExpressionTranslator& operator=(const ExpressionTranslator&) = delete;
    /**
     * A name that is measured of the particles of a term. Particles count from 0 within the term.
     */
    void addInput(const std::string& name, const ctInput& input);
    /**
     * A name for the next parameter of a term or pair, and the range of its values, if that is known.
     */
    void addParameter(const std::string& name, double low = -INFINITY, double high = INFINITY);
    /**
     * Leave out parameters that have no name.
     */
    void skipParameters(int count);
    /**
     * A name for a number, as a global parameter has it.
     */
    void addConstant(const std::string& name, double value);
    /**
     * The name of a particle, which the functions distance, angle and dihedral take; so they and their counterparts
     * pointdistance, pointangle and pointdihedral are known. The names of its coordinates are inputs.
     */
    void addParticle(const std::string& name, const std::array<std::string, 3>& coordinates, int particle);
    /**
     * The name of a function whose expressions cannot be translated, and what to call it.
     */
    void addForeignFunction(const std::string& name, int numArguments, const std::string& description);
    /**
     * The name of a tabulated function, which expressions of terms cannot have. If the library has no such tables, it
     * is a foreign one.
     */
    void addTable(const std::string& name, const OpenMM::TabulatedFunction& function);
    /**
     * Translate an expression. Returns an empty text, or else one clause that says why it cannot be translated.
     */
    std::string translate(const std::string& expression);

private:
    /** A tabulated function. */
    class NamedTable {
    public:
        EnergyTerms::TableFunction table;
        /** The same as OpenMM evaluates it. */
        std::unique_ptr<Lepton::CustomFunction> function;
        /** Its index among the names that the expression uses; -1 if unused. */
        int index;
    };
    typedef std::tuple<int, int, int, int, unsigned long long> Key;
    int translateNode(const Lepton::ExpressionTreeNode& node);
    int translateVariable(const std::string& name);
    int translateFunction(const Lepton::ExpressionTreeNode& node);
    int keepWithin(int operation, int size);
    int translateTable(NamedTable& table, const std::vector<Lepton::ExpressionTreeNode>& children);
    int translateDistance(const std::vector<Lepton::ExpressionTreeNode>& coordinates);
    int shorten(ctOperator kind, const std::array<int, 3>& arguments);
    int addMeasure(const ctInput& added);
    int addOperation(ctOperator kind, const std::array<int, 3>& arguments, double constant = 0);
    void addName(const std::string& name);
    void keepWhatIsUsed(int result);
    /** What is written. */
    std::vector<ctInput>& writtenInputs;
    std::vector<ctOperation>& operations;
    std::vector<EnergyTerms::TableFunction>& writtenTables;
    /** What the set of terms or pairs does not have. */
    std::vector<ctInput> noInputs;
    std::vector<EnergyTerms::TableFunction> noTables;
    /** All names except those of particles and functions, each once. */
    std::set<std::string> names;
    std::string repeatedName;
    std::map<std::string, ctInput> inputs;
    std::map<std::string, int> parameters, particles;
    std::vector<std::pair<double, double>> parameterRanges;
    std::map<std::string, double> constants;
    /** How many arguments they take, and their descriptions. */
    std::map<std::string, std::pair<int, std::string>> foreignFunctions;
    std::map<std::string, NamedTable> tables;
    /** The particles by the names of their coordinates. */
    std::map<std::array<std::string, 3>, int> points;
    /** The operations there are, by what they do. */
    std::map<Key, int> known;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_EXPRESSIONTRANSLATOR_H_*/
