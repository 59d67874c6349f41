// What tracing and resolving glossy rays share: lobes, the pattern of directions, and, for narrow lobes (NARROW), the
// record of a ray, for wide ones the cells that have one ray each. The latter need the images `pyramid` and
// `material_buffer`. CPU twin: reference::unified::lobe.
//
// Interleaved sampling (Keller and Heidrich 2001): the directions of one stratified pattern over the
// lobe are dealt out to the pixels, a ray each, always the same. A pixel then gathers its neighbours'
// rays as samples of its own lobe. Rays of wide lobes weigh lobe(from here to the hit) / density(that
// was sampled there), a ratio estimator (Stachowiak 2015; Heitz et al. 2018); for narrow lobes it is
// enough how alike the two lobes are. There is nothing random, and nothing of earlier frames unless a history is kept (`--history on`).
//
// The gathered neighbourhood of every pixel holds each direction once: a square of 3 x 3 pixels, or of 5 x 5 cells
// (LatticePoint). So no pixel lacks a part of the lobe, and there are no blocks that could be seen.

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

// The lobe of a pixel, of whose point the direction alone counts.
Lobe MakeLobe(vec3 point, vec3 normal, float roughness) {
    return Lobe(normal, MirrorDirection(ViewDirection(point), normal), LobePower(roughness));
}

// What a ray saw.
struct LobeSample {
    bool is_hit;
    float density; // that it was sampled with: see LogDensity
    vec4 color;    // of the hit, and its fade in a; a miss is 0
};

// The level of the colour's chain for a ray of a density (LogDensity) that stands for a share of the lobe. Its
// footprint is that as a solid angle, share 2 pi / density, taken for a cone of angle theta, pi theta^2; its
// diameter at the hit in pixels is the level's texel.
float FootprintLevel(vec3 point, vec3 there, float density, float share) {
    vec3 away = there - point;
    float pixel = ORTHOGRAPHIC ? unified.pixel_to_view.y : there.z * unified.pixel_to_view.y;
    return max(0.5 * (log2(2.0 * share * dot(away, away) / (pixel * pixel)) - (density - LOG_DENSITY_BIAS)), 0.0);
}

// How much two lobes of a power have in common, around the mirror directions of two unit normals that are a chord
// apart: the integral of their product over that of one's square. Normals that are d apart turn the directions by
// 2 d, and for Gaussian lobes of variance 1 / alpha that is exp(-alpha d^2).
float LobeOverlap(vec3 chord, float power) {
    return exp2(-LOG2_E * power * dot(chord, chord));
}

// The point of the pattern that is a pixel's or a cell's: of side x side points, dealt out so that each square of that
// side holds all; point i of the rank-1 lattice with the generator (1, g), at a place in its stratum. With each frame of a
// history the points are dealt out otherwise, and stand at another place.
vec2 LatticePoint(ivec2 texel, int side, int g, vec2 place) {
    int n = side * side;
    int i = (texel.x + side * texel.y + unified.turn % n) % n;
    return (vec2(i, (i * g) % n) + fract(place + SequencePoint(unified.turn))) / float(n);
}

#ifdef NARROW

// What a ray of a narrow lobe saw, and the lobe that it is of, as neighbours gather them: four words, so that
// one load brings it all.

#define NO_RECORD uvec4(0)

struct RayRecord {
    vec3 mirror; // the lobe's middle, a unit vector
    float root;  // of alpha + 1; negative for a miss; 0 for no ray
    vec4 color;  // of the hit, and its fade in a; a miss is 0
};

uint PackMirror(vec3 mirror) {
    return packSnorm2x16(EncodeOctahedral(mirror));
}

// A record whose mirror is packed.
uvec4 PackRecord(uint mirror, float root, vec4 color) {
    return uvec4(mirror, floatBitsToUint(root), packHalf2x16(color.rg), packHalf2x16(color.ba));
}

RayRecord UnpackRecord(uvec4 words) {
    return RayRecord(DecodeOctahedral(unpackSnorm2x16(words.x)), uintBitsToFloat(words.y),
                     vec4(unpackHalf2x16(words.z), unpackHalf2x16(words.w)));
}

#else

// Wide lobes are traced and resolved for cells of 2 x 2 pixels.

// The pixel that stands for a cell: its first or its last, by turns as on a chequerboard, so that what is a pixel
// wide and straight is met by some of the cells that it runs through.
ivec2 CellPixel(ivec2 cell) {
    return 2 * cell + ((cell.x + cell.y) & 1);
}

// What has a wide lobe in a cell.
struct WideCell {
    ivec2 pixel;     // the one that the cell's ray is of: CellPixel, or another if that has no wide lobe
    float roughness; // its own; 0 if no pixel of the cell has a wide lobe
    bool is_mixed;   // some pixel of the cell has none
};

WideCell FindWideCell(ivec2 cell) {
    WideCell wide = WideCell(CellPixel(cell), 0.0, false);
    ivec2 turned = wide.pixel & 1;
    // Every pixel loads all four. Mesa 25 leaves out a load that no pixel inside the image waits for, though pixels beyond the
    // border, whose normals count in BlockDifferences, do.
    for (int i = 0; i < 4; ++i) {
        ivec2 p = min(2 * cell + (ivec2(i & 1, i >> 1) ^ turned), unified.size - 1);
        vec2 material = imageLoad(material_buffer, p).rg;
        float depth = DepthAt(p);
        bool is_wide = Reflects(material) && TileListOf(material) == WIDE_LIST && depth > 0.0;
        wide.is_mixed = wide.is_mixed || !is_wide;
        if (is_wide && !(wide.roughness > 0.0)) {
            wide.pixel = p;
            wide.roughness = material.g;
        }
    }
    return wide;
}

#endif

#endif
