// What shaders and host must mean alike, declared here alone: build.rs makes Rust of it (`math::constants`). Each
// constant stands on a line of its own, `const TYPE NAME = VALUE;`, with a comment above or beside it.

#ifndef COMMON_CONSTANTS_GLSL
#define COMMON_CONSTANTS_GLSL

// A pixel reflects above this reflectivity, if it isn't sky (docs/definitions.md, "Surfaces").
const float REFLECTS_ABOVE = 1e-4;
// Squared length of a normal up to which nothing stands there.
const float NO_NORMAL = 1e-4;
// ξ of Eq. 4.5: the share of the lobe's energy outside the cone.
const float XI = 0.244;
// Exponents of Eq. 4.5 above this count as a mirror's (thesis 4.2.8).
const float MIRROR_ALPHA = 1000.0;
// Share of the view depth that a pixel's surface is taken to measure in depth at least (docs/definitions.md, "Oracle",
// item 3).
const float SHARE_OF_DEPTH = 0.004;
// What stands before both of its neighbours along an axis of the image by more than this share of their view depths is thin:
// they say nothing of how far its surface spans.
const float THIN = 0.05;
// Version 2 of the oracle: fronts of neighbouring pixels, in reversed depth, are of one surface if they lie no
// further apart than this share of the two blocks' thicknesses together. (Of a plane, half is enough.)
const float JOINED = 0.8;
// How far a hit may lie from the depth of its pixel and still be what the pixel shows: this share of its own z, and as
// many metres (docs/definitions.md, "World agreement").
const float VISIBLE_WITHIN = 0.02;
// By how much what a texel shows may lie off the plane of the triangle that a ray meets and still be of its surface: in texels, as
// wide as they are there, since a surface may be curved. Along an edge, the pixels of the next surface lie farther off but for
// the nearest of them.
const float SAME_SURFACE = 0.1;
// What the screen shows around a hit is no part of its colour if it stands before the pixel that was hit by more than so many widths of
// a pixel there, and beside the ray by more than STANDS_BESIDE of them.
const float STANDS_BEFORE = 10.0;
// How far beside the ray that is, in widths of a pixel.
const float STANDS_BESIDE = 3.0;
// It is none either if it does not stand above the plane of the surface that reflects by this share of that width.
const float STANDS_ABOVE = 0.3;
// A length on a surface is found by dividing by the cosine at which the surface is seen. The least cosine that is taken for it:
const float LEAST_FACING = 0.05;
// What the traversal of `unified` takes for infinite: a time at which a ray never leaves a cell.
const float NEVER = 1e30;

// How a ray ended (`passes::PathCode`).
const int PATH_NONE = 0;          // The pixel does not reflect.
const int PATH_HI_Z = 1;          // Hit by Hi-Z traversal.
const int PATH_LINEAR = 2;        // Hit by a linear march: the fallback's, or the method's own.
const int PATH_MISS = 3;          // Hi-Z traversal left the screen.
const int PATH_LINEAR_MISS = 4;   // A linear march found nothing.
const int PATH_EXHAUSTED = 5;     // Out of iterations; the thesis takes it for a hit.
const int PATH_UNTRACED = 6;      // Towards the camera, and the method has no fallback.
const int PATH_UNFINISHED = 7;    // `unified`: out of steps. It cannot be, is never a hit, and is counted all the same.
const int PATH_MISS_SCREEN = 8;   // `unified`: left by a side of the screen.
const int PATH_MISS_NEAR = 9;     // `unified`: went behind the near plane.
const int PATH_MISS_SKY = 10;     // `unified`: went beyond the far plane.
const int PATH_MISS_BEHIND = 11;  // `unified`: left the frustum behind geometry.
const int PATH_SKY = 12;          // With captures: ends in the sky.
const int PATH_UNKNOWN = 13;      // With captures: goes where no image sees it.
const int PATH_LINEAR_EXHAUSTED = 14;  // `dda`: out of steps, and taken for a miss.
const int PATH_TRIANGLE = 15;     // With triangles: hit one of them.
const int PATH_CAPTURE = 16;      // Hit in capture k: this plus k.
const int CAPTURE_SLOTS = 8;      // The most captures that a frame takes.
const float SKY_DISTANCE = 1e5;   // So far away, in metres, the point of a ray that captures let into the sky is put.
const float GETS_ON = 1e-4;       // A ray that a capture loses has got on in it if it went farther than this, in metres.
const int FACE_LEVEL = 4;         // Level of the cell that a walk over a face looks at first, if the pyramid has it.
const float GOLDEN_ANGLE = 2.399963229728653; // 2 pi (1 - 1 / golden ratio): a turn that spreads any number of points.
const int LOST_GROUP = 64;        // Rays that the screen lost to a workgroup that follows them.

