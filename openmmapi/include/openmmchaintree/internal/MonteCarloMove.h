#ifndef OPENMM_MONTECARLOMOVE_H_
#define OPENMM_MONTECARLOMOVE_H_

#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace ChainTreePlugin {

/**
 * A kind of move: what it is called, and how one is read from XML. To create a MoveKind is to make it known, so each
 * kind is a constant in the file of its move. A new kind of move takes nothing but such a file, a MoveType, and the
 * method of TorsionMonteCarloIntegrator that adds it, which is defined in that file, too.
 */
class OPENMM_EXPORT_CHAINTREE MoveKind {
public:
    /**
     * Reads the parameters that a move's getParameters() gave and adds the move to an integrator.
     */
    typedef void Reader(const OpenMM::SerializationNode& node, double weight, TorsionMonteCarloIntegrator& integrator);
    /**
     * @param name     what messages, checkpoints and States call a move of this kind, as "torsion"
     * @param element  the name of its element in XML, as "TorsionMove"
     * @param type     what TorsionMonteCarloIntegrator::getMoveType() returns
     * @param read     the function that reads it
     */
    MoveKind(const std::string& name, const std::string& element, TorsionMonteCarloIntegrator::MoveType type,
             Reader& read);
    /**
     * Get the kind with this element in XML. It is an error if there is none.
     */
    static const MoveKind& find(const std::string& element);
    const std::string name, element;
    const TorsionMonteCarloIntegrator::MoveType type;
    Reader& read;
};

/**
 * A parameter of a move: a number, the indices of what it chooses from, empty for all, or many numbers.
 */
class MoveParameter {
public:
    std::string name;
    std::variant<double, int, std::vector<int>, std::vector<double>> value;
    /** What one of the indices or of many numbers is called in XML, as "Torsion". */
    std::string element;
};

/**
 * Read the indices that are the children of a node.
 */
OPENMM_EXPORT_CHAINTREE std::vector<int> readIndices(const OpenMM::SerializationNode& node);

/**
 * Write how far a move goes, for people to read: the sign, six digits at most, and the unit.
 */
OPENMM_EXPORT_CHAINTREE std::string toSize(double largest, const std::string& unit);

/**
 * Throw an exception if an angle is more than any move needs. Mostly it is one in degrees.
 *
 * @param angle  the angle, in radians
 * @param name   what the message calls it, the class it belongs to included
 */
OPENMM_EXPORT_CHAINTREE void checkAngle(double angle, const std::string& name);

/**
 * The same of the largest angle of a move.
 *
 * @param angle  the angle, in radians
 * @param kind   the name of its MoveKind
 */
OPENMM_EXPORT_CHAINTREE void checkLargestAngle(double angle, const std::string& kind);

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
     * Get a few words about it for people to read: what moves, and how far, as "torsion ±0.2 rad".
     */
    virtual std::string summarize() const = 0;
    /**
     * Get what decides the trials of this move. Checkpoints, States and XML hold it. Moves of the same kind and with
     * the same parameters draw the same trials.
     */
    virtual std::vector<MoveParameter> getParameters() const = 0;
    /**
     * Write to XML what the kind's Reader reads. It is the parameters, unless a move has a better form for them.
     */
    virtual void write(OpenMM::SerializationNode& node) const;
    /**
     * Find out what there is to move. This is called before propose(), and again whenever the Context is another one.
     *
     * @param structure  the links of the molecules to move
     * @param name       what to call this move when throwing an exception, because it names what does not exist
     */
    virtual void bind(const LinkStructure& structure, const std::string& name) = 0;
    /**
     * Draw a trial and open it. This is the innermost loop of sampling: it allocates no memory. Returns false, with no
     * trial open, if what was drawn cannot be made, as a window that does not close. The present state then counts once
     * more, as after any refused trial.
     */
    virtual bool propose(TrialSession& trials, RandomNumberGenerator& random) = 0;
    /**
     * Get the logarithm of the probability density of proposing the reverse of the open trial, from where it leads,
     * divided by that of proposing it; minus infinity if nothing can lead back. This is asked only about trials without
     * a clash, once each, so what it costs is spent on no other.
     *
     * A move whose trials and their reverses are equally likely can leave it at 0.
     */
    virtual double computeLogRatio(TrialSession& trials);
    /**
     * Get whether the trials of this move have a size, so that setScale() has an effect.
     */
    virtual bool hasSize() const
    {
        return false;
    }
    /**
     * Get the factor by which trials are smaller than the parameters say. See setScale().
     */
    double getScale() const
    {
        return scale;
    }
    /**
     * Make trials smaller than the parameters say.
     *
     * @param scale  a factor in (0, 1]
     */
    void setScale(double scale)
    {
        this->scale = scale;
    }

private:
    const MoveKind& kind;
    double scale = 1;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_MONTECARLOMOVE_H_*/
