// Constants that shaders and host share, declared here alone: build.rs translates them to Rust (`math::constants`).
// Each constant stands on a line of its own, `const TYPE NAME = VALUE;`, with a comment above or beside it.

#ifndef COMMON_CONSTANTS_GLSL
#define COMMON_CONSTANTS_GLSL

// A pixel reflects above this reflectivity, if it isn't sky (docs/definitions.md, "Surfaces").
const float REFLECTS_ABOVE = 1e-4;
// Squared length of a normal up to which its pixel shows no surface.
const float NO_NORMAL = 1e-4;
// ξ of Eq. 4.5: the share of the lobe's energy outside the cone.
const float XI = 0.244;
// Exponents of Eq. 4.5 above this count as a mirror's (thesis 4.2.8).
const float MIRROR_ALPHA = 1000.0;
// Least thickness of a pixel's block, as a share of the view depth (docs/definitions.md, "Oracle", item 3).
const float SHARE_OF_DEPTH = 0.004;
// A pixel shows something thin if both neighbours along an axis of the image lie farther away by more than this share
// of the pixel's view depth. The neighbours then say nothing about the span of its depth.
const float THIN = 0.05;
// Version 2 of the oracle: neighbouring pixels show one surface if their fronts, in reversed depth, lie no further
// apart than this share of the two blocks' thicknesses together. (For a plane, half is enough.)
const float JOINED = 0.8;
// Tolerance of depth within which a pixel shows a hit: this share of the hit's z, plus as many metres
// (docs/definitions.md, "World agreement").
const float VISIBLE_WITHIN = 0.02;
// A texel of the screen counts as part of a triangle that a ray meets if the texel's point lies off the triangle's
// plane by less than this, in widths of a texel there. Surfaces may be curved, so that there must be a tolerance. Along
// an edge, only the nearest pixels of the next surface lie within it.
const float SAME_SURFACE = 0.1;
// A pixel around a hit is left out of the hit's colour if it stands before the pixel that was hit by more than this,
// and beside the ray by more than STANDS_BESIDE. The unit of both is the width of a pixel there.
const float STANDS_BEFORE = 10.0;
// Distance from the ray, in widths of a pixel, beyond which a pixel stands beside the ray (STANDS_BEFORE).
const float STANDS_BESIDE = 3.0;
// A pixel around a hit is also left out if it does not stand above the plane of the reflecting surface by this share of
// a pixel's width.
const float STANDS_ABOVE = 0.3;
// Where a length on a surface is divided by the cosine of the angle between a ray and the surface's normal, the cosine
// counts as at least this.
const float LEAST_FACING = 0.05;
// The number that stands for infinity in traversals, as the s at which a ray reaches a side that it never meets.
const float NEVER = 1e30;

// How a ray ended (`passes::PathCode`).
const int PATH_NONE = 0;          // The pixel does not reflect.
const int PATH_HI_Z = 1;          // Hit by Hi-Z traversal.
const int PATH_LINEAR = 2;        // Hit by a linear march: the fallback's, or the method's own.
const int PATH_MISS = 3;          // Hi-Z traversal left the screen.
const int PATH_LINEAR_MISS = 4;   // A linear march found nothing.
const int PATH_EXHAUSTED = 5;     // Out of iterations; the thesis takes it for a hit.
const int PATH_UNTRACED = 6;      // The ray goes towards the camera, and the method does not trace it.
const int PATH_UNFINISHED = 7;    // `unified`: out of steps, which cannot happen, and is never a hit.
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
const float SKY_DISTANCE = 1e5;   // Metres along a ray to the point that stands for the sky.
const float LEAST_ADVANCE_M = 1e-4; // Metres that a ray must go in a capture that loses it to count as moving on.
const int FACE_LEVEL = 4;         // Level of the cell that a walk over a face looks at first, if the pyramid has it.
const float GOLDEN_ANGLE = 2.399963229728653; // 2 pi (1 - 1 / golden ratio): an angle between points that spreads any number of them.
const int LOST_GROUP = 64;        // Number of lost rays that one workgroup follows.

const float LEAST_NORMAL = 1.17549435e-38; // The least normal number of 32-bit floats.
const float ROUNDING = 5.9604645e-8; // Half a unit in the last place of 1, in 32-bit floats.
const int TREE_DEPTH = 32;        // The most levels of a tree of triangles: a walk has room for so many.
const uint NO_TRIANGLE = 0xffffffffu; // The number that stands for no triangle.
const uint ASKS_MATERIAL = 0x80000000u; // The bit in the number of a triangle whose material decides at each hit whether it stops the ray.
const uint MATERIAL_SKY = 1u;     // The bit of a material that shows the sky.
const uint MATERIAL_SINGLE_SIDED = 2u; // The bit of a material that is invisible from behind.
const uint MAP_LEVELS = 31u;      // The bits of a map that give its number of levels.
const uint MAP_SRGB = 32u;        // The bit of a map whose colours are sRGB.
const uint ALBEDO_SHIFT = 2u;     // Shift of the albedo map's MAP_LEVELS and MAP_SRGB in a material's word.
const uint NORMAL_SHIFT = 8u;     // Shift of the normal map's MAP_LEVELS and MAP_SRGB in a material's word.
const uint MASK_SHIFT = 14u;      // Shift of the alpha mask's MAP_LEVELS and MAP_SRGB in a material's word.

