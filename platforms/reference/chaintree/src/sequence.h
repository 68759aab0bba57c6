/* The sequence: all links of the scene in one line, the joints between consecutive ones, and the state.
 *
 * Link 0 is the world, with every fixed particle. From it the links follow depth-first, of several branches the one
 * with most slots last, so that what a joint moves is the interval [link, end[link]). The step from link k to k + 1 is
 *
 *     opening(k + 1)                      if k is the parent of k + 1,
 *     closure(path) * opening(k + 1)      otherwise,
 *
 * where opening(l) takes the frame of l's parent to that of l by its joint, and a path is a run of links each of which
 * is the last child of the one before. Where the sequence leaves a branch, it leaves exactly one whole path: its
 * closure is the inverse of the product of the path's openings, kept as a tree of products, so that a change costs
 * O(log N). A step thus depends on no rotation that does not change it, and untouched steps keep their bits.
 *
 * A branch of few slots that is not the last of its parent is a twig: a side chain, a small molecule. Whoever walks
 * along the sequence enters it from the frame of the link that it hangs on and goes on from that very frame behind it,
 * so no path in it needs a closure, and what moves within a twig leaves everything else alone, bit by bit.
 *
 * A slot is a place for a modelled particle; slots stand in the order of their links. A link without modelled particles
 * has one empty slot, so that TREE_WIDTH slots never span more links than that. */
#ifndef CT_SEQUENCE_H_
#define CT_SEQUENCE_H_

#include "arena.h"
#include "chaintree.h"
#include "order.h"
#include "transform.h"

/* A branch of no more slots is a twig. */
enum { TWIG_SLOTS = 2 * TREE_WIDTH };

/* Where a free link is in its parent's frame. */
typedef struct Placement {
  double quaternion[4]; /* w, x, y, z */
  double position[3];
} Placement;

/* All that the state says of one joint. */
typedef struct JointState {
  double angle;        /* torsion: turned since the reference, in [-pi, pi] */
  Placement placement; /* free joint */
} JointState;

typedef struct Sequence {
  int particleCount;
  int linkCount; /* with the world */

  /* The caller's links. */
  int userLinkCount;
  int* linkOfUser;   /* 0 for fixed ones */
  int* originOfUser; /* particle at the origin of its frame */

  /* Links, indexed in sequence order. */
  int* parent; /* below the link's own index; CT_NULL for the world */
  int* end;    /* one past the last link that hangs on this one */
  uint8_t* joint;
  int* originParticle; /* on the torsion axis and in the link, or its lowest; CT_NULL for the world */
  int* axisParticle;   /* the other particle of the torsion axis, in the parent */
  int (*torsion)[4];   /* p1-p2-p3-p4 as given */
  int* branch;         /* the link that hangs on the world and holds this one; 0 for the world */
  int* placementOf;    /* index into placement, or CT_NULL */

  /* Slots. */
  int slotCount;
  int* slotBegin;    /* linkCount + 1 */
  int* slotLink;     /* slotCount */
  int* slotParticle; /* slotCount; CT_NULL: empty */
  double* slotRadius;
  uint8_t* slotRole;

  /* Particles. */
  int* particleLink;
  int* particleSlot; /* CT_NULL: not modelled */
  int* idleBegin;    /* linkCount + 1: the particles of each link that are not modelled */
  int* idleParticle;

  /* Twigs that lie in no other twig. */
  int twigCount;
  int* twigOf;   /* per link; CT_NULL: in none */
  int* twigHead; /* twigCount: first link of each */

  /* Paths, but those in twigs, that the sequence leaves before its end. */
  int pathCount;
  int* pathOf;       /* per link; CT_NULL: in a twig, or on the path that starts at the world, which never closes */
  int* pathPosition; /* per link: how many links of its path come before it */
  int* pathBegin;    /* pathCount + 1, into pathLink */
  int* pathLink;     /* links of each path, head first */
  int* productBegin; /* pathCount + 1, into product */
  Frame* product;    /* per path: products over PATH_BLOCK links, then over pairs of those, up to the whole */
  Frame* closure;    /* pathCount: inverse of the whole */

  /* State: reference positions, angles, placements; and what follows from one link's share of it alone. */
  double* reference; /* 3 * particleCount, the caller's bits */
  double worldOrigin[3];
  double* angle;
  double* rodrigues; /* of a torsion joint: its Rodrigues vector over its axis */
  Placement* placement;
  int* displaced;     /* per link that is a branch: how many of its joints are off the reference */
  int displacedCount; /* sum of those */
} Sequence;

/* Lays out a checked definition, without state. False if there is no memory. */
bool ctSequenceBuild(Sequence* sequence, Arena* arena, const ctDefinition* definition);

/* The part of it that finds twigs and paths, once links have parents, ends and slots. */
bool ctPathsBuild(Sequence* sequence, Arena* arena);

/* Nothing is displaced, as far as torsions go; placements are set with each reference. */
void ctSequenceResetTorsions(Sequence* sequence);

/* Makes finite positions the reference: angles 0, nothing displaced. Products are stale until ctPathsMultiply. */
void ctSequenceSetReference(Sequence* sequence, const double* positions);

/* Recomputes all products of paths. */
void ctPathsMultiply(Sequence* sequence);

/* Whether the axis particles of a torsion joint are apart in these reference positions. */
bool ctSequenceCanTurn(const Sequence* sequence, int link, const double* reference);

/* An angle in [-pi, pi] plus any other, in [-pi, pi] again. */
double ctAngleTurned(double angle, double turn);

/* The state of a joint; and a state moved in the parent's frame by a rotation vector about pivot and then a shift (free
 * joint). */
