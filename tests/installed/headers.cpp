/* A C++ compiler can read each public header of the C libraries, and each library defines its declarations. */
#include <ctclosure.h>
#include <ctdensity.h>
#include <ctenergy.h>
#include <ctgrowth.h>
#include <ctlocal.h>

#include <chaintree.h>

int main()
{
    ctDestroy(nullptr);
    ctDestroyEnergy(nullptr);
    ctDestroyGrowth(nullptr);
    const double weight = 1, mean = 0, width = 1;
    ctDensity* density = ctCreateRotamers(1, 1, &weight, &mean, &width, 0);
    if (density == nullptr)
        return 1;
    int uniforms = ctCountUniforms(density);
    ctDestroyDensity(density);
    ctWindow window = {};
    double angles[1] = {0};
    ctLocalWindow local = {};
    ctTurnWindow(&window, angles, &window);
    ctTurnLocalWindow(&local, angles, &local);
    return uniforms > 0 ? 0 : 1;
}
