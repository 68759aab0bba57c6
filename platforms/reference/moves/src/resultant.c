#include "resultant.h"

#include "vector.h"

/* The equation of a corner: coefficients of 1, cos and sin of the turn of the piece before it (rows) and of that after
 * it. */
static void formOfCorner(const Triangle* t, int corner, double form[3][3]) {
  const double* a = t->before[corner].first;
  const double* b = t->after[corner].second;
  const double c = t->cosines[corner];
  const double s = t->sines[corner];
  form[0][0] = c * a[0] * b[0] - t->angles[corner];
  form[0][1] = -s * a[0] * b[1];
  form[0][2] = s * a[0] * b[2];
  form[1][0] = s * a[1] * b[0];
  form[2][0] = -s * a[2] * b[0];
  form[1][1] = c * a[1] * b[1] + a[2] * b[2];
  form[1][2] = a[2] * b[1] - c * a[1] * b[2];
  form[2][1] = a[1] * b[2] - c * a[2] * b[1];
  form[2][2] = c * a[2] * b[2] + a[1] * b[1];
}

/* c = c + f a b, of polynomials with n coefficients each. */
CT_INLINE void addProduct(int n, double f, const double* a, const double* b, double* c) {
  for (int i = 0; i < n; i++) {
    const double factor = f * a[i];
    for (int j = 0; j < n; j++) {
      c[i + j] += factor * b[j];
    }
  }
}

/* A vector whose entries are linear in (1, cos x, sin x), as polynomials in t: times 1 + t^2. */
typedef struct Curve {
  double m[3][3];
} Curve;

static void curveOf(const double at1[3], const double atCos[3], const double atSin[3], Curve* curve) {
  for (int k = 0; k < 3; k++) {
    curve->m[k][0] = at1[k] + atCos[k];
    curve->m[k][1] = 2 * atSin[k];
    curve->m[k][2] = at1[k] - atCos[k];
  }
}

/* p*q = p0 q0 - p1 q1 - p2 q2: zero for p = q = (1, cos, sin). */
static void starProduct(const Curve* p, const Curve* q, double* product) {
  for (int i = 0; i <= CT_REACH; i++) {
    product[i] = 0;
  }
  addProduct(3, 1, p->m[0], q->m[0], product);
  addProduct(3, -1, p->m[1], q->m[1], product);
  addProduct(3, -1, p->m[2], q->m[2], product);
}

/* The largest Bernstein coefficient of a polynomial of degree 8. */
static double sizeOf(const double b[9]) {
  static const double binomials[9] = {1, 8, 28, 56, 70, 56, 28, 8, 1};
  double most = 0;
  for (int i = 0; i < 9; i++) {
    const double size = fabs(b[i]) / binomials[i];
    most = size > most ? size : most;
  }
  return most;
}

static double star(const double p[3], const double q[3]) {
  return p[0] * q[0] - p[1] * q[1] - p[2] * q[2];
}

