"""Many replicas of one System: independent ones, or some that exchange temperatures.

A run is cut into rounds. What a replica does in a round is a Segment, which says all that is needed, so that it can run
anywhere: `runSegment` takes it with the Model of all replicas, and returns where the replica is then. A Coordinator
hands segments to whoever runs them, decides exchanges from the energies that come back, and hands on frames. Nothing
that decides depends on who runs a segment, or when: the results of a run have the same bits with any number of workers,
and after any interruption.
"""
