/* What has changed, and when. Changes are numbered. Whatever is computed from the state stores the revision that it was
 * built from, and asks here what has changed since. The tree writes this log when it is updated. */
#ifndef CT_CHANGES_H_
#define CT_CHANGES_H_

#include <limits.h>
#include <stdbool.h>
#include <stdint.h>

/* A number of changes. */
typedef int64_t Revision;

/* Before all changes. */
enum { NO_REVISION = -1 };

/* A leaf, and when it changed. */
typedef struct LeafChange {
  int leaf;
  Revision revision;
} LeafChange;

/* Number of listed leaves that are remembered. */
enum { LISTED_LEAVES = 16 };

typedef struct Changes {
  Revision now;     /* counts changes of the state, and of bounds alone */
  Revision ofState; /* the last change of the state */

  /* If the shortcut of a leaf changes, all nodes behind that leaf move. These leaves ascend, and so do their revisions:
   * a change removes earlier changes of later leaves. */
  int shortcutCount; /* never 0, since a tree has no content at first */
  int* shortcutLeaf;
  Revision* shortcutRevision;

  /* A ring of the last leaves in which slots have moved, and the last change of which it does not list the leaves. */
  uint64_t listedCount;
  LeafChange listed[LISTED_LEAVES];
  Revision unlisted;
} Changes;

/* Notes that all leaves behind this one move now. */
static inline void noteShortcut(Changes* c, int leaf) {
  while (c->shortcutCount > 0 && c->shortcutLeaf[c->shortcutCount - 1] >= leaf) {
    c->shortcutCount--;
  }
  c->shortcutLeaf[c->shortcutCount] = leaf;
  c->shortcutRevision[c->shortcutCount++] = c->now;
}

/* Lists a leaf in which slots have moved now. */
static inline void listLeaf(Changes* c, int leaf) {
  c->listed[c->listedCount++ % LISTED_LEAVES] = (LeafChange){leaf, c->now};
}

/* The leaf that was listed last but `k`, and when; the revision is 0 before the first. */
static inline LeafChange listedLeaf(const Changes* c, int k) {
  return c->listed[(c->listedCount - 1 - (uint64_t)k) % LISTED_LEAVES];
}

/* True if the state has changed since a revision. */
static inline bool stateChangedSince(const Changes* c, Revision since) {
  return c->ofState > since;
}

/* True if some node has moved since a revision. */
static inline bool movedSince(const Changes* c, Revision since) {
  return c->shortcutRevision[c->shortcutCount - 1] > since;
}

/* The first leaf that may have moved since a revision; INT_MAX: none has. O(log N). */
static inline int firstMovedSince(const Changes* c, Revision since) {
  /* Without a branch on the result, which processors would mispredict. */
  int low = 0;
  for (int left = c->shortcutCount; left > 0;) {
    const int half = (left + 1) / 2;
    low += c->shortcutRevision[low + half - 1] <= since ? half : 0;
    left -= half;
  }
  return low == c->shortcutCount ? INT_MAX : c->shortcutLeaf[low];
}

/* True if a leaf before `leafEnd` may have moved since a revision. O(log N). */
static inline bool leavesMovedSince(const Changes* c, Revision since, int leafEnd) {
  if (c->shortcutLeaf[c->shortcutCount - 1] < leafEnd) { /* mostly */
    return movedSince(c, since);
  }
  return firstMovedSince(c, since) < leafEnd;
}

#endif /* CT_CHANGES_H_ */
