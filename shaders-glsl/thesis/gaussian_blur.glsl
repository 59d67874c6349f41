// The 7-tap separable Gaussian of thesis 4.3.2 (Eq. 4.8; the listing's weights, whose sigma is 0.85, not 1), one
// direction. `tap` is a function of texture coordinates: what a sample reads.

#include "common/constants.glsl"

// Print: §4.3.2, listing.
// 1-8: taps at 3, 2, 1, 0, -1, -2, -3, times 0.002, 0.028, 0.233, 0.474, 0.233, 0.028, 0.002
// Departure: one macro for both directions.
#define GAUSSIAN_BLUR(tap, texCoord, direction) \
    ( tap((texCoord) + (direction) * 3.0) * GAUSSIAN_3 \
    + tap((texCoord) + (direction) * 2.0) * GAUSSIAN_2 \
    + tap((texCoord) + (direction) * 1.0) * GAUSSIAN_1 \
    + tap((texCoord)) * GAUSSIAN_0 \
    + tap((texCoord) + (direction) * -1.0) * GAUSSIAN_1 \
    + tap((texCoord) + (direction) * -2.0) * GAUSSIAN_2 \
    + tap((texCoord) + (direction) * -3.0) * GAUSSIAN_3)