const float LEAST_NORMAL = 1.17549435e-38; // The least normal number of 32-bit floats.
const float ROUNDING = 5.9604645e-8; // Half a unit in the last place of 1, in 32-bit floats.
const int TREE_DEPTH = 32;        // The most levels of a tree of triangles: a walk has room for so many.
const uint NO_TRIANGLE = 0xffffffffu; // The number of no triangle.
const uint ASKS_MATERIAL = 0x80000000u; // The bit of a triangle's number whose material decides whether it is there.
const uint MATERIAL_SKY = 1u;     // The bit of a material that shows the sky,
const uint MATERIAL_SINGLE_SIDED = 2u; // and of one that is not there from behind.
const uint MAP_LEVELS = 31u;      // The bits of a map that say how many levels it has,
const uint MAP_SRGB = 32u;        // and the one of a map that is sRGB.
const uint ALBEDO_SHIFT = 2u;     // Where a material's word has these bits of its albedo map,
const uint NORMAL_SHIFT = 8u;     // of its normal map,
const uint MASK_SHIFT = 14u;      // and of its alpha mask.

// How another renderer stores normals (`passes::import`).
const int NORMAL_FLOAT = 0;             // -1 to 1.
const int NORMAL_UNORM = 1;             // 0 to 1 for -1 to 1.
const int NORMAL_OCTAHEDRAL = 2;        // On an octahedron, -1 to 1.
const int NORMAL_OCTAHEDRAL_UNORM = 3;  // On an octahedron, 0 to 1.
const int NORMAL_OF_DEPTH = 4;          // Not at all: from the depth of neighbours.

// Roughness above which `unified` takes a lobe for wide. Up to this, a ray a pixel is traced; above, one for 2 x 2, of
// which more are gathered: a wider lobe needs more rays, and those of farther neighbours fit it.
const float WIDE_ABOVE = 0.2;
// Pixels along a side of a tile that `unified` classifies.
const int TILE_SIDE = 16;
const int MIRROR_LIST = 0;        // The list of tiles with mirrors.
const int NARROW_LIST = 1;        // The list of tiles with narrow lobes.
const int WIDE_LIST = 2;          // The list of tiles with wide lobes.
const int LISTS = 3;              // Lists that the classification writes.
// Threads along a side of a workgroup of compute programs over images. It divides a tile's side and half of it.
const int GROUP_SIDE = 8;
// The binding of the first image that a compute program stores to in place of a fragment program's first output.
const int FIRST_OUTPUT = 24;
// Tiles in a row of workgroups over a list. Every device takes 65535 rows, enough for images of 46000 pixels a side.
const int TILES_TO_A_ROW = 128;
// Pixels along a side of what a workgroup makes of the pyramid of `unified`.
const int PYRAMID_TILE_SIDE = 64;

// The gloss of `unified`.
const float NARROW_PART = 0.5;        // The pattern covers this part of a narrow lobe; footprints reach into the rest.
// Footprints to a narrow lobe, of nine rays: each reaches into its neighbours', for steadiness under a moving camera.
const float NARROW_FOOTPRINTS = 4.5;
const float WIDE_FOOTPRINTS = 25.0;   // Footprints to a wide lobe: one a ray.
// A hit so near, in pixels, of a wide lobe: what a neighbour sees in this direction is more likely as near to itself
// than at this point. (A normal that a map has turned sends rays below the surface, which end in the next pixel.)
const float NEAR_HIT = 8.0;
const float FAR_AWAY = 1e3;           // So many times as far away the point of such a hit is put.
const float FAR_EYE = 1e6;            // Metres: so far away is the eye of an orthographic projection where footprints ask for it.
const float FAR_SKY = 1e6;            // So far away, in units of ViewPoint, the point of a ray that the screen lets into the sky is put.
// What a ray or a cell weighs at least, so that a pixel without a fitting neighbour takes what there is.
const float LEAST_WEIGHT = 1e-4;
const int OWN_GROUP = 64;             // Rays of pixels' own to a workgroup that follows them.
// A pixel gets rays of its own where those of its neighbours say little of its reflection (docs/unified.md):
// with a narrow lobe if the standard error of what these saw, over its mean, is above this,
const float DOUBT_ABOVE = 0.17;
// with a wide lobe if less than this part of the cells around it is of its surface,
const float AGREES_ABOVE = 0.75;
const float AGREED_RAYS = 8.0;        // and such cells stand for so many rays of its own where all are of its surface;
const float CONTACT = 10.0;           // or if a ray around it ended nearer than so many pixels measure there.
const float ENDED_NEAR = 2.0;         // Is added to the fade of a cell's ray that ended nearer on the screen than NEAR_HIT.
const float LOG_DENSITY_BIAS = 64.0;  // Makes the logarithm to base 2 of any lobe's density positive.
const float CELL_REACH = 4.0;         // Pixels along an axis from a cell's ray to where it would weigh nothing.
const float GREATEST_HALF = 65504.0;  // The greatest 16-bit float.

