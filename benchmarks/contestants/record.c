#include "race.h"

static const char* comma(int i) {
  return i == 0 ? "" : ", ";
}

void recordScene(FILE* file, const Scene* scene) {
  fputs("{\"particles\": [", file);
  for (int i = 0; i < scene->particleCount; i++) {
    const Sphere* sphere = &scene->spheres[i];
    fprintf(file, "%s[%.17g, %.17g, %.17g, %.17g]", comma(i), sphere->x[0], sphere->x[1], sphere->x[2], sphere->radius);
  }
  fputs("], \"names\": [", file);
  for (int i = 0; i < scene->particleCount; i++) {
    fprintf(file, "%s%d", comma(i), scene->particleNames[i]);
  }
  fputs("], \"torsions\": [", file);
  for (int t = 0; t < scene->torsionCount; t++) {
    const Torsion* torsion = &scene->torsions[t];
    fprintf(file, "%s[%d, %d, %d, %d]", comma(t), torsion->axis[0], torsion->axis[1], torsion->first, torsion->last);
  }
  fputs("], \"exclusions\": [", file);
  for (int k = 0; k < scene->exclusionCount; k++) {
    fprintf(file, "%s[%d, %d]", comma(k), scene->exclusions[k][0], scene->exclusions[k][1]);
  }
  fputs("]}\n", file);
}

void recordTrial(FILE* file, int count, const Turn* turns, bool clash) {
  fputs("{\"turns\": [", file);
  for (int i = 0; i < count; i++) {
    fprintf(file, "%s[%d, %.17g]", comma(i), turns[i].torsion, turns[i].angle);
  }
  fprintf(file, "], \"clash\": %s}\n", clash ? "true" : "false");
}
