#ifndef OPENMM_CHAINTREE_MOVELIST_H_
#define OPENMM_CHAINTREE_MOVELIST_H_

#include "openmm/internal/AssertionUtilities.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/LinkStructure.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/SizeAdaptation.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * The moves of a TorsionMonteCarloIntegrator: their weights, the results of their trials, and their checkpoints. It
 * depends on no kind of move.
 */
class OPENMM_EXPORT_CHAINTREE MoveList {
public:
    /**
     * The numbers of trials by their results.
     */
    class Counts {
    public:
        long long impossible, clashed, rejectedByEnergy, accepted;
    };
    /**
     * A move, its weight, and the results of its trials.
     */
    class Entry {
    public:
        std::unique_ptr<MonteCarloMove> move;
        double weight;
        Counts counts;
        /** The adaptation of each class of sizes; it ends with the last class that has had a trial. */
        std::vector<SizeAdaptation> adaptations;
        /**
         * Adapt the size of the move, for trials of the class of the last one, to the result of that trial.
         */
        void adaptSize(bool accepted)
        {
            if (!move->hasSize())
                return;
            const size_t drawn = move->getSizeClass();
            if (drawn >= adaptations.size())
                adaptations.resize(drawn + 1);
            move->setScale(drawn, adaptations[drawn].countTrial(accepted, move->getScale(drawn), move->getAim()));
        }
    };
    /**
     * The counts of a move, and the scale and the state of the adaptation of each of its classes of sizes.
     */
    class MoveProgress {
    public:
        Counts counts;
        std::vector<double> scales;
        std::vector<SizeAdaptation::State> adaptations;
    };
    typedef std::vector<MoveProgress> Progress;
    MoveList();
    int size() const
    {
        return entries.size();
    }
    /**
     * Add a move. Returns its index.
     */
    int add(std::unique_ptr<MonteCarloMove> move, double weight);
    /**
     * Replace a move. The counts start from 0.
     */
    void set(int index, std::unique_ptr<MonteCarloMove> move, double weight);
    void remove(int index);
    const Entry& get(int index) const;
    /**
     * Get a line about a move for people to read.
     */
    std::string summarize(int index) const;
    /**
     * Throw an exception unless a move is of a kind.
     */
    void requireKind(int index, const MoveKind& kind) const;
    /**
     * Get a move of a class, and its weight. It is an error if it is of another kind.
     */
    template <class Move>
    const Move& get(int index, double& weight) const
    {
        requireKind(index, Move::KIND);
        weight = entries[index].weight;
        return static_cast<const Move&>(*entries[index].move);
    }
    /**
     * Bind all moves, and all moves added later, to links; with NULL to none.
     */
    void bind(const LinkStructure* structure);
    /**
     * Get the sum of all weights. It is an error if no move can be drawn.
     */
    double sumWeights() const;
    /**
     * Get whether a move that can be drawn changes the volume.
     */
    bool changeVolume() const;
    /**
     * Get whether a move displaces particles within their links.
     */
    bool displaceParticles() const;
    /**
     * Get the share of the moves that displace particles in the sum of all weights; 0 if no move can be drawn.
     */
    double getDisplacingShare() const;
    /**
     * Draw a move by its weight.
     *
     * @param weightSum  the result of sumWeights()
     */
    Entry& draw(double weightSum, RandomNumberGenerator& random);
    void resetStatistics();
    /**
     * Set the scale of a move, for all classes of its sizes. Its counts start from 0. It is an error if it has no size.
     */
    void setScale(int index, double scale);
    /**
     * Set the scale of each class. While the move is bound, it is an error if it has another number of classes.
     */
    void setScales(int index, const std::vector<double>& scales);
    /**
     * Restart the adaptation of all sizes from their present scales.
     */
    void restartAdaptation();
    /**
     * Get the counts of all moves, for setStatistics().
     */
    std::vector<Counts> getStatistics() const;
    /**
     * Set the counts that getStatistics() returned.
     */
    void setStatistics(const std::vector<Counts>& statistics);

    // ---- XML ----

    /**
     * Write each move as a child of a node.
     */
    void writeMoves(OpenMM::SerializationNode& node) const;
    /**
     * Add the moves that writeMoves() has written.
     */
    void readMoves(const OpenMM::SerializationNode& node);

    // ---- Checkpoints and States ----

    /**
     * Write the moves and their progress.
     */
    void createCheckpoint(CheckpointWriter& writer) const;
    /**
     * Read the result of createCheckpoint(), and return the progress for setProgress(). It is an error if the moves of
     * the checkpoint are others.
     */
    Progress readCheckpoint(CheckpointReader& reader) const;
    void setProgress(const Progress& progress);
    /**
     * Write the moves and their progress as children of a node.
     */
    void writeProgress(OpenMM::SerializationNode& node) const;
    /**
     * Read the result of writeProgress(), for setProgress(). Returns false if its moves are others.
     */
    bool readProgress(const OpenMM::SerializationNode& node, Progress& progress) const;

private:
    /** The kind, weight and parameters of a move, by name. */
    typedef std::vector<std::pair<std::string, std::string>> Description;
    static Description describe(const Entry& entry);
    static std::vector<SizeAdaptation::State> getAdaptations(const Entry& entry);
    static void checkSame(int index, const Description& written, const Description& own);
    std::vector<Entry> entries;
    const LinkStructure* structure;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_MOVELIST_H_*/
