"""Many replicas of one System, independent or with temperature exchange.

A run is divided into rounds. A Segment is the work of one replica in one round. It contains all data that `runSegment`
needs besides the Model of all replicas, so it can run anywhere; the result includes the replica's new state. A
Coordinator submits segments to workers, decides exchanges from the returned energies, and passes on frames. No decision
depends on which worker runs a segment, or when: the results of a run have the same bits with any number of workers,
and after any interruption.
"""
