#ifndef OPENMM_CHAINTREE_RANDOMNUMBERGENERATOR_H_
#define OPENMM_CHAINTREE_RANDOMNUMBERGENERATOR_H_

#include "openmm/Vec3.h"
#include "openmmchaintree/internal/MersenneTwister.h"
#include <cmath>
#include <cstdint>
#include <locale>
#include <sstream>
#include <string>

namespace ChainTreePlugin {

/**
 * This class draws random numbers that depend only on the seed. The distributions of the standard library differ
 * between its implementations, and so would trajectories.
 */
class RandomNumberGenerator {
public:
    explicit RandomNumberGenerator(uint64_t seed) : engine(seed)
    {
    }
    /**
     * Draw a number from [0, 1).
     */
    double drawUniform()
    {
        return (engine() >> 11) * 0x1p-53;
    }
    /**
     * Draw a number from [-limit, limit).
     */
    double drawSymmetric(double limit)
    {
        return (2 * drawUniform() - 1) * limit;
    }
    /**
     * Draw one of the numbers 0 ... count-1, for count > 0.
     */
    int drawIndex(int count)
    {
        const uint64_t range = count;
        uint64_t value = engine();
        while (value > UINT64_MAX - range && value >= UINT64_MAX - UINT64_MAX % range)
            value = engine();
        return value % range;
    }
    /**
     * Draw a number from the normal distribution of mean 0 and variance 1, by Marsaglia's polar method. The second
     * number of the method is discarded, so that the engine's state is the whole state.
     */
    double drawNormal()
    {
        double x, square;
        do {
            x = drawSymmetric(1);
            const double y = drawSymmetric(1);
            square = x * x + y * y;
        } while (square >= 1 || square == 0);
        return x * std::sqrt(-2 * std::log(square) / square);
    }
    /**
     * Draw a point from a ball about the origin.
     */
    OpenMM::Vec3 drawPointInBall(double radius)
    {
        return drawPointInUnitBall() * radius;
    }
    /**
     * Draw a vector of length 1.
     */
    OpenMM::Vec3 drawDirection()
    {
        OpenMM::Vec3 point;
        do
            point = drawPointInUnitBall();
        while (point.dot(point) < 1e-6);
        return point / std::sqrt(point.dot(point));
    }
    /**
     * Draw a rotation vector: about an axis in any direction, by an angle from -limit to limit. If the limit is pi, or
     * more by rounding, all rotations are equally likely: then the density of the angle is (1 - cos(angle))/(2 pi).
     */
    OpenMM::Vec3 drawRotation(double limit)
    {
        OpenMM::Vec3 axis = drawDirection();
        double angle = drawSymmetric(limit);
        if (limit >= M_PI)
            while (2 * drawUniform() > 1 - std::cos(angle))
                angle = drawSymmetric(limit);
        return axis * angle;
    }

    /**
     * Get the state, which determines all further numbers.
     */
    std::string getState() const
    {
        std::stringstream stream;
        stream.imbue(std::locale::classic());
        engine.write(stream);
        return stream.str();
    }
    /**
     * Set the state that getState() returned. Returns false, and changes nothing, if it is not such a state.
     */
    bool setState(const std::string& state)
    {
        std::stringstream stream(state);
        stream.imbue(std::locale::classic());
        return engine.read(stream);
    }

private:
    OpenMM::Vec3 drawPointInUnitBall()
    {
        OpenMM::Vec3 point;
        do
            for (int i = 0; i < 3; i++)
                point[i] = drawSymmetric(1);
        while (point.dot(point) > 1);
        return point;
    }
    MersenneTwister engine;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_RANDOMNUMBERGENERATOR_H_*/