void makeResultant(const Triangle* t, int piece, double cosine, double sine, Resultant* r) {
  const int corners[3] = {(piece + 1) % 3, (piece + 2) % 3, piece};
  r->piece = piece;
  formOfCorner(t, corners[0], r->a);
  formOfCorner(t, corners[1], r->b);
  formOfCorner(t, corners[2], r->c);
  for (int k = 0; k < 3; k++) {
    const double a = r->a[1][k];
    const double c = r->c[k][1];
    r->a[1][k] = cosine * a + sine * r->a[2][k];
    r->a[2][k] = cosine * r->a[2][k] - sine * a;
    r->c[k][1] = cosine * c + sine * r->c[k][2];
    r->c[k][2] = cosine * r->c[k][2] - sine * c;
  }
  /* v = A'X, w = CX: lines on which Y and Z are. */
  Curve v, w, h;
  curveOf(r->a[0], r->a[1], r->a[2], &v);
  double columns[3][3]; /* of b */
  double across[3][3];  /* and the cross products of two of them: rows of the adjugate */
  double c[3][3];       /* columns of c */
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 3; i++) {
      columns[k][i] = r->b[i][k];
      c[k][i] = r->c[i][k];
    }
  }
  curveOf(c[0], c[1], c[2], &w);
  cross(columns[1], columns[2], across[0]);
  cross(columns[2], columns[0], across[1]);
  cross(columns[0], columns[1], across[2]);
  /* h = B'Gv, with G = diag(1, -1, -1) */
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 3; i++) {
      h.m[k][i] = columns[k][0] * v.m[0][i] - columns[k][1] * v.m[1][i] - columns[k][2] * v.m[2][i];
    }
  }
  double vv[5], ww[5], hh[5], wh[5];
  starProduct(&v, &v, vv);
  starProduct(&w, &w, ww);
  starProduct(&h, &h, hh);
  starProduct(&w, &h, wh);
  double p[3][3]; /* B'GB */
  for (int j = 0; j < 3; j++) {
    for (int k = 0; k < 3; k++) {
      p[j][k] = star(columns[j], columns[k]);
    }
  }
  /* w'[P, G]w, where [P, G] is what of the adjugate of P + l G is linear in l; and S = w'adj(B)v. */
  double pw[5] = {0}, s[5] = {0};
  addProduct(3, -(p[1][1] + p[2][2]), w.m[0], w.m[0], pw);
  addProduct(3, p[2][2] - p[0][0], w.m[1], w.m[1], pw);
  addProduct(3, p[1][1] - p[0][0], w.m[2], w.m[2], pw);
  addProduct(3, 2 * p[0][1], w.m[0], w.m[1], pw);
  addProduct(3, 2 * p[0][2], w.m[0], w.m[2], pw);
  addProduct(3, -2 * p[1][2], w.m[1], w.m[2], pw);
  for (int k = 0; k < 3; k++) {
    double line[3];
    for (int i = 0; i < 3; i++) {
      line[i] = across[k][0] * v.m[0][i] + across[k][1] * v.m[1][i] + across[k][2] * v.m[2][i];
    }
    addProduct(3, 1, w.m[k], line, s);
  }
  double u[9] = {0}, both[9] = {0}, ss[9] = {0};
  addProduct(5, 1, vv, pw, u);
  addProduct(5, -1, ww, hh, u);
  addProduct(5, 1, wh, wh, u);
  addProduct(5, 1, vv, ww, both);
  addProduct(5, 1, s, s, ss);
  for (int i = 0; i <= CT_ROOTS; i++) {
    r->f[i] = 0;
  }
  addProduct(9, 1, u, u, r->f);
  addProduct(9, -4, both, ss, r->f);
  const double size = sizeOf(u);
  r->scale = size * size + 4 * sizeOf(both) * sizeOf(ss);
  for (int i = 0; i <= CT_REACH; i++) {
    r->y[i] = -vv[i];
    r->z[i] = -ww[i];
  }
}

/* The two (1, cos, sin) on a line, or the nearest one where the line passes by. */
static void pointsOnLine(const double v[3], double points[2][3]) {
  const double square = v[1] * v[1] + v[2] * v[2];
  const double discriminant = square - v[0] * v[0];
  const double root = discriminant > 0 ? sqrt(discriminant) : 0;
  const double inverse = discriminant > 0 ? 1 / square : 1 / (fabs(v[0]) * sqrt(square));
  for (int i = 0; i < 2; i++) {
    const double sign = i == 0 ? root : -root;
    points[i][0] = 1;
    points[i][1] = (-v[0] * v[1] - sign * v[2]) * inverse;
    points[i][2] = (-v[0] * v[2] + sign * v[1]) * inverse;
  }
}

void findOthers(const Resultant* r, double cosine, double sine, Others others[4]) {
  double v[3], w[3], ys[2][3], zs[2][3];
  for (int k = 0; k < 3; k++) {
    v[k] = r->a[0][k] + r->a[1][k] * cosine + r->a[2][k] * sine;
    w[k] = r->c[k][0] + r->c[k][1] * cosine + r->c[k][2] * sine;
  }
  pointsOnLine(v, ys);
  pointsOnLine(w, zs);
  for (int i = 0; i < 2; i++) {
    double m[3];
    for (int k = 0; k < 3; k++) {
      m[k] = r->b[0][k] + r->b[1][k] * ys[i][1] + r->b[2][k] * ys[i][2];
    }
    for (int j = 0; j < 2; j++) {
      const double gap = fabs(dot(m, zs[j]));
      others[2 * i + j] = (Others){{ys[i][1], ys[i][2]}, {zs[j][1], zs[j][2]}, gap};
    }
  }
}
