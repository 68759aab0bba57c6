/* The sequence: all links of the scene in one line, the joints between consecutive ones, and the state.
 *
 * Link 0 is the world, with every fixed particle. From it the links follow depth-first; of several branches the one
 * with most slots is last, so that a joint moves the interval [link, end[link]). The step from link k to k + 1 is
 *
 *     local(k + 1)                  if k is the parent of k + 1,
 *     back(path) * local(k + 1)     otherwise.
 *
 * The local frame local(l) takes the frame of l's parent to that of l by its joint. A path is a run of links each of
 * which is the last child of the one before. Where the sequence leaves a branch, it leaves exactly one whole path: the
 * return frame back(path) is the inverse of the product of the path's local frames, kept as a tree of products, so that
 * a change costs O(log N). A step thus depends on no rotation that does not change it, and untouched steps keep their
 * bits.
 *
 * A side branch is a branch of few slots that is not the last of its parent: a side chain, a small molecule. A walk
 * along the sequence enters it from the frame of the link on which it hangs, and continues behind it from that same
 * frame. So paths in side branches need no return frames, and a change within a side branch keeps the bits of
 * everything else.
 *
 * A slot is the index of a particle in the sequence: slots are in the order of their links. Particles that are modelled
 * have one, and those without a radius that are listed, which to all volumes are as if the slot were empty. A link
 * without such particles has one empty slot, so that TREE_WIDTH slots never span more than TREE_WIDTH links. Empty
 * slots fill the last leaf of a molecule of half a leaf or more, and that of what is before it, so that it shares no
 * leaf. */
#ifndef CT_SEQUENCE_H_
#define CT_SEQUENCE_H_

#include "arena.h"
#include "chaintree.h"
#include "images.h"
#include "order.h"
#include "transform.h"

/* Most slots of a side branch. */
enum { SIDE_BRANCH_SLOTS = 2 * TREE_WIDTH };

/* The rigid transform of a link with a free or ball joint, or in a flexible scene any joint, in its parent's frame. In
 * a scene that is not flexible a ball joint turns about the origin of its link, which therefore stays at the reference
 * position, so that bonds to it keep their lengths. */
typedef struct Placement {
  double quaternion[4]; /* w, x, y, z */
  double position[3];
} Placement;

/* The state of one joint. */
typedef struct JointState {
  double angle;        /* torsion: turned since the reference, in [-pi, pi] */
  Placement placement; /* of a joint that has one, see isPlaced */
  int wrap[3];         /* free joint on the world: see Sequence.wrap */
} JointState;

/* Properties of a particle that the limit of a pair depends on. */
typedef struct ParticleType {
  double radius;
  unsigned role; /* in hydrogen bonds */
} ParticleType;

/* The particle at the origin of a link's frame, and what its joint depends on. */
typedef struct Joint {
  int origin; /* on the torsion axis and in the link; a ball joint's pivot; or its lowest; CT_NULL for the world */
  union {
    int torsion[3]; /* torsion joint: p2, p1 and p4 of the torsion whose p3 is the origin */
    int placement;  /* free or ball joint of a scene that is not flexible: index into the sequence's placement */
  };
} Joint;

/* Where the two axis particles of a torsion joint are in the leaf where its link begins: 16 * place of the first +
 * place of the second. No two particles have one place, so equal places can mean something else. Trials turn joints in
 * any order, and a look-up would wait for memory. */
enum {
  axisElsewhere = 0x00, /* not both are there */
  axisIsNoLine = 0x11   /* they are at one place in the reference positions, so that the joint cannot turn */
};

/* The part of a link in a side branch. */
typedef enum SideBranchPart {
  notInSideBranch,
  continuesSideBranch, /* the last child of its parent */
  beginsInnerBranch,   /* the first link of a branch of a side branch */
  beginsSideBranch     /* the first link of a side branch that lies in no other */
} SideBranchPart;

