#ifndef OPENMM_CHAINTREE_OUTERSTATISTICS_H_
#define OPENMM_CHAINTREE_OUTERSTATISTICS_H_

#include "openmm/serialization/SerializationNode.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/windowsExportChainTree.h"

namespace ChainTreePlugin {

/**
 * Counts of outer tests, and the differences that they found.
 */
class OPENMM_EXPORT_CHAINTREE OuterStatistics {
public:
    OuterStatistics();
    void add(double difference);
    /**
     * Get the standard deviation of all differences; 0 if there are fewer than two.
     */
    double getStandardDeviation() const;
    void write(CheckpointWriter& writer) const;
    void read(CheckpointReader& reader);
    void write(OpenMM::SerializationNode& node) const;
    void read(const OpenMM::SerializationNode& node);
    /** The number of tests, and of tests that accepted their trials. */
    long long attempted, accepted;
    /** The number of trials of the other tests, rejected trials included. */
    long long trialsTakenBack;
    /** The number of differences that tests found, their mean, and the sum of the squares of their deviations from
     *  it. */
    long long numDifferences;
    double mean, squares;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_OUTERSTATISTICS_H_*/
