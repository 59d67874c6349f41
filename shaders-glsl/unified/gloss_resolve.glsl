// From the rays of gloss_trace.glsl to the image: the reflection of each pixel with a narrow lobe, from the rays around
// it (NARROW); the reflection of each cell with a wide lobe, from the rays of the cells around it (CELLS); and that of
// each pixel with a wide lobe, between the cells around it. Fragment programs (gloss_resolve.frag) and compute programs
// (gloss_resolve.comp) include it. Before that they declare WHOLE: whether they run over the whole image. After it they
// define how rays come to the pixel or cell that gathers them: Around, Row and RowAcross. CPU twins:
// reference::unified::gather and resolve.
//
// Over tiles, a pixel that is not of the list is left as it is: the images already hold what it shows. With WHOLE they
// hold nothing, all that reflects is of the list, and the other pixels show their lit colour.

#ifndef UNIFIED_GLOSS_RESOLVE_GLSL
#define UNIFIED_GLOSS_RESOLVE_GLSL

#include "unified/parameters.glsl"

layout(constant_id = 2) const bool OVER = false;  // another reflection shows where this one misses
#ifndef CELLS
layout(constant_id = 6) const bool COMPOSITE = true; // without it the reflection is all that is shown
#endif

layout(binding = 3, rg16f) uniform readonly image2D material_buffer; // reflectivity, roughness
#ifndef NARROW
layout(binding = 1, rg32f) uniform readonly image2D pyramid;         // front and back depths
layout(binding = 2, rgba16f) uniform readonly image2D normal_buffer; // view space
#endif
#ifndef CELLS
layout(binding = 4) uniform sampler2D color_buffer; // lit colour, linear

struct Shown {
    vec4 color;      // the composite, or the reflection
    vec4 reflection; // colour, and fade in a
};
#endif

#ifdef CELLS
#include "triangles/own_rays.glsl"
#else
#include "triangles/push_doubt.glsl"
#endif
#define GATHERS
#include "unified/gloss.glsl"

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
ivec2 Outward(ivec2 at) {
    return 2 * (at & 1) - 1;
}

#if defined(NARROW) || defined(CELLS)

// What the pixels of a block of 2 x 2 hand each other. A device shades the pixels of a fragment program together, in
// step, so that v +- dFdx(v) is what v is in the pixel beside: an exchange costs a subtraction and an addition, and what
// the four have all loaded for themselves is loaded once. The result is good to the last bits of the greater of the two
// values. The threads of a compute program share memory instead, and round their values in the same way.

// A ray as it is gathered. All is 0 for no ray.
struct Gathered {
    vec4 key;   // what its weight goes by; 0 in w for no ray, negative for a miss
    vec4 color; // of the hit, and its fade in a
};

// A pixel's or a cell's reflection is a weighted mean of rays.
struct Sum {
    vec4 color;    // and fade
    float weight;  // of all rays
    float hits;    // of those that hit
    float squares; // of the weights of all rays
};

void Add(inout Sum sum, float weight, bool hit, vec4 color) {
    float hits = hit ? weight : 0.0;
    sum.weight += weight;
    sum.color += hits * color;
    sum.hits += hits;
    sum.squares += weight * weight;
}

// Reflection colour, and its fade in a. What rays missed is black. Over another reflection it is not: what the
// rays hit has its own colour, and fades by how many miss. The product is the same, by the fade that 16 bits hold.
vec4 Reflection(Sum sum) {
    if (!(sum.hits > 0.0))
        return vec4(0.0);
    vec4 reflection = vec4(sum.color.rgb / sum.weight, sum.color.a / sum.hits);
    if (OVER) {
        float fade = unpackHalf2x16(packHalf2x16(vec2(sum.color.a / sum.weight, 0.0))).x;
        reflection = fade > 0.0 ? vec4(reflection.rgb * (reflection.a / fade), fade) : vec4(0.0);
    }
    return reflection;
}

#endif

#ifdef NARROW

// A pixel gathers the rays of the 3 x 3 pixels around it. Of these, four are in its block of 2 x 2 pixels, and four
// beside that block, two of which a pixel of the block has beside it as well; the ninth is at its corner. The pixels of
// the block hand each other what they loaded, and load four rays instead of nine.
//
// A neighbour's ray weighs as much as its lobe has in common with this one.

layout(binding = 5, rgba32ui) uniform readonly uimage2D seen_image; // TraceNarrow

// By the lobe that the ray is of.
Gathered Unpacked(uvec4 words) {
    Record r = Unpack(words);
    return Gathered(vec4(r.mirror, r.root), r.color);
}