typedef struct Sequence {
  int particleCount;
  int userLinkCount;
  int linkCount; /* with the world */
  int slotCount;
  int typeCount;
  int slotlessCount;    /* particles without a slot */
  int branchCount;      /* of the world */
  int returnFrameCount; /* paths that have return frames */
  int openPathCount;    /* the others */
  int displacedCount;   /* joints that are off the reference */
  bool isFlexible;

  /* The caller's links. */
  int* linkOfUser; /* see sequenceLink; of a fixed link ~ of its lowest particle */

  /* Links, indexed in sequence order. */
  int* parent; /* below the link's own index; CT_NULL for the world */
  uint8_t* jointType;
  uint8_t* sideBranchPart;
  Joint* joint;
  uint8_t* axisPlaces; /* of a torsion joint */
  int* pathOf;

  /* Slots. */
  int* slotBegin;    /* linkCount + 1 */
  int* slotLink;     /* slotCount */
  int* slotParticle; /* slotCount; CT_NULL: empty */
  int* slotType;     /* index into types */
  ParticleType* types;

  /* Particles. */
  int* slotOrLink;       /* its slot; if it has none, ~ of its link */
  int* slotlessParticle; /* the particles without a slot, in the order of their links */

  int* branchHead; /* first links of the world's branches, ascending */

  /* Paths: first those with return frames, which the sequence leaves before its end, outside of side branches; then the
   * path that starts at the world; then those in side branches. */
  int* pathEnd;       /* one past the last link that hangs on any of the path's */
  int* pathBegin;     /* returnFrameCount + 1, into pathLink */
  int* pathLink;      /* links of each path that has a return frame, ascending */
  int* productBegin;  /* returnFrameCount + 1, into product */
  Frame* product;     /* per path: products over PATH_BLOCK links, then over pairs of those, up to the whole */
  Frame* returnFrame; /* returnFrameCount: inverse of the whole */

  /* The state: reference positions, angles, placements; and what follows from the state of one joint alone. */
  double* reference; /* 3 * particleCount, the caller's bits; in a flexible scene then 3 * linkCount: the origins of all
                        links */
  double worldOrigin[3];
  double* angle;
  double* dihedral;  /* of a torsion joint: p1-p2-p3-p4 of the reference positions; NaN: not needed yet; allocated on
                        first use */
  double* rodrigues; /* of a torsion joint: its Rodrigues vector over its axis */
  Placement* placement;
  PeriodicBox box;
  int (*wrap)[3]; /* per branch of the world: the box vectors by which it stands inside the engine from where callers
                     have it, so that molecules that drift stay near each other */
  int* displaced; /* per branch: how many of its joints are off the reference */
} Sequence;

/* Lays out a checked definition, without state. False if there is no memory. */
bool ctSequenceBuild(Sequence* sequence, Arena* arena, const ctDefinition* definition);

/* Part of ctSequenceBuild: finds side branches and paths. Links must have parents and slots; `end` of each is one past
 * the last link that hangs on it. */
bool ctPathsBuild(Sequence* sequence, Arena* arena, const int* end);

/* Part of ctSequenceBuild: finds the types of particles, which must have slots. */
bool ctTypesBuild(Sequence* sequence, Arena* arena, const ctDefinition* definition);

/* Sets all torsions to their reference. Placements are set by ctSequenceSetReference. */
void ctSequenceResetTorsions(Sequence* sequence);

/* Makes finite positions the reference: all angles are 0, and no joint is displaced. originsAreSet: in a flexible
 * scene, the origins of the world and of all links stand behind the reference positions already. Products are outdated
 * until ctPathsMultiply. */
typedef enum Origins { originsOfParticles, originsAreSet } Origins;
void ctSequenceSetReference(Sequence* sequence, const double* positions, Origins origins);

/* Wraps a free joint on the world if it is far from worldOrigin. Writes by how much it is shifted then. */
void ctJointWrap(const Sequence* sequence, JointState* joint, double shift[3]);

/* The shift of a branch of the world from where callers have it: 0 without a box. */
void ctSequenceShift(const Sequence* sequence, int branch, double shift[3]);

