#include "witness.h"

/* Makes the choice at the end of a round. */
static void choose(Witnesses* w) {
  w->patience = w->patience > LEAST_WITNESS_PATIENCE ? w->patience : LEAST_WITNESS_PATIENCE;
  if (w->wait > 0) {
    w->wait--;
  } else if (w->cost > w->clashes * w->searchCost) {
    w->wait = w->patience;
    w->patience = w->patience < MOST_WITNESS_PATIENCE ? 2 * w->patience : w->patience;
  } else {
    w->patience = LEAST_WITNESS_PATIENCE;
  }
  w->trials = 0;
  w->cost = 0;
  w->clashes = 0;
}

bool ctWitnessesAreWanted(Witnesses* w) {
  if (w->trials++ == WITNESS_ROUND) {
    choose(w);
  }
  return w->wait == 0 && w->count > 0;
}

void ctWitnessesCharge(Witnesses* w, int64_t cost, bool clash) {
  w->cost += cost;
  w->clashes += clash;
}

void ctWitnessesAdd(Witnesses* w, const Tree* tree, int slotA, int slotB, int64_t searchCost) {
  const int wanted = tree->levelSize[0] / LEAVES_A_WITNESS;
  const int most = wanted < LEAST_WITNESSES ? LEAST_WITNESSES : wanted > MOST_WITNESSES ? MOST_WITNESSES : wanted;
  w->pair[w->next][0] = slotA;
  w->pair[w->next][1] = slotB;
  w->next = w->next + 1 < most ? w->next + 1 : 0;
  w->count += w->count < most;
  w->searchCost += (searchCost - w->searchCost) / (w->searchCost > 0 ? SEARCHES_REMEMBERED : 1);
}