// One outside the block. Where no tile is drawn the image holds anything; a pixel with a narrow lobe is in one.
Gathered Load(ivec2 pixel) {
    ivec2 at = clamp(pixel, ivec2(0), unified.size - 1);
    uvec4 words = imageLoad(seen_image, at);
    if (!WHOLE) {
        vec2 material = imageLoad(material_buffer, at).rg;
        words = Reflects(material) && ListOf(material) == NARROW_LIST ? words : NO_RECORD;
    }
    return Unpacked(words);
}

void Gather(inout Sum sum, Gathered own, Gathered r) {
    // The root of Overlap, for a power between the two, by mirrors instead of normals, which turn half as far. Of the
    // two it is the steadier one under a moving camera.
    float power = abs(own.key.w * r.key.w);
    vec3 chord = own.key.xyz - r.key.xyz;
    float same = exp2(-0.125 * LOG2_E * power * dot(chord, chord));
    float weight = r.key.w != 0.0 ? max(same, LEAST_WEIGHT) : 0.0;
    // What was handed on may be a last bit below 0.
    Add(sum, weight, r.key.w > 0.0, max(r.color, 0.0));
}

// The rays around a pixel: its own, the three of its block (beside it, above or below, and across the corner), the two
// beside the block, the two above or below it, and the one at its corner. The file that includes this one defines it.
Gathered[9] Around(ivec2 pixel);

// Whether the rays around a pixel are too few for how much their colours differ. They stand for so many rays of the pixel's own,
// by how much their weights differ (the effective size of a weighted sample; Kish 1965).
bool IsDoubtful(Gathered rays[9], Sum sum, out float stand_for) {
    vec3 total = vec3(0.0), squares = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 9; ++i) {
        float counts = rays[i].key.w != 0.0 ? 1.0 : 0.0;
        vec3 color = counts * rays[i].color.rgb;
        total += color;
        squares += color * color;
        count += counts;
    }
    vec3 mean = total / count, variance = squares / count - mean * mean;
    stand_for = sum.weight * sum.weight / sum.squares;
    return dot(variance, vec3(1.0)) > stand_for * DOUBT_ABOVE * DOUBT_ABOVE * dot(mean, mean);
}

// False for a pixel that is left as it is.
bool Show(ivec2 pixel, out Shown shown) {
    Gathered rays[9] = Around(pixel);
    Gathered own = rays[0];
    Sum sum = Sum(vec4(0.0), 0.0, 0.0, 0.0);
    Add(sum, 1.0, own.key.w > 0.0, own.color);
    Gather(sum, own, rays[1]);
    Gather(sum, own, rays[2]);
    Gather(sum, own, rays[3]);
    Gather(sum, own, rays[4]);
    Gather(sum, own, rays[5]);
    Gather(sum, own, rays[6]);
    Gather(sum, own, rays[7]);
    Gather(sum, own, rays[8]);
    bool shows = own.key.w != 0.0;
    if (!WHOLE && !shows)
        return false;
    vec4 reflection = vec4(0.0);
    vec4 color = texelFetch(color_buffer, pixel, 0);
    if (shows) {
        reflection = Reflection(sum);
        reflection = vec4(Sound(reflection.rgb), min(Sound(reflection.a), 1.0));
        float stand_for;
        if (OWN_RAYS > 0 && IsDoubtful(rays, sum, stand_for))
            PushDoubt(Doubt(pixel, reflection.rgb, stand_for));
        float reflectivity = imageLoad(material_buffer, pixel).r;
        color.rgb = min(color.rgb + reflectivity * reflection.a * reflection.rgb, GREATEST_HALF);
    }
    shown = Shown(COMPOSITE ? color : reflection, reflection);
    return true;
}

#else

// Which cells have been drawn: those of tiles on the list of wide lobes. Elsewhere their images hold anything. With
// WHOLE every cell has been.

layout(binding = 8, r32ui) uniform readonly uimage2D listed_image; // for each tile, a bit for each list it stands on

#define CELLS_TO_A_TILE (TILE_SIDE / 2) // along a side

// The tile of a cell with a wide lobe, which is drawn, and whether those beside it are.
struct Around {
    ivec2 home;
    bool across, along, corner;
} around;

bool IsListed(ivec2 tile) {
    ivec2 at = clamp(tile, ivec2(0), TileCount() - 1);
    return (imageLoad(listed_image, at).r >> WIDE_LIST & 1u) != 0u;
}

// Before IsDrawn: around a cell, the tiles to a side, 1 or -1 along each axis.
void LookAround(ivec2 cell, ivec2 side) {
    if (WHOLE)
        return;
    ivec2 home = cell / CELLS_TO_A_TILE;
    around = Around(home, IsListed(home + ivec2(side.x, 0)), IsListed(home + ivec2(0, side.y)), IsListed(home + side));
}

