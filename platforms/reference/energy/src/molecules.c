#include "molecules.h"

#include <stdlib.h>

/* Not known yet. */
enum { NO_MOLECULE = -1 };

static bool isFixed(const ctDefinition* scene, int link) {
  return link == CT_NULL || scene->linkJoints[link] == ctFixedJoint;
}

int* ctFindMolecules(const ctDefinition* scene) {
  int* molecules = malloc(((size_t)scene->linkCount + 1) * sizeof *molecules);
  for (int link = 0; molecules != NULL && link < scene->linkCount; link++) {
    molecules[link] = NO_MOLECULE;
  }
  for (int link = 0; molecules != NULL && link < scene->linkCount; link++) {
    int molecule = 0;
    for (int u = link; !isFixed(scene, u); u = scene->linkParents[u]) {
      if (molecules[u] != NO_MOLECULE) {
        molecule = molecules[u];
        break;
      }
      molecule = scene->linkJoints[u] == ctFreeJoint ? u + 1 : 0; /* of the last, which stands on the world */
    }
    for (int u = link; !isFixed(scene, u) && molecules[u] == NO_MOLECULE; u = scene->linkParents[u]) {
      molecules[u] = molecule;
    }
    if (isFixed(scene, link)) {
      molecules[link] = 0;
    }
  }
  return molecules;
}
