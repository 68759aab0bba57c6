"""When the replicas of a run stop: for frames, and at the ends of rounds."""

from typing import NamedTuple

from .segment import Stop


class Schedule(NamedTuple):
    """The schedule of each replica of a run.

    trials : int, total; trialsPerRound : int; interval : int, the number of trials between frames
    """

    trials: int
    trialsPerRound: int
    interval: int

    @property
    def rounds(self):
        """The number of rounds; the last one can be shorter."""
        return -(-self.trials // self.trialsPerRound)

    @property
    def frames(self):
        """The number of frames after the start; the last interval can be shorter."""
        return -(-self.trials // self.interval)

    def trialsBefore(self, round):
        """Return the number of trials that a replica has made when a round begins."""
        return min(round * self.trialsPerRound, self.trials)

    def framesBefore(self, round):
        """Return the number of frames after the start when a round begins."""
        trials = self.trialsBefore(round)
        return self.frames if trials == self.trials else trials // self.interval

    def trialsOfFrame(self, frame):
        """Return the number of trials before a frame; the start is frame 0."""
        return min(frame * self.interval, self.trials)

    def stops(self, round):
        """Return the Stops of a round."""
        begin, end = self.trialsBefore(round), self.trialsBefore(round + 1)
        frames = range(self.framesBefore(round) + 1, self.framesBefore(round + 1) + 1)
        places = {self.trialsOfFrame(frame): True for frame in frames}
        places.setdefault(end, False)
        stops = []
        for place, keepsFrame in places.items():
            stops.append(Stop(place - begin, keepsFrame))
            begin = place
        return tuple(stops)
