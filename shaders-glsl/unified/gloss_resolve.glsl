// From the rays of gloss_trace.glsl to the image, for three programs: the reflection of each pixel with a narrow lobe
// (NARROW); that of each cell with a wide lobe (CELLS); and that of each pixel with a wide lobe. Fragment programs
// (gloss_resolve.frag) and compute programs (gloss_resolve.comp) include it. Before that they declare WHOLE: whether they
// run over the whole image. After it they define how rays come to the pixel or cell that gathers them: RaysAround, Row and
// RowAcross.
//
// Over tiles, a pixel that is not of the list is left as it is: the images already hold what it shows. With WHOLE they
// hold nothing, all that reflects is of the list, and the other pixels show their lit colour.

#ifndef UNIFIED_GLOSS_RESOLVE_GLSL
#define UNIFIED_GLOSS_RESOLVE_GLSL

#if defined(NARROW)
#include "unified/resolve_narrow.glsl"
#elif defined(CELLS)
#include "unified/resolve_cells.glsl"
#else
#include "unified/resolve_wide.glsl"
#endif

#endif
