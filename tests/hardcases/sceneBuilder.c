#include "sceneBuilder.h"

#include <stdlib.h>
#include <string.h>

static void makeRoom(void** array, int room, size_t size)
{
    *array = realloc(*array, (size_t)room * size);
    if (*array == NULL)
        abort();
}

static int addLink(Scene* scene, int parent, ctJointKind joint, int inner, int outer)
{
    if (scene->linkCount == scene->linkRoom) {
        scene->linkRoom = 2 * scene->linkRoom + 16;
        makeRoom((void**)&scene->linkParents, scene->linkRoom, sizeof(int));
        makeRoom((void**)&scene->linkJoints, scene->linkRoom, 1);
        makeRoom((void**)&scene->linkTorsions, scene->linkRoom, sizeof(int[4]));
    }
    const int torsion[4] = {inner, inner, outer, outer};
    memcpy(scene->linkTorsions[scene->linkCount], torsion, sizeof torsion);
    scene->linkParents[scene->linkCount] = parent;
    scene->linkJoints[scene->linkCount] = (unsigned char)joint;
    return scene->linkCount++;
}

int addFixedLink(Scene* scene)
{
    return addLink(scene, CT_NULL, ctFixedJoint, 0, 0);
}

int addFreeLink(Scene* scene)
{
    return addLink(scene, CT_NULL, ctFreeJoint, 0, 0);
}

int addTorsionLink(Scene* scene, int parent, int inner, int outer)
{
    return addLink(scene, parent, ctTorsionJoint, inner, outer);
}

int addParticle(Scene* scene, int link, double x, double y, double z, double radius)
{
    if (scene->particleCount == scene->particleRoom) {
        scene->particleRoom = 2 * scene->particleRoom + 16;
        makeRoom((void**)&scene->positions, scene->particleRoom, sizeof(double[3]));
        makeRoom((void**)&scene->radii, scene->particleRoom, sizeof(double));
        makeRoom((void**)&scene->particleLinks, scene->particleRoom, sizeof(int));
    }
    const double position[3] = {x, y, z};
    memcpy(scene->positions + 3 * scene->particleCount, position, sizeof position);
    scene->radii[scene->particleCount] = radius;
    scene->particleLinks[scene->particleCount] = link;
    return scene->particleCount++;
}

void addExclusion(Scene* scene, int particle1, int particle2)
{
    if (scene->exclusionCount == scene->exclusionRoom) {
        scene->exclusionRoom = 2 * scene->exclusionRoom + 16;
        makeRoom((void**)&scene->exclusions, scene->exclusionRoom, sizeof(int[2]));
    }
    const int pair[2] = {particle1, particle2};
    memcpy(scene->exclusions[scene->exclusionCount++], pair, sizeof pair);
}

void addChain(Scene* scene, ctJointKind root, int count, const double (*points)[3], double radius, int excluded)
{
    const int first = scene->particleCount;
    int link = CT_NULL;
    for (int i = first; i < first + count; i++) {
        link = i == first ? addLink(scene, CT_NULL, root, 0, 0) : addTorsionLink(scene, link, i - 1, i);
        addParticle(scene, link, points[i - first][0], points[i - first][1], points[i - first][2], radius);
        for (int other = i - excluded > first ? i - excluded : first; other < i; other++)
            addExclusion(scene, other, i);
    }
}

void sceneFree(Scene* scene)
{
    free(scene->positions);
    free(scene->radii);
    free(scene->particleLinks);
    free(scene->linkParents);
    free(scene->linkJoints);
    free(scene->linkTorsions);
    free(scene->exclusions);
    *scene = (Scene){0};
}

ctDefinition sceneDefinition(const Scene* scene)
{
    return (ctDefinition){.particleCount = scene->particleCount,
                          .positions = scene->positions,
                          .radii = scene->radii,
                          .particleLinks = scene->particleLinks,
                          .linkCount = scene->linkCount,
                          .linkParents = scene->linkParents,
                          .linkJoints = scene->linkJoints,
                          .linkTorsions = (const int(*)[4])scene->linkTorsions,
                          .exclusionCount = scene->exclusionCount,
                          .exclusions = (const int(*)[2])scene->exclusions,
                          .overlapTolerance = scene->overlapTolerance};
}