/* The same of the branch that a link is in. Looks for the branch only if there is a box. */
void ctSequenceLinkShift(const Sequence* sequence, int link, double shift[3]);

/* True if some branch of the world is shifted from where callers have it. O(branches). */
bool ctSequenceIsWrapped(const Sequence* sequence);

/* Recomputes all products of paths. */
void ctPathsMultiply(Sequence* sequence);

/* True if the two axis particles of a torsion joint are apart in these reference positions. */
bool ctSequenceCanTurn(const Sequence* sequence, int link, const double* reference);

/* An angle in [-pi, pi] plus any other, in [-pi, pi] again. */
double ctAngleTurned(double angle, double turn);

/* The state of a joint; that of a ball joint, turned in the parent's frame by a rotation vector; those of a torsion and
 * of a ball joint of a flexible scene, turned about the axis or the pivot as it stands now; and that of a free joint,
 * moved in the parent's frame by a rotation vector about a pivot and then by a shift. */
JointState ctSequenceGetJoint(const Sequence* sequence, int link);
JointState ctJointTurned(const JointState* joint, const double rotation[3]);
JointState ctTorsionTurned(const Sequence* sequence, int link, double angle);
JointState ctBallTurned(const Sequence* sequence, int link, const double rotation[3]);
JointState ctJointMoved(const JointState* joint, const double rotation[3], const double pivot[3],
                        const double shift[3]);

/* Replaces the state of a joint. Products over the link are outdated until ctSequenceUpdate. */
void ctSequenceSetJoint(Sequence* sequence, int link, const JointState* joint);

/* Recomputes the products over these links (ascending), each once, and returns how many. `scratch` holds `count` ints.
 */
int ctSequenceUpdate(Sequence* sequence, const int* links, int count, int* scratch);

/* True for a link that places a molecule in a periodic box, which therefore is wrapped. */
static inline bool isWrapped(const Sequence* s, int link) {
  return s->box.isPeriodic && s->parent[link] == 0 && s->jointType[link] == ctFreeJoint;
}

/* The largest radius of a particle. */
double ctLargestRadius(const Sequence* sequence);

/* True if the state of a link's joint is the angle of its torsion. */
static inline bool hasAngle(const Sequence* s, int link) {
  return s->jointType[link] == ctTorsionJoint && !s->isFlexible;
}

/* True if it is a placement. */
static inline bool isPlaced(const Sequence* s, int link) {
  return s->jointType[link] != ctFixedJoint && !hasAngle(s, link);
}

static inline Placement* placementOf(const Sequence* s, int link) {
  return &s->placement[s->isFlexible ? link : s->joint[link].placement];
}

/* One past the last link that hangs on a link. */
static inline int sequenceEnd(const Sequence* s, int link) {
  return s->pathEnd[s->pathOf[link]];
}

/* The branch of the world that a link is in; CT_NULL for the world itself. O(log of their number). */
static inline int sequenceBranch(const Sequence* s, int link) {
  return ascendingFrom(s->branchHead, 0, s->branchCount, link + 1) - 1;
}

/* The first link of the outermost side branch that a link is in. */
static inline int sideBranchHead(const Sequence* s, int link) {
  while (s->sideBranchPart[link] != beginsSideBranch) {
    link = s->parent[link];
  }
  return link;
}

/* The number of a path that has no return frame, such as one that a side branch begins with. */
static inline int sequenceOpenPath(const Sequence* s, int link) {
  return s->pathOf[link] - s->returnFrameCount;
}

/* The link that holds a caller's: the world, if that is fixed. */
static inline int sequenceLink(const Sequence* s, int userLink) {
  return s->linkOfUser[userLink] > 0 ? s->linkOfUser[userLink] : 0;
}

/* The slot of a particle; CT_NULL: it has none. */
static inline int particleSlot(const Sequence* s, int particle) {
  return s->slotOrLink[particle] >= 0 ? s->slotOrLink[particle] : CT_NULL;
}

