/* Scenes are put in order, read from files, and refused with a sentence that names the culprit. */
#include <string.h>

#include "branches.h"
#include "scenefile.h"

static bool hangsOn(const Scene* scene, int link, int on) {
  while (link != -1 && link != on) {
    link = scene->linkParents[link];
  }
  return link == on;
}

/* Where the interval of a link's parent ends. */
static int parentEnd(const Scene* scene, int link) {
  for (int t = 0; t < scene->torsionCount; t++) {
    if (scene->torsions[t].link == scene->linkParents[link]) {
      return scene->torsions[t].last;
    }
  }
  return scene->particleCount;
}

/* A torsion turns its link and what hangs on it, which is an interval, and the heaviest branch is the last. */
static void testOrder(void) {
  for (uint64_t seed = 0; seed < 20; seed++) {
    Scene* scene = makeBranches(MOST_BRANCH_LINKS, 1 + (int)seed, seed);
    CHECK(scene->torsionCount == scene->linkCount - 1);
    for (int t = 0; t < scene->torsionCount; t++) {
      const Torsion* torsion = &scene->torsions[t];
      const int link = torsion->link;
      CHECK(t == 0 || torsion->first > scene->torsions[t - 1].first);
      CHECK(scene->particleLinks[torsion->axis[0]] == scene->linkParents[link]);
      CHECK(scene->particleLinks[torsion->axis[1]] == link);
      for (int i = 0; i < scene->particleCount; i++) {
        CHECK(hangsOn(scene, scene->particleLinks[i], link) == (i >= torsion->first && i < torsion->last));
      }
      for (int u = t + 1; u < scene->torsionCount; u++) {
        /* the last child of a link reaches to where that link's own interval does; it is the heaviest */
        const Torsion* later = &scene->torsions[u];
        const bool isLast = parentEnd(scene, later->link) == later->last;
        if (isLast && scene->linkParents[later->link] == scene->linkParents[link]) {
          CHECK(later->last - later->first >= torsion->last - torsion->first);
        }
      }
    }
    for (int k = 0; k < scene->exclusionCount; k++) {
      const int* pair = scene->exclusions[k];
      CHECK(sceneExcludes(scene, pair[0], pair[1]) && sceneExcludes(scene, pair[1], pair[0]));
      CHECK(isTooNear(scene, pair[0], pair[1]));
    }
    for (int i = 0; i < scene->particleCount; i++) {
      for (int j = 0; j < i; j++) {
        CHECK(sceneExcludes(scene, i, j) == isTooNear(scene, i, j));
      }
    }
    sceneFree(scene);
  }
}

/* Beside the program, so that others that run at the same time have theirs. */
static char path[1000];

static Scene* readText(const char* text, char* error, size_t size) {
  FILE* file = fopen(path, "w");
  CHECK(file != NULL && fputs(text, file) >= 0 && fclose(file) == 0);
  Scene* scene = sceneRead(path, error, size);
  remove(path);
  return scene;
}

/* Particle 3 hangs on particle 1, and so do particles 4 and 0. */
static void testReading(void) {
  char error[200] = "";
  Scene* scene = readText(
      "chaintree-scene 1\n"
      "particles 5 links 3 exclusions 1\n"
      "0 0 0 0.5 1\n1 0 0 0.5 0\n2 0 0.25 0.5 0\n3 0 0 0.5 2\n-1 0 0 1.5 1\n"
      "-1 -1 -1 0\n0 1 0 0\n0 2 3 1\n"
      "0 4\n",
      error, sizeof error);
  CHECK(scene != NULL);
  if (scene == NULL) {
    return;
  }
  const int names[5] = {1, 2, 3, 0, 4};
  CHECK(memcmp(scene->particleNames, names, sizeof names) == 0);
  CHECK(scene->spheres[1].x[0] == 2 && scene->spheres[1].x[2] == 0.25 && scene->spheres[4].radius == 1.5);
  CHECK(scene->torsionCount == 2);
  CHECK(scene->torsions[0].first == 2 && scene->torsions[0].last == 3 && scene->torsions[0].sideChain);
  CHECK(scene->torsions[1].first == 3 && scene->torsions[1].last == 5 && !scene->torsions[1].sideChain);
  CHECK(scene->torsions[0].axis[0] == 1 && scene->torsions[0].axis[1] == 2);
  CHECK(sceneExcludes(scene, 4, 3) && !sceneExcludes(scene, 4, 2));
  CHECK(sceneLargestRadius(scene) == 1.5);
  sceneFree(scene);
}

static void checkRefusal(const char* text, const char* culprit) {
  char error[200] = "";
  Scene* scene = readText(text, error, sizeof error);
  if (scene != NULL || strstr(error, culprit) == NULL) {
    reportFailure("\"%s\" is refused by \"%s\"\n", text, error);
  }
  sceneFree(scene);
}

static void testRefusals(void) {
  char error[200] = "";
  CHECK(sceneRead("nowhere/scene", error, sizeof error) == NULL && strstr(error, "nowhere/scene") != NULL);
  checkRefusal("", "does not begin");
  checkRefusal("chaintree-scene 2 particles 1 links 1 exclusions 0 0 0 0 1 0 -1 -1 -1 0", "does not begin");
  checkRefusal("chaintree-scene 1 particles 0 links 1 exclusions 0 -1 -1 -1 0", "does not begin");
  checkRefusal("chaintree-scene 1 particles 2 links 1 exclusions 0 0 0 0 1 0 0 0", "ends early");
  checkRefusal("chaintree-scene 1 particles 1 links 1 exclusions 0 0 0 x 1 0 -1 -1 -1 0", "no number");
  checkRefusal("chaintree-scene 1 particles 1 links 1 exclusions 0 0 0 nan 1 0 -1 -1 -1 0", "particle 0");
  checkRefusal("chaintree-scene 1 particles 1 links 1 exclusions 0 0 0 0 0 0 -1 -1 -1 0", "radius");
  checkRefusal("chaintree-scene 1 particles 1 links 1 exclusions 0 0 0 0 1 7 -1 -1 -1 0", "link 7");
  checkRefusal("chaintree-scene 1 particles 1 links 1 exclusions 1 0 0 0 1 0 -1 -1 -1 0 0 1", "exclusion 0");
  checkRefusal("chaintree-scene 1 particles 2 links 2 exclusions 0 0 0 0 1 0 1 0 0 1 1 -1 -1 -1 0 5 0 1 0", "link 5");
  checkRefusal("chaintree-scene 1 particles 2 links 2 exclusions 0 0 0 0 1 0 1 0 0 1 1 -1 -1 -1 0 0 1 0 0",
               "axis of link 1");
  checkRefusal("chaintree-scene 1 particles 2 links 2 exclusions 0 0 0 0 1 0 1 0 0 1 1 1 1 0 0 0 0 1 0", "ring");
}

int main(int argc, char** argv) {
  CHECK(argc > 0 && snprintf(path, sizeof path, "%s.txt", argv[0]) < (int)sizeof path);
  testOrder();
  testReading();
  testRefusals();
  return checkResult();
}
