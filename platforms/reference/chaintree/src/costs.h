/* The choice of testers. Every estimated cost and every threshold of these choices stands here. None of them changes a
 * verdict, only the time that a test takes. Unit of a cost: the time of one test of a volume, or of a pair of
 * particles, in a descent. It was meant to be 1 ns on the machine of the project's races, one core of an AMD EPYC (Zen
 * 4) with AVX-512. The numbers were fitted by hand; the history of the repository names neither machine nor runs for a
 * single one. With AVX2, on a busy AMD EPYC (Zen 3), the commands below gave 1.4 ns by the tree, 1.9 ns by boxes, and a
 * third of the time of the tree by clearances.
 *
 * To measure again, race the testers against each other on one scene and divide the time of a trial by what it has
 * tested:
 *
 *     for way in tree boxes clearances; do
 *       CHAINTREE_TRIALS=$way build/benchmarks/openmm-chaintree-contestants --contestants ours --chain random \
 *           --n 1000 --moves gaussian --angle 1 --trials 20000
 *     done
 *
 * prints, for each, microseconds, volume tests and pair tests. Without CHAINTREE_TRIALS the engine chooses: it should
 * take no longer than the best of the three. Vary --n (100 ... 10000), --angle (0.1 ... 30) and --kappa (1, 8). */
#ifndef CT_COSTS_H_
#define CT_COSTS_H_

#include "order.h"

/* ---- The tree: see wide/descent.c ---- */

/* Most slots in a row that move while all others are static: these are tested one by one. */
enum { MOST_MOVERS = 2 * TREE_WIDTH };

/* That test starts at the lowest level with at most this many nodes, and tests all of them. */
enum { MOST_FIRST_NODES = 2 * TREE_WIDTH };

/* If these are more, and leaves have no boxes, only those near the movers are tested. In a protein that was most of 17,
 * but half of 23. */
enum { MOST_UNASKED_NODES = 20 };

/* Leaf boxes halve the leaves visited. Built after this many tests per leaf in which few leaves at a time have moved.
 */
enum { TESTS_PER_LEAF = 1 };

/* With at most this many nodes over leaves, the boxes of all leaves are tested, without the nodes. */
enum { MOST_BOXED_NODES = 3 * TREE_WIDTH };

/* ---- Boxes in a descent: see box.h, wide/descent.c ---- */

enum {
  COST_OF_BOXES = 150, /* of a visit with boxes: moving the boxes of two nodes into the view */
  COST_OF_BOX_TEST = 2 /* of a pair of boxes, beyond the test of a volume that it counts as */
};

/* A box with less than this share of the volume of the sphere around the same is worth a test of its own. */
#define THIN_SHARE 0.2f

/* Boxes pay in a descent if they separate more than one in this many pairs of overlapping spheres. */
enum { PAIRS_PER_SEPARATION = 4 };

/* Most visits of a descent before the first with boxes: beyond this, boxes are not tried again. */
enum { MOST_VISITS_WITHOUT_BOXES = 1 << 20 };

/* ---- Clearances: see clearance.h ---- */

/* Costs of a test by clearances. */
enum {
  COST_OF_CLEARANCE_TEST = 300, /* of each: listing runs of leaves, updating world coordinates */
  LEAVES_PER_UNIT = 2,          /* leaves of the scene that cost a unit */
  COST_OF_RUN_PAIR = 350,       /* of two runs that move against each other: their bounds; and for leaves as above */
  COST_OF_SPHERES = 15,         /* of a leaf's sphere against sixteen others */
  COST_OF_LEAF_PAIR = 60        /* of testing the particles of two leaves */
  /* 1: the clearances of sixteen columns of a row, compared with their bounds */
};

/* Clearances are tried where a test by the tree costs more than this, and more than the comparison of all rows of
 * moving leaves with all others: about leaves^2 / 96 sixteens. */
enum { LEAST_COST_WORTH_SAVING = 1500, LEAF_PAIRS_PER_UNIT = 96 };

/* They are kept if a test by them costs at most this many tenths of a test by the tree. */
enum { TENTHS_THAT_PAY = 9 };

/* No table of clearances is made for more leaves: it would take more than 8 MiB. */
enum { MOST_LEAVES = 2048 };

/* The choice between tree and clearances, in rounds of trials. */
enum {
  CLEARANCE_ROUND = 128,             /* trials of a round */
  TRIALS_TO_MEASURE_TREE = 8,        /* trials by the tree that only measure its cost */
  ROUNDS_PER_MEASUREMENT = 16,       /* measuring takes under 1/16 of the time */
  LEAST_CLEARANCE_PATIENCE = 4,      /* rounds by the tree after clearances have not paid; doubled each time */
  MOST_CLEARANCE_PATIENCE = 1 << 12, /* rounds: no more than this */
  TRIALS_IN_ADVANCE = 32             /* clearances give up after the cost of this many trials by the tree */
};

/* ---- Recent clashes: see recentclashes.h ---- */

/* Costs of testing recent clashes. */
enum {
  COST_OF_RECENT_CLASHES = 40,   /* a trial */
  COST_OF_RECENT_CLASH = 4,      /* a pair */
  COST_OF_RECENT_CLASH_TEST = 20 /* a pair whose particles move against each other */
};

/* One pair is remembered for this many leaves, within bounds. */
enum { LEAVES_PER_RECENT_CLASH = 4, LEAST_RECENT_CLASHES = 8, MOST_RECENT_CLASHES = 64 };

/* The choice whether to test recent clashes, in rounds of trials. */
enum {
  RECENT_CLASH_ROUND = 64,            /* trials of a round */
  SEARCHES_REMEMBERED = 16,           /* weight of earlier descents in the mean cost */
  LEAST_RECENT_CLASH_PATIENCE = 4,    /* rounds without them after one in which they have not paid; doubled each time */
  MOST_RECENT_CLASH_PATIENCE = 1 << 6 /* rounds: no more than this */
};

#endif /* CT_COSTS_H_ */
