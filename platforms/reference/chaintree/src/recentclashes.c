#include "recentclashes.h"

/* Makes the choice at the end of a round. */
static void choose(RecentClashes* w) {
  w->patience = w->patience > LEAST_RECENT_CLASH_PATIENCE ? w->patience : LEAST_RECENT_CLASH_PATIENCE;
  if (w->wait > 0) {
    w->wait--;
  } else if (w->cost > w->clashes * w->searchCost) {
    w->wait = w->patience;
    w->patience = w->patience < MOST_RECENT_CLASH_PATIENCE ? 2 * w->patience : w->patience;
  } else {
    w->patience = LEAST_RECENT_CLASH_PATIENCE;
  }
  w->trials = 0;
  w->cost = 0;
  w->clashes = 0;
}

bool ctRecentClashesAreWanted(RecentClashes* w) {
  if (w->trials++ == RECENT_CLASH_ROUND) {
    choose(w);
  }
  return w->wait == 0 && w->count > 0;
}

void ctRecentClashesCharge(RecentClashes* w, int64_t cost, bool clash) {
  w->cost += cost;
  w->clashes += clash;
}

void ctRecentClashesAdd(RecentClashes* w, const Tree* tree, int slotA, int slotB, const Image* image,
                        int64_t searchCost) {
  const int wanted = tree->levelSize[0] / LEAVES_PER_RECENT_CLASH;
  const int most = wanted < LEAST_RECENT_CLASHES  ? LEAST_RECENT_CLASHES
                   : wanted > MOST_RECENT_CLASHES ? MOST_RECENT_CLASHES
                                                  : wanted;
  w->pair[w->next][0] = slotA;
  w->pair[w->next][1] = slotB;
  w->image[w->next] = *image;
  w->next = w->next + 1 < most ? w->next + 1 : 0;
  w->count += w->count < most;
  w->searchCost += (searchCost - w->searchCost) / (w->searchCost > 0 ? SEARCHES_REMEMBERED : 1);
}

void ctRecentClashesForget(RecentClashes* w) {
  w->count = 0;
  w->next = 0;
}
