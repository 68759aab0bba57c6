/* Trials are distributed as they are said to be. */
#include <math.h>
#include <string.h>

#include "chains.h"
#include "check.h"
#include "moves.h"
#include "rigid.h"

enum { TRIALS = 4000 };

static Moves makeMoves(const Scene* scene, MoveKind kind, double angle, int kappa) {
  Moves moves;
  char error[200] = "";
  CHECK(movesInit(&moves, scene, (MoveRule){kind, angle, kappa}, 1, error, sizeof error));
  return moves;
}

static void testSingleTorsions(const Scene* scene) {
  Moves uniform = makeMoves(scene, movesUniform, 0.1, 1);
  Moves gaussian = makeMoves(scene, movesGaussian, 0.1, 1);
  double uniformSquares = 0;
  double gaussianSquares = 0;
  double torsions = 0;
  for (int i = 0; i < TRIALS; i++) {
    Turn turn;
    movesNext(&uniform, NULL, &turn);
    CHECK(fabs(turn.angle) <= PI && turn.torsion >= 0 && turn.torsion < scene->torsionCount);
    uniformSquares += turn.angle * turn.angle / TRIALS;
    torsions += turn.torsion / (double)TRIALS;
    movesNext(&gaussian, NULL, &turn);
    gaussianSquares += turn.angle * turn.angle / TRIALS;
  }
  CHECK(fabs(sqrt(uniformSquares) - PI / sqrt(3)) < 0.1);
  CHECK(fabs(sqrt(gaussianSquares) - 0.1) < 0.005);
  CHECK(fabs(torsions - 0.5 * scene->torsionCount) < 0.05 * scene->torsionCount);
  movesFree(&uniform);
  movesFree(&gaussian);
}

/* How far the particle behind the last of eight torsions goes, to first order, in the mean. */
static double drift(const Scene* scene, MoveKind kind) {
  Moves moves = makeMoves(scene, kind, 0.1, 8);
  double squares = 0;
  for (int i = 0; i < TRIALS; i++) {
    Turn turns[8];
    double moved[3] = {0, 0, 0};
    movesNext(&moves, scene->spheres, turns);
    for (int k = 0; k < 8; k++) {
      const int* axis = scene->torsions[turns[k].torsion].axis;
      double u[3];
      double arm[3];
      double v[3];
      subtract(scene->spheres[axis[1]].x, scene->spheres[axis[0]].x, u);
      subtract(scene->spheres[turns[7].torsion + 3].x, scene->spheres[axis[0]].x, arm);
      cross(u, arm, v);
      for (int c = 0; c < 3; c++) {
        moved[c] += turns[k].angle * v[c] / 4;
      }
      CHECK(k == 0 || turns[k].torsion == turns[k - 1].torsion + 1);
    }
    squares += dot(moved, moved) / TRIALS;
  }
  movesFree(&moves);
  return sqrt(squares);
}

static void testSideChains(Scene* scene) {
  Moves moves;
  char error[200] = "";
  CHECK(!movesInit(&moves, scene, (MoveRule){movesSideChain, 0.1, 1}, 1, error, sizeof error));
  CHECK(strstr(error, "side chains") != NULL);
  scene->torsions[3].sideChain = true;
  scene->torsions[5].sideChain = true;
  moves = makeMoves(scene, movesSideChain, 0.1, 1);
  Moves steps = makeMoves(scene, movesSideChainStep, 0.1, 1);
  Moves backbone = makeMoves(scene, movesUniform, 0.1, 1);
  double squares = 0;
  for (int i = 0; i < TRIALS; i++) {
    Turn turn;
    movesNext(&moves, NULL, &turn);
    CHECK(scene->torsions[turn.torsion].sideChain);
    movesNext(&steps, NULL, &turn);
    CHECK(scene->torsions[turn.torsion].sideChain);
    squares += turn.angle * turn.angle / TRIALS;
    movesNext(&backbone, NULL, &turn);
    CHECK(!scene->torsions[turn.torsion].sideChain);
  }
  CHECK(fabs(sqrt(squares) - 0.1) < 0.005);
  movesFree(&moves);
  movesFree(&steps);
  movesFree(&backbone);
}

int main(void) {
  Scene* scene = chainHilbert(100);
  testSingleTorsions(scene);
  CHECK(drift(scene, movesBiased) < 0.3 * drift(scene, movesGaussian));
  testSideChains(scene);
  sceneFree(scene);
  return checkResult();
}
