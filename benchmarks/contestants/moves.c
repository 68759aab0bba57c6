#include "moves.h"

#include "rigid.h"

/* Particles behind the last torsion that biased moves hold in place: three fix a rigid body. */
enum { HELD_PARTICLES = 3 };

bool movesInit(Moves* moves, const Scene* scene, MoveRule rule, uint64_t seed, char* error, size_t size) {
  *moves = (Moves){.scene = scene, .rule = rule, .random = {seed}};
  moves->choices = allocate(scene->torsionCount, sizeof(int));
  const bool sideChains = rule.kind == movesSideChain || rule.kind == movesSideChainStep;
  for (int t = 0; t < scene->torsionCount; t++) {
    if (scene->torsions[t].sideChain == sideChains) {
      moves->choices[moves->choiceCount++] = t;
    }
  }
  if (moves->choiceCount < rule.kappa) {
    snprintf(error, size, "the chain has %d %s, which are fewer than the %d of a move", moves->choiceCount,
             sideChains ? "torsions of side chains" : "torsions of the backbone", rule.kappa);
    movesFree(moves);
    return false;
  }
  return true;
}

void movesFree(Moves* moves) {
  free(moves->choices);
  moves->choices = NULL;
}

/* ---- Biased Gaussian steps ---- */

/* The lower triangle of a symmetric positive definite matrix becomes its Cholesky factor. */
static void factorize(int n, double a[][MOST_TURNS]) {
  for (int i = 0; i < n; i++) {
    for (int j = 0; j <= i; j++) {
      double sum = a[i][j];
      for (int k = 0; k < j; k++) {
        sum -= a[i][k] * a[j][k];
      }
      a[i][j] = i == j ? sqrt(sum) : sum / a[j][j];
    }
  }
}

/* How far a particle goes per radian of a turn. */
static void velocity(const Scene* scene, const Sphere* spheres, int torsion, int particle, double v[3]) {
  const double* from = spheres[scene->torsions[torsion].axis[0]].x;
  double axis[3];
  double arm[3];
  subtract(spheres[scene->torsions[torsion].axis[1]].x, from, axis);
  subtract(spheres[particle].x, from, arm);
  cross(axis, arm, v);
  const double length = sqrt(dot(axis, axis));
  for (int k = 0; k < 3; k++) {
    v[k] /= length;
  }
}

/* The step of Favrin, Irback and Sjunnesson (2001): changes are distributed with the precision (1 + b G) / angle^2,
 * where G is the metric of the displacements of the held particles. Their b is some 20 per squared length of a bond. */
static void biasedAngles(const Moves* moves, const Sphere* spheres, Random* random, Turn* turns) {
  const int n = moves->rule.kappa;
  const Scene* scene = moves->scene;
  const Torsion* last = &scene->torsions[turns[n - 1].torsion];
  const double bias = 20 / squaredDistance(spheres[last->axis[0]].x, spheres[last->axis[1]].x);
  double precision[MOST_TURNS][MOST_TURNS] = {{0}};
  for (int h = 0; h < HELD_PARTICLES && last->axis[1] + 1 + h < last->last; h++) {
    double velocities[MOST_TURNS][3];
    for (int i = 0; i < n; i++) {
      velocity(scene, spheres, turns[i].torsion, last->axis[1] + 1 + h, velocities[i]);
      for (int j = 0; j <= i; j++) {
        precision[i][j] += bias * dot(velocities[i], velocities[j]);
      }
    }
  }
  for (int i = 0; i < n; i++) {
    precision[i][i] += 1;
  }
  factorize(n, precision);
  for (int i = n - 1; i >= 0; i--) {
    double sum = moves->rule.angle * randomGaussian(random);
    for (int k = i + 1; k < n; k++) {
      sum -= precision[k][i] * turns[k].angle;
    }
    turns[i].angle = sum / precision[i][i];
  }
}

void movesNext(Moves* moves, const Sphere* spheres, Turn* turns) {
  const int kappa = moves->rule.kappa;
  const int begin = randomInt(&moves->random, moves->choiceCount - kappa + 1);
  for (int i = 0; i < kappa; i++) {
    turns[i].torsion = moves->choices[begin + i];
  }
  if (moves->rule.kind == movesBiased) {
    biasedAngles(moves, spheres, &moves->random, turns);
    return;
  }
  const bool isStep = moves->rule.kind == movesGaussian || moves->rule.kind == movesSideChainStep;
  for (int i = 0; i < kappa; i++) {
    turns[i].angle =
        isStep ? moves->rule.angle * randomGaussian(&moves->random) : PI * (2 * randomReal(&moves->random) - 1);
  }
}
