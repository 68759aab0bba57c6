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
 * Turns an expression of a custom Force into the inputs and operations of a set of terms or pairs. First define each
 * name, then call translate(). The expression is simplified as in OpenMM, and repeated subexpressions are computed
 * once.
 */
class OPENMM_EXPORT_CHAINTREE ExpressionTranslator {
public:
    explicit ExpressionTranslator(EnergyTerms::TermSet& set);
    /**
     * Expressions of pairs have no input but the distance.
     */
    explicit ExpressionTranslator(EnergyTerms::PairSet& set);
    /**
     * The same for a value or term of a ValueEnergy. If it belongs to single particles, it has no input.
     */
    explicit ExpressionTranslator(EnergyTerms::ValueExpression& expression);
    ExpressionTranslator(const ExpressionTranslator&) = delete;
    ExpressionTranslator& operator=(const ExpressionTranslator&) = delete;
    /**
     * Define a name as a quantity measured from the particles of a term, which count from 0 within the term.
     */
    void addInput(const std::string& name, const ctInput& input);
    /**
     * Name the next parameter of a term or pair, and give the range of its values, if known.
     */
    void addParameter(const std::string& name, double low = -INFINITY, double high = INFINITY);
    /**
     * Skip parameters that have no name.
     */
    void skipParameters(int count);
    /**
     * Define a name as a number, such as the value of a global parameter.
     */
    void addConstant(const std::string& name, double value);
    /**
     * Name a particle, for the functions distance, angle and dihedral, and its coordinates, which are inputs.
     * Afterwards these functions and pointdistance, pointangle and pointdihedral are known.
     */
    void addParticle(const std::string& name, const std::array<std::string, 3>& coordinates, int particle);
    /**
     * Name a function of the coordinates of two points that is their distance, of nearest images in a periodic box.
     */
    void addDistanceFunction(const std::string& name);
    /**
     * Name a function that cannot be translated, and describe it for messages.
     */
    void addForeignFunction(const std::string& name, int numArguments, const std::string& description);
    /**
     * Name a tabulated function. Expressions of terms cannot have any. A kind of table that the library lacks is a
     * foreign function.
     */
    void addTable(const std::string& name, const OpenMM::TabulatedFunction& function);
    /**
     * Translate an expression. Returns an empty text, or else one clause that says why it cannot be translated.
     */
    std::string translate(const std::string& expression);
    /**
     * Name the parameters of the terms of a custom Force, and its global parameters, and translate its energy function.
     *
     * @param getParameterName  the method of the Force that returns the name of a parameter of a term
     * @param numParameters     the number of parameters of a term
     * @param globals           the values of global parameters
     */
    template <class T>
    std::string translateTerms(const T& force, const std::string& (T::*getParameterName)(int) const, int numParameters,
                               const std::map<std::string, double>& globals)
    {
        for (int i = 0; i < numParameters; i++)
            addParameter((force.*getParameterName)(i));
        for (int i = 0; i < force.getNumGlobalParameters(); i++)
            addConstant(force.getGlobalParameterName(i), globals.at(force.getGlobalParameterName(i)));
        return translate(force.getEnergyFunction());
    }

private:
    /** A tabulated function. */
    class NamedTable {
    public:
        EnergyTerms::TableFunction table;
        /** OpenMM's own evaluation of it. */
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
    /** The results. */
    std::vector<ctInput>& writtenInputs;
    std::vector<ctOperation>& operations;
    std::vector<EnergyTerms::TableFunction>& writtenTables;
    /** Used if the set of terms or pairs has no inputs or no tables. */
    std::vector<ctInput> noInputs;
    std::vector<EnergyTerms::TableFunction> noTables;
    /** All names except those of particles and functions, each once. */
    std::set<std::string> names;
    std::string repeatedName;
    std::map<std::string, ctInput> inputs;
    std::map<std::string, int> parameters, particles;
    std::vector<std::pair<double, double>> parameterRanges;
    std::map<std::string, double> constants;
    std::set<std::string> distanceFunctions;
    /** Their numbers of arguments and descriptions. */
    std::map<std::string, std::pair<int, std::string>> foreignFunctions;
    std::map<std::string, NamedTable> tables;
    /** The particles by the names of their coordinates. */
    std::map<std::array<std::string, 3>, int> points;
    /** The operations so far, by kind and arguments. */
    std::map<Key, int> known;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_EXPRESSIONTRANSLATOR_H_*/
