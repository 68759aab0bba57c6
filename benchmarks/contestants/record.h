/* A race on file, for whoever wants to run the same trials: lines of JSON.
 *
 *   {"particles": [[x, y, z, radius], ...], "names": [number in the source of the scene, ...],
 *    "torsions": [[near, far, first, last], ...], "exclusions": [[i, j], ...]}
 *   {"turns": [[torsion, angle in rad], ...], "clash": false}             one for each trial, from the first on
 *
 * A torsion turns the particles first ... last - 1 about the line from particle near to particle far. */
#ifndef RECORD_H_
#define RECORD_H_

#include <stdio.h>

#include "contestant.h"

void recordScene(FILE* file, const Scene* scene);
void recordTrial(FILE* file, int count, const Turn* turns, bool clash);

#endif /* RECORD_H_ */