JointState ctSequenceGetJoint(const Sequence* sequence, int link);
JointState ctJointMoved(const JointState* joint, const double rotation[3], const double pivot[3],
                        const double shift[3]);

/* Replaces the state of a joint. Products over the link are stale until ctSequenceUpdate. */
void ctSequenceSetJoint(Sequence* sequence, int link, const JointState* joint);

/* Recomputes the products over these links (ascending), each once, and returns how many. `scratch` holds `count` ints.
 */
int ctSequenceUpdate(Sequence* sequence, const int* links, int count, int* scratch);

/* Where the frame of a link has its origin in the reference positions. */
static inline const double* sequenceOrigin(const Sequence* s, int link) {
  const int particle = s->originParticle[link];
  return particle == CT_NULL ? s->worldOrigin : s->reference + 3 * (size_t)particle;
}

/* Reference position of a particle in the frame of its link. */
static inline void sequenceLocal(const Sequence* s, int particle, double local[3]) {
  subtract(s->reference + 3 * (size_t)particle, sequenceOrigin(s, s->particleLink[particle]), local);
}

/* Where the link's origin is in its parent's frame in the reference positions. */
static inline void sequenceOffset(const Sequence* s, int link, double offset[3]) {
  subtract(sequenceOrigin(s, link), sequenceOrigin(s, s->parent[link]), offset);
}

/* The axis of a torsion joint in reference positions, along which it turns right-handed: 0 if its particles coincide.
 */
static inline void sequenceAxis(const Sequence* s, int link, const double* reference, double axis[3]) {
  subtract(reference + 3 * (size_t)s->originParticle[link], reference + 3 * (size_t)s->axisParticle[link], axis);
}

/* The Rodrigues vector of a torsion joint. */
static inline void sequenceRodrigues(const Sequence* s, int link, double w[3]) {
  sequenceAxis(s, link, s->reference, w);
  for (int k = 0; k < 3; k++) {
    w[k] *= s->rodrigues[link];
  }
}

/* The frame of a link in its parent's frame. */
static inline Frame sequenceOpening(const Sequence* s, int link) {
  Frame opening;
  if (s->joint[link] == ctTorsionJoint) {
    double offset[3];
    double w[3];
    sequenceOffset(s, link, offset);
    sequenceRodrigues(s, link, w);
    rotationFromRodrigues(w[0], w[1], w[2], opening.m[0], 1);
    setTranslation(&opening, offset);
  } else {
    const Placement* placement = &s->placement[s->placementOf[link]];
    rotationFromQuaternion(placement->quaternion, &opening);
    setTranslation(&opening, placement->position);
  }
  return opening;
}

/* The link on which a twig hangs. */
static inline int sequenceStem(const Sequence* s, int twig) {
  return s->parent[s->twigHead[twig]];
}

/* So many twigs are within each other at most: of the slots of the one around it, each has less than half. */
enum { MOST_OPEN_TWIGS = 5 };

/* A walk along the sequence: where a link is in the frame from which the walk began. */
typedef struct Walk {
  Columns frame;
  Columns stem[MOST_OPEN_TWIGS]; /* of the twigs that the link is in: the frame of the link on which each hangs */
  int openCount;
  int link;
} Walk;

/* Begins at a link that is in no twig. */
CT_INLINE void walkBegin(Walk* walk, int link) {
  const Frame identity = transformIdentity();
  columnsOf(&identity, &walk->frame);
  walk->openCount = 0;
  walk->link = link;
}

/* On to a link that hangs on the walk's, by its opening as columnsCompose takes it. */
CT_INLINE void walkEnter(Walk* walk, const Sequence* s, int link, const double* opening, size_t stride) {
  if (s->twigOf[link] != CT_NULL && s->end[link] != s->end[s->parent[link]]) {
    walk->stem[walk->openCount++] = walk->frame;
  }
  columnsCompose(&walk->frame, opening, stride);
  walk->link = link;
}

/* Back to the link on which the next one hangs, if that is not the walk's own. */
CT_INLINE void walkLeave(Walk* walk, const Sequence* s) {
  const int parent = s->parent[walk->link + 1];
  if (parent != walk->link) {
    if (walk->openCount > 0) {
      walk->frame = walk->stem[--walk->openCount];
    } else {
      columnsCompose(&walk->frame, s->closure[s->pathOf[walk->link]].m[0], 1);
    }
    walk->link = parent;
  }
}

/* On to the next link. */
CT_INLINE void walkOn(Walk* walk, const Sequence* s, const double* opening, size_t stride) {
  const int next = walk->link + 1;
  walkLeave(walk, s);
  walkEnter(walk, s, next, opening, stride);
}

/* On to a link that is not before the walk's. */
static inline void walkTo(Walk* walk, const Sequence* s, int link) {
  while (walk->link < link) {
    const Frame opening = sequenceOpening(s, walk->link + 1);
    walkOn(walk, s, opening.m[0], 1);
  }
}

/* Begins at a link in a twig, where the frame of the link on which that hangs is `stem`. */
CT_INLINE void walkBeginInTwig(Walk* walk, const Sequence* s, int link, const Frame* stem) {
  int way[TWIG_SLOTS]; /* links have a slot at least */
  int count = 0;
  const int end = sequenceStem(s, s->twigOf[link]);
  for (int l = link; l != end; l = s->parent[l]) {
    way[count++] = l;
  }
  columnsOf(stem, &walk->frame);
  walk->openCount = 0;
  walk->link = end;
  while (count > 0) {
    const Frame opening = sequenceOpening(s, way[--count]);
    walkEnter(walk, s, way[count], opening.m[0], 1);
  }
}

#endif /* CT_SEQUENCE_H_ */
