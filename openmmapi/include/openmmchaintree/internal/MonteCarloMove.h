#ifndef OPENMM_MONTECARLOMOVE_H_
#define OPENMM_MONTECARLOMOVE_H_

#include "openmmchaintree/ChainTreeKernels.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * What a move is, in names and values. Moves with the same description draw the same trials.
 */
typedef std::vector<std::pair<std::string, std::string>> MoveDescription;

/**
 * Write a number so that it is read as the same one, in as few digits as this takes.
 */
std::string toText(double value);

/**
 * A MonteCarloMove draws the trials of one kind of move. A trial and its reverse must be equally likely.
 */
class MonteCarloMove {
public:
    virtual ~MonteCarloMove()
    {
    }
    virtual TorsionMonteCarloIntegrator::MoveType getType() const = 0;
    virtual MoveDescription describe() const = 0;
    /**
     * Find out what there is to move. This is called before propose(), and again whenever the Context is another one.
     *
     * @param structure  the links of the molecules to move
     * @param name       what to call this move when throwing an exception, because it names what does not exist
     */
    virtual void bind(const LinkStructure& structure, const std::string& name) = 0;
    /**
     * Draw a trial and open it. This is the innermost loop of sampling: it allocates no memory.
     */
    virtual void propose(CalcStericExclusionForceKernel& kernel, RandomNumberGenerator& random) = 0;
};

/**
 * Turns a number of different torsions, each by a uniform angle. See TorsionMonteCarloIntegrator::addTorsionMove().
 */
class TorsionMove : public MonteCarloMove {
public:
    TorsionMove(double maxAngle, const std::vector<int>& torsions, int count);
    TorsionMonteCarloIntegrator::MoveType getType() const
    {
        return TorsionMonteCarloIntegrator::TorsionMove;
    }
    MoveDescription describe() const;
    double getMaxAngle() const
    {
        return maxAngle;
    }
    /** Get the torsions to choose from as they were given; empty for all. */
    const std::vector<int>& getTorsions() const
    {
        return torsions;
    }
    int getCount() const
    {
        return count;
    }
    void bind(const LinkStructure& structure, const std::string& name);
    void propose(CalcStericExclusionForceKernel& kernel, RandomNumberGenerator& random);

private:
    const double maxAngle;
    const std::vector<int> torsions;
    const int count;
    /** The torsions to choose from: those given, or all. */
    std::vector<int> choices;
    std::vector<bool> isDrawn;
    std::vector<int> drawnChoices, drawnTorsions;
    std::vector<double> drawnChanges;
};

/**
 * Moves a whole molecule as a rigid body. See TorsionMonteCarloIntegrator::addRigidBodyMove().
 */
class RigidBodyMove : public MonteCarloMove {
public:
    RigidBodyMove(double maxTranslation, double maxAngle, const std::vector<int>& molecules);
    TorsionMonteCarloIntegrator::MoveType getType() const
    {
        return TorsionMonteCarloIntegrator::RigidBodyMove;
    }
    MoveDescription describe() const;
    double getMaxTranslation() const
    {
        return maxTranslation;
    }
    double getMaxAngle() const
    {
        return maxAngle;
    }
    /** Get the molecules to choose from, each named by one of its particles; empty for all that can move. */
    const std::vector<int>& getMolecules() const
    {
        return molecules;
    }
    void bind(const LinkStructure& structure, const std::string& name);
    void propose(CalcStericExclusionForceKernel& kernel, RandomNumberGenerator& random);

private:
    const double maxTranslation, maxAngle;
    const std::vector<int> molecules;
    /** The molecules to choose from, by their indices in the LinkStructure. */
    std::vector<int> choices;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_MONTECARLOMOVE_H_*/
