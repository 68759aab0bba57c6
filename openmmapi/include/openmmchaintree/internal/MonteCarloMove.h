#ifndef OPENMM_MONTECARLOMOVE_H_
#define OPENMM_MONTECARLOMOVE_H_

#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/Proposal.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/SizeAdaptation.h"
#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace ChainTreePlugin {

class MonteCarloMove;

/**
 * A parameter of a move: its name, its bounds and its value. MoveDeclaration.h has the kinds of parameters.
 */
class OPENMM_EXPORT_CHAINTREE MoveParameter {
public:
    /**
     * A number, the indices of joints or molecules to choose from, empty for all, or many numbers.
     */
    typedef std::variant<double, int, std::vector<int>, std::vector<double>> Value;
    /**
     * Half a turn, computed with rounding.
     */
    static constexpr double LargestAngle = 3.14159265358979323846 * (1 + 1e-9);
    MoveParameter(const std::string& name, const Value& value, const std::string& text) :
        name(name), value(value), text(text)
    {
    }
    /**
     * Throw an exception unless a number is within its bounds.
     *
     * @param kind  the name of the MoveKind
     */
    void check(const std::string& kind) const;
    /**
     * Get the bounds of a number for people to read, as "from 0 to 1"; empty for lists.
     */
    std::string getRange() const;
    /** The name of the argument, in XML and in checkpoints. */
    std::string name;
    Value value;
    /** The name of a number in messages, as "largest angle"; the meaning of an empty list of indices, as "all". */
    std::string text;
    /** The unit of a number, as "nm^-2". */
    std::string unit = "1";
    double least = 0, most = std::numeric_limits<double>::infinity();
    bool mayBeLeast = true;
    /** Whether the scale of a move multiplies it. */
    bool isSize = false;
    /** Whether it is 1 for yes or 0 for no. */
    bool isFlag = false;
    /** The name of one of many values in XML, as "Torsion". */
    std::string element;
};

/**
 * A kind of move: its names, its parameters, and its reader of XML. Each kind is a constant in the file of its move;
 * the constructor registers it.
 */
class OPENMM_EXPORT_CHAINTREE MoveKind {
public:
    /**
     * Creates a move from the result of its write().
     */
    typedef std::unique_ptr<MonteCarloMove> Reader(const OpenMM::SerializationNode& node);
    /**
     * @param name        the name of such a move in messages, checkpoints and States, as "torsion"
     * @param element     the name of its element in XML, as "TorsionMove"
     * @param type        the result of TorsionMonteCarloIntegrator::getMoveType()
     * @param parameters  its parameters, with any values
     * @param read        the function that reads it
     */
    MoveKind(const std::string& name, const std::string& element, TorsionMonteCarloIntegrator::MoveType type,
             const std::vector<MoveParameter>& parameters, Reader& read);
    /**
     * Get the kind with this element in XML. It is an error if there is none.
     */
    static const MoveKind& find(const std::string& element);
    /**
     * Get all kinds, in the order of their elements.
     */
    static std::vector<const MoveKind*> getAll();
    /**
     * Get the unit of an argument of a method of TorsionMonteCarloIntegrator, "1" if no kind of move declares it.
     *
     * @param method    a name that contains the element of a kind, as "addTorsionMove"
     * @param argument  the name of a parameter
     */
    static std::string findUnit(const std::string& method, const std::string& argument);
    /**
     * Get the name of a kind for messages, as "a torsion move" or "an atom move".
     */
    static std::string withArticle(const std::string& name);
    const std::string name, element;
    const TorsionMonteCarloIntegrator::MoveType type;
    const std::vector<MoveParameter> parameters;
    Reader& read;
};

/**
 * A MonteCarloMove draws the trials of one kind of move.
 */