// How another renderer stores normals (`passes::import`).
const int NORMAL_FLOAT = 0;             // Normals are stored as numbers from -1 to 1.
const int NORMAL_UNORM = 1;             // Normals are stored as numbers from 0 to 1, which stand for -1 to 1.
const int NORMAL_OCTAHEDRAL = 2;        // Normals are stored on an octahedron, from -1 to 1.
const int NORMAL_OCTAHEDRAL_UNORM = 3;  // Normals are stored on an octahedron, from 0 to 1.
const int NORMAL_OF_DEPTH = 4;          // Normals are not stored: they come from the depth of neighbours.

// Roughness above which `unified` takes a lobe for wide. A narrow lobe gets a ray for each pixel, and a wide one a ray
// for each 2 x 2 pixels. More rays are gathered for a wide lobe, since it needs more, and those of farther neighbours
// fit it.
const float WIDE_ABOVE = 0.2;
// Pixels along a side of a tile that `unified` classifies.
const int TILE_SIDE = 16;
const int MIRROR_LIST = 0;        // The list of tiles with mirrors.
const int NARROW_LIST = 1;        // The list of tiles with narrow lobes.
const int WIDE_LIST = 2;          // The list of tiles with wide lobes.
const int LISTS = 3;              // Number of lists that the classification writes.
// Threads along a side of a workgroup of compute programs over images. It divides a tile's side and half of it.
const int GROUP_SIDE = 8;
// The binding of the first image that a compute program stores to in place of a fragment program's first output.
const int FIRST_OUTPUT = 24;
// Tiles in a row of workgroups over a list. Every device takes 65535 rows, enough for images of 46000 pixels a side.
const int TILES_TO_A_ROW = 128;
// Pixels along a side of the square for which one workgroup makes the pyramid of `unified`.
const int PYRAMID_TILE_SIDE = 64;

// The gloss of `unified`.
const float NARROW_PART = 0.5;        // The pattern covers this part of a narrow lobe; footprints reach into the rest.
// Number of footprints that fill a narrow lobe. The lobe has nine rays, so that footprints overlap, which is steadier
// under a moving camera.
const float NARROW_FOOTPRINTS = 4.5;
const float WIDE_FOOTPRINTS = 25.0;   // Number of footprints that fill a wide lobe: one for each ray.
// A hit of a wide lobe's ray is near if it lies within this many pixels of the ray's own pixel. A neighbour then more
// likely sees something equally near to itself in this direction than this very point. (A normal that a map has turned
// sends rays below the surface, which end in the next pixel.)
const float NEAR_HIT = 8.0;
const float FAR_AWAY = 1e3;           // Factor by which the recorded point of a near hit (NEAR_HIT) is moved away.
const float FAR_EYE = 1e6;            // Distance of the eye of an orthographic projection, in metres, for footprints.
const float FAR_SKY = 1e6;            // Distance of the point that stands for the sky on the screen, in units of ViewPoint.
// Least weight of a ray or a cell, so that a pixel without a fitting neighbour takes the others.
const float LEAST_WEIGHT = 1e-4;
const int OWN_GROUP = 64;             // Number of own rays that one workgroup follows.
// A pixel with a narrow lobe gets own rays if the standard error of what its neighbours' rays saw, over the mean, is
// above this (docs/unified.md).
const float DOUBT_ABOVE = 0.17;
// A pixel with a wide lobe gets own rays if less than this part of the cells around it shows its surface.
const float AGREES_ABOVE = 0.75;
// Number of own rays that the cells around a pixel are worth if all of them show its surface.
const float AGREED_RAYS = 8.0;
// A pixel with a wide lobe also gets own rays if a ray around it ended nearer than this, in widths of a pixel there.
const float CONTACT = 10.0;
// Where a thing stands on a rough surface, only cells that are close to each other see the same. There the 3 x 3 cells
// around a cell count more (docs/unified.md). The additional weight is this number times (1 - roughness)^2 for the cell
// itself, a half of that for the cells beside it, and a quarter at its corners.
const float CONTACT_WEIGHT = 12.0;
// CONTACT_WEIGHT falls to 0 as the distance to the nearest hit grows from NEAR_HIT to this, in widths of a pixel.
const float CONTACT_END = 20.0;
// Added to the density of a cell's ray that ended nearer on the screen than NEAR_HIT, on another surface. No density is as great.
const float NEAR_MARK = 256.0;
const float LOG_DENSITY_BIAS = 64.0;  // Makes the logarithm to base 2 of any lobe's density positive.
const float CELL_REACH = 4.0;         // Pixels along an axis from a cell's ray to where the cell's weight is 0.
const float GREATEST_HALF = 65504.0;  // The greatest 16-bit float.

