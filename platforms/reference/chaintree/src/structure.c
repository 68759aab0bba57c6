/* Whether a definition has the structure that a scene was made from. */
#include "definition.h"
#include "scene.h"

static bool hasArrays(const ctDefinition* d) {
  return (d->particleCount == 0 || d->particleLinks != NULL) &&
         (d->linkCount == 0 || (d->linkParents != NULL && d->linkJoints != NULL));
}

/* True if a torsion or ball joint of the engine's link turns about these particles. */
static bool turnsAbout(const Sequence* s, int link, const int* p) {
  const Joint* joint = &s->joint[link];
  if (s->jointType[link] == ctBallJoint) {
    return p[1] == joint->origin;
  }
  const int other = joint->torsion[0];
  return (p[1] == other && p[2] == joint->origin) || (p[2] == other && p[1] == joint->origin);
}

static bool hasLink(const Sequence* s, const ctDefinition* d, int userLink) {
  const int link = sequenceLink(s, userLink);
  const int parent = d->linkParents[userLink];
  if (d->linkJoints[userLink] != s->jointType[link] || (parent != CT_NULL && !isIndex(parent, d->linkCount))) {
    return false;
  }
  if (link == 0) {
    return parent == CT_NULL;
  }
  if (s->parent[link] != (parent == CT_NULL ? 0 : sequenceLink(s, parent))) {
    return false;
  }
  return s->jointType[link] == ctFreeJoint ||
         (d->linkTorsions != NULL && turnsAbout(s, link, d->linkTorsions[userLink]));
}

bool ctHasStructure(const ctChainTree* tree, const ctDefinition* definition) {
  if (tree == NULL || definition == NULL) {
    return false;
  }
  const Sequence* s = &tree->sequence;
  const ctDefinition* d = definition;
  if (d->isFlexible != s->isFlexible || d->particleCount != s->particleCount || d->linkCount != s->userLinkCount ||
      !hasArrays(d)) {
    return false;
  }
  for (int i = 0; i < d->particleCount; i++) {
    const int link = d->particleLinks[i];
    if (!isIndex(link, d->linkCount) || particleLink(s, i) != sequenceLink(s, link)) {
      return false;
    }
  }
  for (int link = 0; link < d->linkCount; link++) {
    if (!hasLink(s, d, link)) {
      return false;
    }
  }
  return true;
}