static inline int particleLink(const Sequence* s, int particle) {
  const int slotOrLink = s->slotOrLink[particle];
  return slotOrLink >= 0 ? s->slotLink[slotOrLink] : ~slotOrLink;
}

/* The leaf of a particle; if it has no slot, that where its link begins. */
static inline int particleLeaf(const Sequence* s, int particle) {
  const int slotOrLink = s->slotOrLink[particle];
  return coveringNode(slotOrLink >= 0 ? slotOrLink : s->slotBegin[~slotOrLink]);
}

/* The first entry of slotlessParticle of a link or a later one. O(log of their number). */
static inline int sequenceSlotless(const Sequence* s, int link) {
  int begin = 0;
  int end = s->slotlessCount;
  while (begin < end) {
    const int middle = begin + (end - begin) / 2;
    if (particleLink(s, s->slotlessParticle[middle]) < link) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  return begin;
}

static inline double slotRadius(const Sequence* s, int slot) {
  return s->types[s->slotType[slot]].radius;
}

/* True if a slot holds a particle that is modelled: one with a radius. */
static inline bool slotIsModelled(const Sequence* s, int slot) {
  return s->slotParticle[slot] != CT_NULL && slotRadius(s, slot) > 0;
}

/* The slot of a particle that is modelled, else CT_NULL. */
static inline int modelledSlot(const Sequence* s, int particle) {
  const int slot = particleSlot(s, particle);
  return slot != CT_NULL && slotIsModelled(s, slot) ? slot : CT_NULL;
}

/* The origin of a link's frame in the reference positions. */
static inline const double* sequenceOrigin(const Sequence* s, int link) {
  const int particle = s->joint[link].origin;
  if (s->isFlexible) { /* the particle may be displaced */
    return s->reference + 3 * ((size_t)s->particleCount + (size_t)link);
  }
  return particle == CT_NULL ? s->worldOrigin : s->reference + 3 * (size_t)particle;
}

/* The reference position of a particle in the frame of its link. */
static inline void sequenceLocal(const Sequence* s, int link, int particle, double local[3]) {
  subtract(s->reference + 3 * (size_t)particle, sequenceOrigin(s, link), local);
}

/* The origin of a link in its parent's frame, in the reference positions. */
static inline void sequenceOffset(const Sequence* s, int link, double offset[3]) {
  subtract(sequenceOrigin(s, link), sequenceOrigin(s, s->parent[link]), offset);
}

/* The axis of a torsion joint in reference positions, along which it turns right-handed: 0 if its particles coincide.
 */
static inline void sequenceAxis(const Sequence* s, int link, const double* reference, double axis[3]) {
  subtract(reference + 3 * (size_t)s->joint[link].origin, reference + 3 * (size_t)s->joint[link].torsion[0], axis);
}

/* The Rodrigues vector of a torsion joint. */
static inline void sequenceRodrigues(const Sequence* s, int link, double w[3]) {
  sequenceAxis(s, link, s->reference, w);
  for (int k = 0; k < 3; k++) {
    w[k] *= s->rodrigues[link];
  }
}

/* The frame of a link in its parent's frame. */
static inline Frame sequenceLocalFrame(const Sequence* s, int link) {
  Frame localFrame;
  if (hasAngle(s, link)) {
    double offset[3];
    double w[3];
    sequenceOffset(s, link, offset);
    sequenceRodrigues(s, link, w);
    rotationFromRodrigues(w[0], w[1], w[2], localFrame.m[0], 1);
    setTranslation(&localFrame, offset);
  } else {
    const Placement* placement = placementOf(s, link);
    rotationFromQuaternion(placement->quaternion, &localFrame);
    setTranslation(&localFrame, placement->position);
  }
  return localFrame;
}

/* Where the two axis particles of a torsion joint are in the frame of its link, as it stands now. */
static inline void sequenceAxisEnds(const Sequence* s, int link, double from[3], double to[3]) {
  const Frame own = sequenceLocalFrame(s, link);
  sequenceLocal(s, s->parent[link], s->joint[link].torsion[0], from);
  transformPointBack(&own, from, from);
  sequenceLocal(s, link, s->joint[link].origin, to);
}

/* Most side branches around a link: each has less than half of the slots of the one around it. */
enum { MOST_NESTED_SIDE_BRANCHES = 5 };

/* A walk along the sequence: the frame of a link in the frame in which the walk began. */
typedef struct Walk {
  Columns frame;
  Columns stem[MOST_NESTED_SIDE_BRANCHES]; /* of the side branches that the link is in: the frame of the link on which
                                              each hangs */
  int openCount;
  int link;
} Walk;

/* Begins a walk at a link that is in no side branch. */
CT_INLINE void walkBegin(Walk* walk, int link) {
  const Frame identity = transformIdentity();
  columnsOf(&identity, &walk->frame);
  walk->openCount = 0;
  walk->link = link;
}

/* Takes a walk on to a link that hangs on its own, by the link's local frame as columnsCompose takes it. */
CT_INLINE void walkEnter(Walk* walk, const Sequence* s, int link, const double* localFrame, size_t stride) {
  if (s->sideBranchPart[link] >= beginsInnerBranch) {
    walk->stem[walk->openCount++] = walk->frame;
  }
  columnsCompose(&walk->frame, localFrame, stride);
  walk->link = link;
}

/* Takes a walk back to the parent of the next link, if that is not the walk's own. */
CT_INLINE void walkLeave(Walk* walk, const Sequence* s) {
  const int parent = s->parent[walk->link + 1];
  if (parent != walk->link) {
    if (walk->openCount > 0) {
      walk->frame = walk->stem[--walk->openCount];
    } else {
      columnsCompose(&walk->frame, s->returnFrame[s->pathOf[walk->link]].m[0], 1);
    }
    walk->link = parent;
  }
}

/* Takes a walk on to the next link. */
CT_INLINE void walkToNext(Walk* walk, const Sequence* s, const double* localFrame, size_t stride) {
  const int next = walk->link + 1;
  walkLeave(walk, s);
  walkEnter(walk, s, next, localFrame, stride);
}

/* Takes a walk on to a link that is not before its own. */
static inline void walkTo(Walk* walk, const Sequence* s, int link) {
  while (walk->link < link) {
    const Frame localFrame = sequenceLocalFrame(s, walk->link + 1);
    walkToNext(walk, s, localFrame.m[0], 1);
  }
}

/* Begins a walk at a link in a side branch; `stem` is the frame of the link on which the side branch hangs. */
CT_INLINE void walkBeginInSideBranch(Walk* walk, const Sequence* s, int link, const Frame* stem) {
  int way[SIDE_BRANCH_SLOTS]; /* links have a slot at least */
  int count = 0;
  way[count++] = link;
  while (s->sideBranchPart[way[count - 1]] != beginsSideBranch) {
    way[count] = s->parent[way[count - 1]];
    count++;
  }
  columnsOf(stem, &walk->frame);
  walk->openCount = 0;
  walk->link = s->parent[way[count - 1]];
  while (count > 0) {
    const Frame localFrame = sequenceLocalFrame(s, way[--count]);
    walkEnter(walk, s, way[count], localFrame.m[0], 1);
  }
}

/* The frame of the parent of a link in a side branch, in that in which a walk would begin; `stem` as above. */
CT_INLINE void sideBranchParent(const Sequence* s, int link, const Frame* stem, Columns* frame) {
  int way[SIDE_BRANCH_SLOTS];
  int count = 0;
  for (; s->sideBranchPart[link] != beginsSideBranch; link = s->parent[link]) {
    way[count++] = s->parent[link];
  }
  columnsOf(stem, frame);
  while (count > 0) {
    const Frame localFrame = sequenceLocalFrame(s, way[--count]);
    columnsCompose(frame, localFrame.m[0], 1);
  }
}

#endif /* CT_SEQUENCE_H_ */