// Weights of the 7-tap Gaussian of thesis 4.3.2 by the distance from its middle.
const float GAUSSIAN_0 = 0.474;   // The middle.
const float GAUSSIAN_1 = 0.233;   // One tap away.
const float GAUSSIAN_2 = 0.028;   // Two taps away.
const float GAUSSIAN_3 = 0.002;   // Three taps away.

const int MAX_LIGHTS = 16;        // The most lights that a scene can have.
const int MOST_MOVERS = 8;         // The most things that move from frame to frame whose reflections a history follows.
const float BEYOND = 10.0;         // Pixels outside of the image to where a history moves what was seen further away.
const int MAX_AREA_LIGHTS = 16;   // The most area lights that `area-light` takes.
const int MAX_IMPOSTORS = 16;     // The most impostors that `billboard` and `ibr` take.

const int CONVERT_LINEAR_DEPTH = 0;    // View-space z in metres; the far plane's where nothing stands.
const int CONVERT_REVERSED_DEPTH = 1;  // Reversed depth, as a colour.
const int CONVERT_MOTION = 2;          // Texture coordinates now less those in the frame before.
const int CONVERT_VIEW_NORMAL = 3;     // -1 to 1; 4: 0 to 1; 5: octahedral; 6: octahedral, 0 to 1.
const int CONVERT_WORLD_NORMAL = 7;    // The four encodings in world space, up to 10.
const int CONVERT_VIEW_PLACE = 11;     // Where the surface stands in view space; w 1, and all 0 where nothing stands.
const int CONVERT_WORLD_PLACE = 12;    // Where the surface stands in world space; w as in view space.

const int ALPHA_FADE = 0;              // What is in a of a user's reflection: its fade.
const int ALPHA_PREMULTIPLIED = 1;     // Its fade, which the colour is multiplied by already.
const int ALPHA_NONE = 2;              // Nothing that is read: it counts as 1.

const int HITS_UV = 0;                 // A user's hits: texture coordinates, below 0 for none.
const int HITS_UV_MASKED = 1;          // Texture coordinates, and a above 0 for a hit.
const int HITS_PIXEL = 2;              // Pixels, below 0 for none.
const int HITS_VIEW = 3;               // Places in view space, and a above 0 for a hit.
const int HITS_UV_DEPTH = 4;           // Texture coordinates, and standard depth, below 0 for none.

const uint NORMAL_MAP = 1u;       // The bit of a material with a normal map.
const uint ALPHA_MASK = 2u;       // The bit of a material with an alpha mask.
const uint ROUGHNESS_MAP = 4u;    // The bit of a material with a roughness map.
const uint SINGLE_SIDED = 8u;     // The bit of a material that is not there from behind.
const float EMISSION = 0.4;       // By how much full emission lowers the albedo buffer's alpha from 1.

const int SHAPE_SPHERE = 0;       // An area light that is a sphere.
const int SHAPE_CAPSULE = 1;      // An area light that is a capsule.
const int SHAPE_RECTANGLE = 2;    // An area light that is a rectangle.
const int SHAPE_CUBOID = 3;       // An area light that is a cuboid.
const int SHAPE_CYLINDER = 4;     // An area light that is a cylinder.

const int ORDER_PRINTED = 0;      // Billboards as listing 2 has it.
const int ORDER_UNBROKEN = 1;     // The last billboard of the list that lies ahead.
const int ORDER_NEAREST = 2;      // The nearest billboard.

const int TRACE_SHADING = 0;      // Rays are reflected at the normals of shading,
const int TRACE_GEOMETRIC = 1;    // at those of the geometry, from depth,
const int TRACE_UP = 2;           // or all at the world's up.

const int BLUR_NONE = 0;          // Billboards are mirrored, as listing 2 has it,
const int BLUR_ROUGHNESS = 1;     // blurred by the cone that the ray becomes on its way from the surface,
const int BLUR_DISTANCE = 2;      // or by one as wide as if it had begun at the viewer.

const int COMPARE_ONE = 0;        // The window shows one picture,
const int COMPARE_SPLIT = 1;      // the first left of a line and the second right of it,
const int COMPARE_DIFFERENCE = 2; // or the difference of two.

const int CONTENT_COLOR = 0;          // Shown as a colour,
const int CONTENT_NORMAL = 1;         // as a normal,
const int CONTENT_REVERSED_DEPTH = 2; // as reversed depth,
const int CONTENT_STANDARD_DEPTH = 3; // as minimum and maximum of standard depth,
const int CONTENT_PLAIN = 4;          // as numbers as they are,
const int CONTENT_HEAT = 5;           // or as a heat map of one number.

#endif
