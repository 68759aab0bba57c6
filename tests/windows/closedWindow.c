#include "closedWindow.h"

#include "oracle/oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double BOND = 0.15;

/* ---- Chains ---- */

static void* allocate(int count, size_t size)
{
    void* memory = calloc((size_t)count, size);
    if (memory == NULL)
        abort();
    return memory;
}

randomScene makeChainScene(randomSource* random, int links)
{
    randomScene s = {.particleCount = SIDE * links, .linkCount = links, .overlapTolerance = 0.02, .extent = 10};
    s.positions = allocate(3 * s.particleCount, sizeof(double));
    s.radii = allocate(s.particleCount, sizeof(double));
    s.particleLinks = allocate(s.particleCount, sizeof(int));
    s.linkParents = allocate(links, sizeof(int));
    s.linkJoints = allocate(links, 1);
    s.linkTorsions = allocate(4 * links, sizeof(int));
    s.exclusions = allocate(2 * 40 * links, sizeof(int));
    double direction[3] = {1, 0, 0};
    for (int link = 0; link < links; link++) {
        double side[3];
        for (int tries = 0; link > 0; tries++) {
            double next[3];
            randomDirection(random, next);
            const double cosine = next[0] * direction[0] + next[1] * direction[1] + next[2] * direction[2];
            if (cosine > 0.2 && cosine < 0.8) {
                memcpy(direction, next, sizeof next);
                break;
            }
        }
        randomDirection(random, side);
        for (int d = 0; d < 3; d++) {
            double* x = s.positions + 3 * SIDE * link + d;
            x[0] = link > 0 ? x[-3 * SIDE] + BOND * direction[d] : 0;
            x[3] = x[0] + 0.1 * side[d];
        }
        const int own = SIDE * link;
        const int torsion[4] = {link > 1 ? own - 2 * SIDE : 1, own - SIDE, own,
                                link + 1 < links ? own + SIDE : own + 1};
        memcpy(s.linkTorsions + 4 * link, torsion, sizeof torsion);
        s.linkParents[link] = link - 1;
        s.linkJoints[link] = link > 0 ? ORACLE_TORSION : ORACLE_FREE;
        for (int k = 0; k < SIDE; k++) {
            s.radii[own + k] = randomReal(random, 0.04, 0.1);
            s.particleLinks[own + k] = link;
            for (int i = own - 3 * SIDE > 0 ? own - 3 * SIDE : 0; i < own + k; i++) {
                s.exclusions[2 * s.exclusionCount] = i;
                s.exclusions[2 * s.exclusionCount++ + 1] = own + k;
            }
        }
    }
    return s;
}

Window readWindow(const double* positions, int link, int size)
{
    Window window = {.count = size};
    for (int i = 0; i < size; i++) {
        const double* from = positions + 3 * SIDE * (link + i - 1);
        const double* to = positions + 3 * SIDE * (link + i);
        double length = 0;
        for (int d = 0; d < 3; d++) {
            window.points[i][d] = to[d];
            window.directions[i][d] = to[d] - from[d];
            length += window.directions[i][d] * window.directions[i][d];
        }
        for (int d = 0; d < 3; d++)
            window.directions[i][d] /= sqrt(length);
    }
    return window;
}

/* ---- Closing ---- */

typedef struct Motion {
    double rotation[3][3];
    double translation[3];
} Motion;

static void apply(const Motion* m, const double x[3], double y[3])
{
    double moved[3];
    for (int i = 0; i < 3; i++)
        moved[i] = m->rotation[i][0] * x[0] + m->rotation[i][1] * x[1] + m->rotation[i][2] * x[2];
    for (int i = 0; i < 3; i++)
        y[i] = moved[i] + m->translation[i];
}

