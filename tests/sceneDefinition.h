/* sceneDefinition.h: a random scene as the engine takes it. The oracle's side does not know the engine, so this
 * stands apart. */
#ifndef SCENE_DEFINITION_H_
#define SCENE_DEFINITION_H_

#include "chaintree.h"
#include "oracle/randomScene.h"

#include <stdio.h>
#include <stdlib.h>

/* The arrays stay the scene's and the caller's; listed may be NULL. */
static inline ctDefinition defineScene(const randomScene* scene, const uint8_t* listed)
{
    return (ctDefinition){.particleCount = scene->particleCount,
                          .positions = scene->positions,
                          .radii = scene->radii,
                          .hydrogenBondRoles = scene->roles,
                          .particleLinks = scene->particleLinks,
                          .listed = listed,
                          .linkCount = scene->linkCount,
                          .linkParents = scene->linkParents,
                          .linkJoints = scene->linkJoints,
                          .linkTorsions = (const int(*)[4])scene->linkTorsions,
                          .exclusionCount = scene->exclusionCount,
                          .exclusions = (const int(*)[2])scene->exclusions,
                          .overlapTolerance = scene->overlapTolerance,
                          .hydrogenBondAllowance = scene->hydrogenBondAllowance,
                          .isFlexible = scene->isFlexible != 0};
}

/* Makes a scene that must be right. */
static inline ctChainTree* createDefined(const ctDefinition* definition)
{
    ctChainTree* tree = NULL;
    char text[256];
    if (ctCreate(definition, &tree, text, sizeof text) != ctSuccess) {
        printf("%s\n", text);
        abort();
    }
    return tree;
}

#endif /* SCENE_DEFINITION_H_ */
