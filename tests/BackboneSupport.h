#ifndef OPENMM_CHAINTREE_BACKBONESUPPORT_H_
#define OPENMM_CHAINTREE_BACKBONESUPPORT_H_

/**
 * Common code of the tests of closed moves: backbones like those of proteins, and a window of them.
 */

#include "ctclosure.h"
#include "TestSupport.h"

namespace ChainTreePlugin {

/**
 * A backbone of n, alpha and c, whose phi and psi turn, with peptide bonds of any dihedral: one is cis, none is flat.
 */
class Backbone {
public:
    /**
     * @param numTorsions  psi of the first residue and so on
     * @param numMore      the number of particles that follow, in a molecule of their own, as if the bond to them was
     * cut
     */
    Backbone(int numTorsions, double radius, int numMore = 0) : force(new StericExclusionForce())
    {
        system.addForce(force);
        force->setOverlapTolerance(0);
        const double lengths[] = {0.1329, 0.1458, 0.1525}, angles[] = {2.03, 2.12, 1.94};
        const double omegas[] = {3.1, -2.9, 0.2, -3.0};
        const int numParticles = 3 * (numTorsions / 2 + 1) + (numTorsions % 2 == 0 ? 0 : 1);
        for (int i = 0; i < numParticles + numMore; i++) {
            const int kind = i % 3; // n, alpha, c
            system.addParticle(1);
            force->addParticle(radius);
            if (i > 0 && i != numParticles)
                force->addBond(i - 1, i);
            const double dihedral = kind == 1 ? omegas[i / 3 % 4] : kind == 2 ? -1.2 : 2.3;
            positions.push_back(place(lengths[kind], angles[(i + 2) % 3], dihedral));
            if (i > 2 && i < numParticles && kind != 1)
                force->addTorsion(i - 3, i - 2, i - 1, i);
        }
        using OpenMM::throwException;
        ASSERT_EQUAL(numTorsions, force->getNumTorsions());
        force->createExclusionsFromBonds(3);
    }
    OpenMM::System system;
    StericExclusionForce* force;
    std::vector<OpenMM::Vec3> positions;

private:
    /** The position at a distance from the last, with an angle there and a dihedral. */
    OpenMM::Vec3 place(double length, double angle, double dihedral) const
    {
        const int size = positions.size();
        if (size == 0)
            return OpenMM::Vec3();
        if (size == 1)
            return OpenMM::Vec3(length, 0, 0);
        const OpenMM::Vec3 last = positions[size - 1],
                           axis = (last - positions[size - 2]) / getDistance(last, positions[size - 2]);
        const OpenMM::Vec3 before = size == 2 ? OpenMM::Vec3(0, 1, 0) : positions[size - 3] - positions[size - 2];
        OpenMM::Vec3 side = before - axis * before.dot(axis);
        side = side / std::sqrt(side.dot(side));
        return last + rotate(axis * -std::cos(angle) + side * std::sin(angle), OpenMM::Vec3(), axis, dihedral) * length;
    }
};

/**
 * The window whose drivers are the first and last of eight torsions from psi of a residue on.
 */
inline ctWindow findWindow(const std::vector<OpenMM::Vec3>& positions, int residue)
{
    ctWindow window;
    window.count = 8;
    for (int i = 0; i < 8; i++) {
        // The bonds after alpha and before alpha, in turns.

        const int begin = 3 * residue + 1 + 3 * (i / 2) + (i % 2 == 0 ? 0 : 2);
        const OpenMM::Vec3 axis =
            (positions[begin + 1] - positions[begin]) / getDistance(positions[begin + 1], positions[begin]);
        const OpenMM::Vec3 point = positions[i % 2 == 0 ? begin : begin + 1];
        for (int j = 0; j < 3; j++) {
            window.points[i][j] = point[j];
            window.axes[i][j] = axis[j];
        }
        if (i > 0 && i < 7)
            window.pivots[i - 1] = i;
    }
    return window;
}

/**
 * The logarithm of the determinant of the pivots' screws.
 */
inline double computeLogJacobian(const ctWindow& window)
{
    double m[6][6];
    for (int i = 0; i < 6; i++) {
        const double *u = window.axes[window.pivots[i]], *p = window.points[window.pivots[i]];
        const OpenMM::Vec3 axis(u[0], u[1], u[2]), moment = OpenMM::Vec3(p[0], p[1], p[2]).cross(axis);
        for (int j = 0; j < 3; j++) {
            m[i][j] = axis[j];
            m[i][j + 3] = moment[j];
        }
    }
    double sum = 0;
    for (int k = 0; k < 6; k++) {
        int pivot = k;
        for (int i = k + 1; i < 6; i++)
            if (std::fabs(m[i][k]) > std::fabs(m[pivot][k]))
                pivot = i;
        std::swap_ranges(m[k], m[k] + 6, m[pivot]);
        sum += std::log(std::fabs(m[k][k]));
        for (int i = k + 1; i < 6; i++)
            for (int j = 5; j >= k; j--)
                m[i][j] -= m[i][k] / m[k][k] * m[k][j];
    }
    return sum;
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_BACKBONESUPPORT_H_*/
