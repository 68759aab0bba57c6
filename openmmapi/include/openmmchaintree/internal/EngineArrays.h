#ifndef OPENMM_CHAINTREE_ENGINEARRAYS_H_
#define OPENMM_CHAINTREE_ENGINEARRAYS_H_

#include "openmm/Vec3.h"
#include <array>
#include <vector>

namespace ChainTreePlugin {

// The libraries in C take arrays of numbers. These functions hand them the contents of a vector without copying them.

static_assert(sizeof(OpenMM::Vec3) == 3 * sizeof(double), "a Vec3 must be three numbers and nothing else");

inline const double* coordinatesOf(const std::vector<OpenMM::Vec3>& vectors)
{
    return reinterpret_cast<const double*>(vectors.data());
}

inline double* coordinatesOf(std::vector<OpenMM::Vec3>& vectors)
{
    return reinterpret_cast<double*>(vectors.data());
}

inline const double (*rowsOf(const std::array<OpenMM::Vec3, 3>& vectors))[3]
{
    return reinterpret_cast<const double(*)[3]>(vectors.data());
}

inline double (*rowsOf(std::array<OpenMM::Vec3, 3>& vectors))[3]
{
    return reinterpret_cast<double(*)[3]>(vectors.data());
}

template <size_t N>
const int (*rowsOf(const std::vector<std::array<int, N>>& arrays))[N]
{
    return reinterpret_cast<const int(*)[N]>(arrays.data());
}

template <size_t N>
int (*rowsOf(std::vector<std::array<int, N>>& arrays))[N]
{
    return reinterpret_cast<int(*)[N]>(arrays.data());
}

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_ENGINEARRAYS_H_*/