// Weights of the 7-tap Gaussian of thesis 4.3.2 by the distance from its middle.
const float GAUSSIAN_0 = 0.474;   // Weight of the middle tap.
const float GAUSSIAN_1 = 0.233;   // Weight of a tap beside the middle.
const float GAUSSIAN_2 = 0.028;   // Weight two taps from the middle.
const float GAUSSIAN_3 = 0.002;   // Weight three taps from the middle.

const int MAX_LIGHTS = 16;        // The most lights that a scene can have.
const int MOST_MOVERS = 8;         // The most moving things whose reflections a history follows.
const float BEYOND = 10.0;         // A history clamps positions to this distance outside of the image, in pixels.
const int MAX_AREA_LIGHTS = 16;   // The most area lights that `area-light` takes.
const int MAX_IMPOSTORS = 16;     // The most impostors that `billboard` and `ibr` take.

const int CONVERT_LINEAR_DEPTH = 0;    // View-space z in metres; the far plane's where nothing stands.
const int CONVERT_REVERSED_DEPTH = 1;  // Reversed depth, as a colour.
const int CONVERT_MOTION = 2;          // Texture coordinates now less those in the frame before.
const int CONVERT_VIEW_NORMAL = 3;     // View-space normal, -1 to 1. The next numbers: 4: 0 to 1; 5: octahedral; 6: octahedral, 0 to 1.
const int CONVERT_WORLD_NORMAL = 7;    // World-space normal, in the same four encodings up to 10.
const int CONVERT_VIEW_PLACE = 11;     // Position of the surface in view space, with w 1; all 0 where nothing stands.
const int CONVERT_WORLD_PLACE = 12;    // Position of the surface in world space, with w as in view space.

const int ALPHA_FADE = 0;              // The alpha of a user's reflection is its fade.
const int ALPHA_PREMULTIPLIED = 1;     // The alpha of a user's reflection is its fade, and the colour is multiplied by it already.
const int ALPHA_NONE = 2;              // The alpha of a user's reflection is not read and counts as 1.

const int HITS_UV = 0;                 // A user's hits are texture coordinates, below 0 for a miss.
const int HITS_UV_MASKED = 1;          // A user's hits are texture coordinates, with alpha above 0 for a hit.
const int HITS_PIXEL = 2;              // A user's hits are pixel coordinates, below 0 for a miss.
const int HITS_VIEW = 3;               // A user's hits are positions in view space, with alpha above 0 for a hit.
const int HITS_UV_DEPTH = 4;           // A user's hits are texture coordinates and standard depth, which is below 0 for a miss.

const uint NORMAL_MAP = 1u;       // The bit of a material with a normal map.
const uint ALPHA_MASK = 2u;       // The bit of a material with an alpha mask.
const uint ROUGHNESS_MAP = 4u;    // The bit of a material with a roughness map.
const uint SINGLE_SIDED = 8u;     // The bit of a material that is invisible from behind.
const float EMISSION = 0.4;       // By how much full emission lowers the albedo buffer's alpha from 1.

const int SHAPE_SPHERE = 0;       // An area light that is a sphere.
const int SHAPE_CAPSULE = 1;      // An area light that is a capsule.
const int SHAPE_RECTANGLE = 2;    // An area light that is a rectangle.
const int SHAPE_CUBOID = 3;       // An area light that is a cuboid.
const int SHAPE_CYLINDER = 4;     // An area light that is a cylinder.

const int ORDER_PRINTED = 0;      // Chooses the billboard as listing 2 does.
const int ORDER_UNBROKEN = 1;     // Chooses the last billboard of the list that lies ahead.
const int ORDER_NEAREST = 2;      // Chooses the nearest billboard.

const int TRACE_SHADING = 0;      // Rays are reflected at the shading normals.
const int TRACE_GEOMETRIC = 1;    // Rays are reflected at the geometry's normals, from depth.
const int TRACE_UP = 2;           // All rays are reflected at the world's up direction.

const int BLUR_NONE = 0;          // Billboards are mirrored sharply, as in listing 2.
const int BLUR_ROUGHNESS = 1;     // Billboards are blurred by the cone that the ray becomes on its way from the surface.
const int BLUR_DISTANCE = 2;      // Billboards are blurred by a cone as wide as if it had begun at the viewer.

const int COMPARE_ONE = 0;        // The window shows one picture.
const int COMPARE_SPLIT = 1;      // The window shows the first picture left of a line and the second right of it.
const int COMPARE_DIFFERENCE = 2; // The window shows the difference of two pictures.

const int CONTENT_COLOR = 0;          // An image is shown as a colour.
const int CONTENT_NORMAL = 1;         // An image is shown as a normal.
const int CONTENT_REVERSED_DEPTH = 2; // An image is shown as reversed depth.
const int CONTENT_STANDARD_DEPTH = 3; // An image is shown as minimum and maximum of standard depth.
const int CONTENT_PLAIN = 4;          // An image is shown as plain numbers.
const int CONTENT_HEAT = 5;           // An image is shown as a heat map of one number.

#endif
