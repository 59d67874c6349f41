// Shared by the passes that trace glossy rays and those that resolve them: lobes, the pattern of directions, and the
// record of a narrow lobe's ray (NARROW). Without NARROW, the cells of wide lobes, which have one ray each; they need
// the images `pyramid` and `material_buffer`. CPU twin: reference::unified::lobe.
//
// Interleaved sampling (Keller and Heidrich 2001): the directions of one stratified pattern over the lobe are dealt out
// to the pixels, one ray each, the same in every frame. A pixel then gathers its neighbours' rays as samples of its own
// lobe. A ray of a wide lobe is weighted by the gathering lobe in the direction of the hit over the density with which
// the ray was drawn, a ratio estimator (Stachowiak 2015; Heitz et al. 2018). A ray of a narrow lobe is weighted by the
// overlap of the two lobes, which is enough. Nothing is random, and nothing comes from earlier frames unless a history
// is kept (`--history on`).
//
// The square of 3 x 3 pixels, or of 5 x 5 cells, that a pixel gathers has each direction of the pattern once
// (LatticePoint). So no pixel lacks a part of the lobe, and no blocks become visible.

#ifndef UNIFIED_GLOSS_GLSL
#define UNIFIED_GLOSS_GLSL

#include "common/lobe.glsl"
#include "common/sequence.glsl"
#include "unified/view.glsl"
#ifdef NARROW
#include "common/octahedral.glsl"
#else
#include "unified/depth.glsl"
#endif

struct Lobe {
    vec3 normal;
    vec3 mirror; // unit vector
    float power; // alpha + 1
};

// Makes the lobe of a pixel, whose view-space point is `point` in any scale.
Lobe MakeLobe(vec3 point, vec3 normal, float roughness) {
    return Lobe(normal, MirrorDirection(ViewDirection(point), normal), LobePower(roughness));
}

// What a ray saw.
struct LobeSample {
    bool is_hit;
    float density; // density that the ray was drawn with: see LogDensity
    vec4 color;    // of the hit, and its fade in alpha; a miss is 0
};

// The level of the colour chain for a ray from `point` to `end`, which was drawn with a density (LogDensity) and
// stands for a share of the lobe. The ray's footprint is the solid angle share 2 pi / density, taken for a cone of
// angle theta, pi theta^2. A texel of the level is as wide as the cone at the hit.
float FootprintLevel(vec3 point, vec3 end, float density, float share) {
    vec3 to_end = end - point;
    float half_pixel = ORTHOGRAPHIC ? unified.pixel_to_view.y : end.z * unified.pixel_to_view.y;
    return max(0.5 * (log2(2.0 * share * dot(to_end, to_end) / (half_pixel * half_pixel))
                      - (density - LOG_DENSITY_BIAS)), 0.0);
}

// The overlap (0 to 1) of two lobes of one power, around the mirror directions of two unit normals whose difference is
// `chord`. It is the integral of the lobes' product over the integral of one lobe's square. Normals that differ by d
// turn the directions by 2 d. For Gaussian lobes of variance 1 / alpha the overlap is exp(-alpha d^2).
float LobeOverlap(vec3 chord, float power) {
    return exp2(-LOG2_E * power * dot(chord, chord));
}

// The point of the pattern, in the unit square, for a pixel or a cell. The pattern has side x side points, dealt out so
// that each square of that side has all of them. The point is point i of the rank-1 lattice with the generator (1, g),
// at `place` (0 to 1) in its stratum. Each frame of a history deals the points out in another way, and moves them in
// their strata.
vec2 LatticePoint(ivec2 texel, int side, int generator, vec2 place) {
    int count = side * side;
    int index = (texel.x + side * texel.y + unified.turn % count) % count;
    return (vec2(index, (index * generator) % count) + fract(place + SequencePoint(unified.turn))) / float(count);
}

#ifdef NARROW

// The record of a narrow lobe's ray, for neighbours to gather: what the ray saw, and the lobe that it belongs to. It
// has four words, so that one load brings all of it.

#define NO_RECORD uvec4(0)

struct RayRecord {
    vec3 mirror; // the lobe's middle, a unit vector
    float root;  // of alpha + 1; negative for a miss; 0 for no ray
    vec4 color;  // of the hit, and its fade in alpha; a miss is 0
};

uint PackMirror(vec3 mirror) {
    return packSnorm2x16(EncodeOctahedral(mirror));
}

// Packs a record, whose mirror direction is packed already.
uvec4 PackRecord(uint mirror, float root, vec4 color) {
    return uvec4(mirror, floatBitsToUint(root), packHalf2x16(color.rg), packHalf2x16(color.ba));
}

RayRecord UnpackRecord(uvec4 words) {
    return RayRecord(DecodeOctahedral(unpackSnorm2x16(words.x)), uintBitsToFloat(words.y),
                     vec4(unpackHalf2x16(words.z), unpackHalf2x16(words.w)));
}

#else

// Wide lobes are traced and resolved for cells of 2 x 2 pixels.

// The pixel that stands for a cell: its first or its last, in turn as on a chequerboard. So some of the cells through
// which a line one pixel wide runs are represented by a pixel of that line.
ivec2 CellPixel(ivec2 cell) {
    return 2 * cell + ((cell.x + cell.y) & 1);
}

// The part of a cell that has a wide lobe.
struct WideCell {
    ivec2 pixel;     // the pixel that the cell's ray begins on: CellPixel, or another if CellPixel has no wide lobe
    float roughness; // that pixel's roughness; 0 if no pixel of the cell has a wide lobe
    bool is_mixed;   // some pixel of the cell has no wide lobe
};

// Finds the pixel of a cell on which its ray begins, and whether other pixels of the cell have no wide lobe.
WideCell FindWideCell(ivec2 cell) {
    WideCell wide_cell = WideCell(CellPixel(cell), 0.0, false);
    ivec2 first_bits = wide_cell.pixel & 1;
    // All four pixels of a cell are always loaded. Mesa 25 leaves out a load whose result no pixel inside the image
    // needs, even if pixels beyond the border need it, whose normals count in BlockDifferences.
    for (int i = 0; i < 4; ++i) {
        ivec2 pixel = min(2 * cell + (ivec2(i & 1, i >> 1) ^ first_bits), unified.size - 1);
        vec2 material = imageLoad(material_buffer, pixel).rg;
        float depth = DepthAt(pixel);
        bool is_wide = Reflects(material) && TileListOf(material) == WIDE_LIST && depth > 0.0;
        wide_cell.is_mixed = wide_cell.is_mixed || !is_wide;
        if (is_wide && !(wide_cell.roughness > 0.0)) {
            wide_cell.pixel = pixel;
            wide_cell.roughness = material.g;
        }
    }
    return wide_cell;
}

#endif

#endif
