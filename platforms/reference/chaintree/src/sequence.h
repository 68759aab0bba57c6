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
 * A slot is a place for a modelled particle; slots stand in the order of their links. A link without modelled particles
 * has one empty slot, so that TREE_WIDTH slots never span more links than that. */
#ifndef CT_SEQUENCE_H_
#define CT_SEQUENCE_H_

#include "arena.h"
#include "chaintree.h"
#include "transform.h"

/* Where a free link is in its parent's frame. */
typedef struct Placement {
  double quaternion[4]; /* w, x, y, z */
  double position[3];
} Placement;

/* All that the state says of one joint. */
typedef struct JointState {
  double angle; /* torsion: turned since the reference, in [-pi, pi] */
  double cosine;
  double sine;
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

  /* Paths that the sequence leaves before its end. */
  int pathCount;
  int* pathOf;       /* per link; CT_NULL: on the path that starts at the world, which never closes */
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
  double* cosine;
  double* sine;
  Placement* placement;
  int* displaced;     /* per link that is a branch: how many of its joints are off the reference */
  int displacedCount; /* sum of those */
  double (*axis)[3];  /* unit vector of the torsion axis in the reference; 0 if its particles coincide */
} Sequence;

/* Lays out a checked definition, without state. False if there is no memory. */
bool ctSequenceBuild(Sequence* sequence, Arena* arena, const ctDefinition* definition);

/* The part of it that finds the paths, once links have parents and ends. */
bool ctPathsBuild(Sequence* sequence, Arena* arena);

/* Nothing is displaced, as far as torsions go; placements are set with each reference. */
void ctSequenceResetTorsions(Sequence* sequence);

/* Makes finite positions the reference: angles 0, nothing displaced. Axes and products are stale until
 * ctSequenceRefresh. */
void ctSequenceSetReference(Sequence* sequence, const double* positions);

/* Recomputes all axes and products of paths. */
void ctSequenceRefresh(Sequence* sequence);

/* The part of it that multiplies. */
void ctPathsMultiply(Sequence* sequence);

/* Whether the axis particles of a torsion joint are apart in these reference positions. */
bool ctSequenceCanTurn(const Sequence* sequence, int link, const double* reference);

/* The state of a joint; that of a torsion at an angle in [-pi, pi]; and a state turned by an angle (torsion), or moved
 * in the parent's frame by a rotation vector about pivot and then a shift (free joint). */
JointState ctSequenceGetJoint(const Sequence* sequence, int link);
JointState ctJointAt(double angle);
JointState ctJointTurned(const JointState* joint, double angle);
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

/* The frame of a link in its parent's frame. */
static inline Frame sequenceOpening(const Sequence* s, int link) {
  Frame opening;
  if (s->joint[link] == ctTorsionJoint) {
    double offset[3];
    sequenceOffset(s, link, offset);
    rotationAbout(s->axis[link], s->cosine[link], s->sine[link], &opening);
    setTranslation(&opening, offset);
  } else {
    const Placement* placement = &s->placement[s->placementOf[link]];
    rotationFromQuaternion(placement->quaternion, &opening);
    setTranslation(&opening, placement->position);
  }
  return opening;
}

/* So many paths within each other a walk can keep open. */
enum { MOST_OPEN_PATHS = 4 };

/* A walk along the sequence: where a link is in the frame of the link where the walk began. A path that it has seen
 * open closes by the very frame of the parent, so what moves within the path leaves all behind it alone, bit by bit; a
 * path that was open before closes by its product. */
typedef struct Walk {
  int link;
  Frame frame;
  int openCount;
  int path[MOST_OPEN_PATHS];
  Frame parent[MOST_OPEN_PATHS];
} Walk;

static inline void walkBegin(Walk* walk, int link) {
  walk->link = link;
  walk->frame = transformIdentity();
  walk->openCount = 0;
}

/* On to the next link. */
static inline void walkOn(Walk* walk, const Sequence* s) {
  const int next = walk->link + 1;
  if (s->parent[next] != walk->link) {
    const int path = s->pathOf[walk->link];
    if (walk->openCount > 0 && walk->path[walk->openCount - 1] == path) {
      walk->frame = walk->parent[--walk->openCount];
    } else {
      walk->frame = transformCompose(&walk->frame, &s->closure[path]);
    }
  }
  const bool opens = s->pathOf[next] != CT_NULL && s->pathPosition[next] == 0;
  if (opens && walk->openCount < MOST_OPEN_PATHS) {
    walk->path[walk->openCount] = s->pathOf[next];
    walk->parent[walk->openCount++] = walk->frame;
  }
  const Frame opening = sequenceOpening(s, next);
  walk->frame = transformCompose(&walk->frame, &opening);
  walk->link = next;
}

#endif /* CT_SEQUENCE_H_ */
