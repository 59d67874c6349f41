// How a ray ended; the codes are those of `passes::PathCode`.

#define PATH_NONE          0.0 // the pixel does not reflect
#define PATH_HI_Z          1.0 // hit by Hi-Z traversal
#define PATH_LINEAR        2.0 // hit by a linear march
#define PATH_MISS          3.0 // Hi-Z traversal left the screen
#define PATH_LINEAR_MISS   4.0 // a linear march found nothing
#define PATH_EXHAUSTED     5.0 // out of iterations; the thesis takes it for a hit
#define PATH_UNTRACED      6.0 // towards the camera, and no fallback