// A cell of the home tile or of one to that side.
bool IsDrawn(ivec2 cell) {
    if (WHOLE)
        return true;
    bvec2 beside = notEqual(cell / CELLS_TO_A_TILE, around.home);
    return beside.x ? (beside.y ? around.corner : around.across) : !beside.y || around.along;
}

#ifdef CELLS

layout(binding = 5, rgba32f) uniform readonly image2D place_image; // TraceWide
layout(binding = 6, rgba16f) uniform readonly image2D seen_image;

struct Cell {
    vec4 reflection;
    vec4 surface; // normal, and ViewPoint.z as far as 16 bits go, 1 if rays of sight are parallel; 0: none. Negative in a cell
                  // that is mixed, where pixels may get rays of their own.
};

// The cell itself, or the nearest one that the image has.
ivec2 Nearest(ivec2 cell) {
    return clamp(cell, ivec2(0), (unified.size - 1) >> 1);
}

// What the ray of a cell of the image saw, by its place and density (TraceWide). Of a cell that has not been drawn the
// images hold anything.
Gathered Load(ivec2 at, bool is_drawn) {
    return Gathered(is_drawn ? imageLoad(place_image, at) : vec4(0.0),
                    is_drawn ? imageLoad(seen_image, at) : vec4(0.0));
}

struct Here {
    vec3 point;
    Lobe lobe;
    float peak; // LogDensity in the middle of the lobe
};

// Adds a ray by what is seen of it from here. Its weight is lobe / density, bounded:
// 2 f / (f + q) is f / q where they agree, and never above 2, however little a neighbour expected what matters
// here (the balance heuristic between the two pixels; Veach and Guibas 1995). Densities of different roughness
// compare as they stand. The weight alone keeps foreign surfaces apart.
void Gather(inout Sum sum, Here here, Gathered ray) {
    float density = ray.key.w;
    vec3 to = density > 0.0 ? ray.key.xyz - here.point : ray.key.xyz;
    // For wide lobes the cosine of an angle tells it well enough.
    float log_cos = LogCos(1.0 - dot(to, here.lobe.mirror) * inversesqrt(dot(to, to)));
    float weight = 2.0 / (1.0 + exp2(abs(density) - here.peak - LOG2_E * (here.lobe.power - 1.0) * log_cos));
    weight = density != 0.0 ? max(weight, LEAST_WEIGHT) : 0.0;
    // What was handed on may be a last bit below 0.
    Add(sum, weight, density > 0.0 && dot(to, here.lobe.normal) > 0.0, max(ray.color, 0.0));
}

// The five rays of a row around a cell, from the inside of its block outwards. `y` is -1, 0 or 1: the row two cells
// inwards, the cell's own, or the row two cells outwards. The file that includes this one defines it and RowAcross.
Gathered[5] Row(ivec2 cell, ivec2 outward, int y);

// The five rays of a row between those: the row that the other cell of the block along y has as its Row for this `y`.
// `row` is what Row gives for this cell and `y`.
Gathered[5] RowAcross(Gathered row[5], ivec2 cell, ivec2 outward, int y);

void Gather(inout Sum sum, Here here, Gathered row[5]) {
    Gather(sum, here, row[0]);
    Gather(sum, here, row[1]);
    Gather(sum, here, row[2]);
    Gather(sum, here, row[3]);
    Gather(sum, here, row[4]);
}

// A cell's square of 5 x 5 is of four kinds, as those of a block of 2 x 2 cells are: 3 x 3 lie two cells apart from
// itself, and those are loaded. The others are such cells of the three that a device shades in step with it.
Cell CellOf(ivec2 cell) {
    WideCell wide = FindWide(cell);
    ivec2 pixel = wide.pixel;
    float depth = DepthAt(pixel);
    vec3 normal = imageLoad(normal_buffer, pixel).xyz;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = LobeOf(point, normal, wide.roughness);
    Here here = Here(point, lobe, LogDensity(lobe.power, 0.0));
    ivec2 outward = Outward(cell);
    Gathered inner[5] = Row(cell, outward, -1), middle[5] = Row(cell, outward, 0);
    Sum sum = Sum(vec4(0.0), 0.0, 0.0, 0.0);
    Gather(sum, here, inner);
    Gather(sum, here, RowAcross(middle, cell, outward, 0));
    Gather(sum, here, middle);
    Gather(sum, here, RowAcross(inner, cell, outward, -1));
    Gather(sum, here, Row(cell, outward, 1));
    bool shows = wide.roughness > 0.0;
    float z = ORTHOGRAPHIC ? 1.0 : min(point.z, GREATEST_HALF);
    z = OWN_RAYS > 0 && wide.is_mixed ? -z : z;
    return Cell(shows ? Reflection(sum) : vec4(0.0), shows ? vec4(normal, z) : vec4(0.0));
}

#else