static void cross(const double a[3], const double b[3], double c[3])
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* m times a turn about an axis. */
static void turn(Motion* m, const double point[3], const double u[3], double angle)
{
    const double c = cos(angle), s = sin(angle), v = 2 * sin(angle / 2) * sin(angle / 2);
    const double r[3][3] = {{c + v * u[0] * u[0], v * u[0] * u[1] - s * u[2], v * u[0] * u[2] + s * u[1]},
                            {v * u[1] * u[0] + s * u[2], c + v * u[1] * u[1], v * u[1] * u[2] - s * u[0]},
                            {v * u[2] * u[0] - s * u[1], v * u[2] * u[1] + s * u[0], c + v * u[2] * u[2]}};
    double shift[3];
    for (int i = 0; i < 3; i++)
        shift[i] = point[i] - (r[i][0] * point[0] + r[i][1] * point[1] + r[i][2] * point[2]);
    Motion product;
    apply(m, shift, product.translation);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            product.rotation[i][j] =
                m->rotation[i][0] * r[0][j] + m->rotation[i][1] * r[1][j] + m->rotation[i][2] * r[2][j];
    *m = product;
}

/* Solves six equations by elimination with pivots; false if they are singular. */
static bool solve(double matrix[6][7], double x[6])
{
    for (int k = 0; k < 6; k++) {
        int pivot = k;
        for (int i = k + 1; i < 6; i++)
            pivot = fabs(matrix[i][k]) > fabs(matrix[pivot][k]) ? i : pivot;
        double row[7];
        memcpy(row, matrix[k], sizeof row);
        memcpy(matrix[k], matrix[pivot], sizeof row);
        memcpy(matrix[pivot], row, sizeof row);
        if (fabs(matrix[k][k]) < 1e-6)
            return false;
        for (int i = k + 1; i < 6; i++)
            for (int j = 6; j >= k; j--)
                matrix[i][j] -= matrix[i][k] / matrix[k][k] * matrix[k][j];
    }
    for (int k = 5; k >= 0; k--) {
        x[k] = matrix[k][6];
        for (int j = k + 1; j < 6; j++)
            x[k] -= matrix[k][j] * x[j];
        x[k] /= matrix[k][k];
    }
    return true;
}

bool closeWindow(const Window* w, const double shift[3], double* angles)
{
    const int first = w->count - 6;
    const double* middle = w->points[w->count / 2];
    memset(angles + first, 0, sizeof(double[6]));
    for (int round = 0; round < 30; round++) {
        Motion m = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};
        double axes[6][3], points[6][3], matrix[6][7], step[6];
        const double none[3] = {0, 0, 0};
        for (int i = 0; i < w->count; i++) {
            if (i >= first) {
                Motion rotation = m;
                memcpy(rotation.translation, none, sizeof none);
                apply(&rotation, w->directions[i], axes[i - first]);
                apply(&m, w->points[i], points[i - first]);
            }
            turn(&m, w->points[i], w->directions[i], angles[i]);
        }
        double image[3], size = 0;
        apply(&m, middle, image);
        for (int k = 0; k < 6; k++) {
            double arm[3], velocity[3];
            for (int d = 0; d < 3; d++)
                arm[d] = image[d] - points[k][d];
            cross(axes[k], arm, velocity);
            for (int d = 0; d < 3; d++) {
                matrix[d][k] = axes[k][d];
                matrix[3 + d][k] = velocity[d];
            }
        }
        for (int d = 0; d < 3; d++) {
            const int e = (d + 1) % 3, f = (d + 2) % 3;
            matrix[d][6] = -0.5 * (m.rotation[f][e] - m.rotation[e][f]);
            matrix[3 + d][6] = middle[d] + shift[d] - image[d];
            size += fabs(matrix[d][6]) + fabs(matrix[3 + d][6]);
        }
        const double trace = m.rotation[0][0] + m.rotation[1][1] + m.rotation[2][2];
        if (size < 3e-15 || (round > 12 && size < 3e-14))
            return trace > 2.9;
        if (!solve(matrix, step))
            return false;
        for (int k = 0; k < 6; k++) {
            angles[first + k] += step[k] > 0.5 ? 0.5 : step[k] < -0.5 ? -0.5 : step[k];
            if (fabs(angles[first + k]) > 2)
                return false;
        }
    }
    return false;
}
