/* sceneBuilder.h: scenes that grow particle by particle. */
#ifndef SCENE_BUILDER_H_
#define SCENE_BUILDER_H_

#include "chaintree.h"

typedef struct Scene {
    int particleCount, particleRoom;
    double* positions; /* 3 a particle */
    double* radii;
    int* particleLinks;

    int linkCount, linkRoom;
    int* linkParents;
    unsigned char* linkJoints;
    int (*linkTorsions)[4];

    int exclusionCount, exclusionRoom;
    int (*exclusions)[2];

    double overlapTolerance;
} Scene;

/* Each returns the index of the added item. A torsion's link turns about the line from particle `inner`, of the parent,
 * to particle `outer`, of the link itself. */
int addFixedLink(Scene* scene);
int addFreeLink(Scene* scene);
int addTorsionLink(Scene* scene, int parent, int inner, int outer);
int addParticle(Scene* scene, int link, double x, double y, double z, double radius);
void addExclusion(Scene* scene, int particle1, int particle2);

/* Adds a molecule of one particle a link, each of which turns those after it about the bond that leads to its own.
 * Particles that are up to `excluded` apart along it are excluded. */
void addChain(Scene* scene, ctJointKind root, int count, const double (*points)[3], double radius, int excluded);

void sceneFree(Scene* scene);

ctDefinition sceneDefinition(const Scene* scene);

#endif /* SCENE_BUILDER_H_ */