class OPENMM_EXPORT_CHAINTREE MonteCarloMove {
public:
    explicit MonteCarloMove(const MoveKind& kind) : kind(kind)
    {
    }
    virtual ~MonteCarloMove()
    {
    }
    const MoveKind& getKind() const
    {
        return kind;
    }
    /**
     * Get a short description: what moves, and how far, as "torsion ±0.2 rad".
     */
    std::string summarize() const;
    /**
     * Get the subject of summarize(). The default is the name of the kind.
     */
    virtual std::string getSubject() const
    {
        return kind.name;
    }
    /**
     * Get the parameters, which checkpoints, States and XML hold. Moves of the same kind with the same parameters draw
     * the same trials.
     */
    virtual std::vector<MoveParameter> getParameters() const = 0;
    /**
     * Write the XML for the kind's Reader. The default writes the parameters.
     */
    virtual void write(OpenMM::SerializationNode& node) const;
    /**
     * Find the joints or molecules to move. Each new Context calls this before propose().
     *
     * @param structure  the links of the molecules to move
     * @param name       the name of this move in error messages
     */
    virtual void bind(const LinkStructure& structure, const std::string& name) = 0;
    /**
     * Draw a trial and propose it. Returns false, with no trial open, if the trial is impossible. The present state
     * then counts once more, as after a rejected trial.
     */
    bool propose(TrialSession& trials, RandomNumberGenerator& random);
    /**
     * Get the logarithm of the ratio of two probability densities: of proposing the reverse of the open trial from the
     * proposed state, and of proposing the trial. It is minus infinity if there is no reverse. This is called once for
     * each trial without a clash.
     *
     * The default is 0, for moves whose trials and reverse trials are equally likely.
     */
    virtual double computeLogRatio(TrialSession& trials);
    /**
     * Get whether trials scale the periodic box, so that all of U changes. Their stages decide by the sum of changes.
     */
    virtual bool changesVolume() const
    {
        return false;
    }
    /**
     * Get whether trials displace particles within their links. The LinkStructure has to be flexible then.
     */
    virtual bool displacesParticles() const
    {
        return false;
    }
    /**
     * Get the work of the open trial, an energy in kJ/mol that decides about it together with the change of U. The
     * default is 0.
     */
    virtual double computeWork(TrialSession& trials);
    /**
     * Get whether the trials of this move have a size, which a scale multiplies.
     */
    virtual bool hasSize() const
    {
        return false;
    }
    /**
     * Get whether trials have classes of different sizes.
     */
    bool hasSizeClasses() const
    {
        return hasClasses;
    }
    /**
     * Get the class of the last trial. Each class has a scale of its own, so that its size adapts to its own
     * acceptance. The default is 0, for moves of a single class.
     */
    virtual size_t getSizeClass() const
    {
        return 0;
    }
    /**
     * Get the share of trials that are accepted once sizes have adapted.
     */
    virtual double getAim() const
    {
        return SizeAdaptation::AIM;
    }
    /**
     * Get the factor by which trials of a class are smaller than the parameters say.
     */
    double getScale(size_t sizeClass = 0) const
    {
        return scales[sizeClass];
    }
    /**
     * Set the factor of a class, in (0, 1].
     */
    void setScale(size_t sizeClass, double scale)
    {
        scales[sizeClass] = scale;
    }
    /**
     * Get or set the factors of all classes. A move that was never bound has a single one, or the ones that were set.
     */
    const std::vector<double>& getScales() const
    {
        return scales;
    }
    bool hasEqualScales() const
    {
        return std::adjacent_find(scales.begin(), scales.end(), std::not_equal_to<double>()) == scales.end();
    }
    void setScales(const std::vector<double>& scales)
    {
        this->scales = scales;
    }

protected:
    /**
     * Set the number of classes when the move is bound. Scales that are all equal become the scales of all classes;
     * otherwise it is an error if their number is another.
     *
     * @param name  the name of this move in error messages
     */
    void setNumSizeClasses(size_t count, const std::string& name);
    /**
     * Draw the changes of a trial. This is in the innermost loop of sampling: it allocates no memory. Returns false if
     * the trial is impossible, for example because a window does not close.
     *
     * @param trials            the session, for the present positions and torsions
     * @param[in,out] proposal  the changes are added here; it is empty at first
     */
    virtual bool draw(const TrialSession& trials, RandomNumberGenerator& random, Proposal& proposal) = 0;

private:
    const MoveKind& kind;
    std::vector<double> scales = {1};
    bool hasClasses = false;
    /** The changes of the last trial. They stay allocated from trial to trial. */
    Proposal proposal;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_MONTECARLOMOVE_H_*/