layout(binding = 5, rgba16f) uniform readonly image2D cell_reflection; // Cells
layout(binding = 6, rgba16f) uniform readonly image2D cell_surface;

// Off its plane by this share of its depth, a cell has lost most of its weight.
#define PLANE_TOLERANCE VISIBLE_WITHIN

// How far the pixel that stands for a cell lies off the plane of a pixel, in tolerances, if rays of sight are parallel:
// `beside` is by how much its distance across the view says so, and `facing` is the cosine at which the plane is seen. Its
// depth is read again: 16 bits tell z less well than the height of the image, of which the tolerance is a share.
float OffPlane(ivec2 cell, float depth, float beside, float facing) {
    float there = DepthAt(min(CellPixel(cell), unified.size - 1));
    return (beside + facing * (depth - there) / unified.depth_offset) / unified.reach;
}

// A wide lobe, between the four cells around the pixel, by how near their rays begin, and as far as each lies in the
// pixel's plane and its lobe is the pixel's (joint bilateral upsampling; Kopf et al. 2007).
// `agreement` is the part of these cells that is of the pixel's surface. It is 0 in a mixed cell, at the edge of what reflects:
// the neighbours' rays come from farther away from what the pixel touches there.
vec4 Wide(ivec2 pixel, float depth, vec3 normal, float power, out float agreement) {
    ivec2 last = (unified.size - 1) >> 1;
    ivec2 cell = pixel >> 1;
    ivec2 outward = Outward(pixel);
    LookAround(cell, outward);
    // Seen `away` pixels from here, a point at view depth z' lies off the pixel's plane by a share of the tolerance
    // that is (facing + dot(turn, away)) z' / z - facing.
    float facing = dot(normal, ViewRay(vec2(pixel) + 0.5)) / PLANE_TOLERANCE;
    vec2 turn = normal.xy * unified.pixel_to_view * vec2(2.0, -2.0) / PLANE_TOLERANCE;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    float agreed = 0.0, all = 0.0;
    bool is_mixed = false;
    for (int i = 0; i < 4; ++i) {
        ivec2 at = clamp(cell + outward * ivec2(i & 1, i >> 1), ivec2(0), last);
        bool is_drawn = IsDrawn(at);
        vec4 surface = is_drawn ? imageLoad(cell_surface, at) : vec4(0.0);
        is_mixed = is_mixed || (i == 0 && surface.w < 0.0);
        surface.w = abs(surface.w);
        vec2 away = vec2(CellPixel(at) - pixel);
        vec2 near = CELL_REACH - abs(away);
        float off = ORTHOGRAPHIC
            ? OffPlane(at, depth, dot(turn, away), facing)
            : (facing + dot(turn, away)) * (surface.w * (depth + unified.depth_offset)) - facing;
        float same = Overlap(normal - surface.xyz, power);
        float squared = off * off;
        float fits = surface.w > 0.0 ? same / (1.0 + squared * squared) : 0.0;
        float weight = surface.w > 0.0 ? near.x * near.y * max(fits, LEAST_WEIGHT) : 0.0;
        agreed += near.x * near.y * fits;
        all += near.x * near.y;
        vec4 reflection = is_drawn ? imageLoad(cell_reflection, at) : vec4(0.0);
        // Over another reflection, a cell shows its colour only as far as it is there.
        reflection.rgb *= OVER ? reflection.a : 1.0;
        sum += weight * reflection;
        weights += weight;
    }
    agreement = is_mixed ? 0.0 : agreed / all;
    float colors = OVER ? sum.a : weights;
    return colors > 0.0 ? vec4(sum.rgb / colors, sum.a / weights) : vec4(0.0);
}

// False for a pixel that is left as it is.
bool Show(ivec2 pixel, out Shown shown) {
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = DepthAt(pixel);
    bool reflects = Reflects(material) && depth > 0.0;
    if (!WHOLE && (!reflects || ListOf(material) != WIDE_LIST))
        return false;
    vec4 reflection = vec4(0.0);
    vec4 color = texelFetch(color_buffer, pixel, 0);
    if (reflects) {
        vec3 normal = imageLoad(normal_buffer, pixel).xyz;
        float agreement;
        reflection = Wide(pixel, depth, normal, LobePower(material.g), agreement);
        reflection = vec4(Sound(reflection.rgb), min(Sound(reflection.a), 1.0));
        if (OWN_RAYS > 0 && agreement < AGREES_ABOVE)
            PushDoubt(Doubt(pixel, reflection.rgb, AGREED_RAYS * agreement));
        color.rgb = min(color.rgb + material.r * reflection.a * reflection.rgb, GREATEST_HALF);
    }
    shown = Shown(COMPOSITE ? color : reflection, reflection);
    return true;
}

#endif

#endif

#endif
