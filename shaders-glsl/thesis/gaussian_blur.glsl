// The 7-tap separable Gaussian of thesis 4.3.2 (Eq. 4.8, sigma = 1; the listing's weights), one
// direction. `tap` is a function of texture coordinates: what a sample reads.

#define GAUSSIAN_BLUR(tap, texCoord, direction) \
    ( tap((texCoord) + (direction) * 3.0) * 0.002 \
    + tap((texCoord) + (direction) * 2.0) * 0.028 \
    + tap((texCoord) + (direction) * 1.0) * 0.233 \
    + tap((texCoord)) * 0.474 \
    + tap((texCoord) + (direction) * -1.0) * 0.233 \
    + tap((texCoord) + (direction) * -2.0) * 0.028 \
    + tap((texCoord) + (direction) * -3.0) * 0.002)
