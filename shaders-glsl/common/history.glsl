// Temporal filtering (thesis 4.2.11): the reflection of earlier frames, taken from where the reflected point was seen then, and
// averaged with that of this frame, over as many frames as what is reflected agrees (docs/definitions.md, "Histories").
//
// What a pixel reflects is known: its rays ended somewhere, on something that may move. The frame before shows the same point
// where its reflection was then, at another place of the surface. A pixel whose own reflection stays as it is, to the bit,
// keeps its history as it is. A mirror has no history: its one ray says all.

#ifndef COMMON_HISTORY_GLSL
#define COMMON_HISTORY_GLSL

#extension GL_EXT_control_flow_attributes : require

#include "common/constants.glsl"
#include "common/history_motion.glsl"
#include "common/history_search.glsl"
#include "common/lobe.glsl"
#include "common/sight.glsl"

// What a pixel of the frame is.
struct Averaged {
    vec4 reflection; // colour, and fade in a
    uvec4 guide;     // Guide, packed
    vec4 color;      // lit colour + reflectivity * fade * reflection, where it is wanted
};

// The history may lie so many times as far from what the pixels around show where what is reflected is known to agree,
// and where nothing moves.
#define AGREED 4.0
#define AT_REST 8.0

// What a pixel adds to two sums over its block of 2 x 2, or these sums.
struct Sums {
    vec4 first;
    vec4 second;
};

// The sums over the pixels of a block. The stage has it; every pixel of a block asks for it.
Sums OverBlock(ivec2 pixel, Sums own);

// Keeps what a pixel needs at the end, while the search for its history needs the registers. The stage has both.
void SetAside(Sums values);
Sums TakenBack();

// From a block's pixel to the outside of the block, along each axis: 1 or -1.
vec2 OutwardOf(ivec2 pixel) {
    return vec2(2 * (pixel & 1) - 1);
}

// What the rays around a pixel met.
struct Ends {
    float away; // from the surface, metres; 0 if nothing is known
    int mover;  // that most of them met; -1 for what stands still
};

// What the ray of a pixel met, for the sums over its block; `eye` is how far the pixel's point is from the eye, negative if it does
// not reflect. First come inverse distances, by which images move, and how many: to what stands still, and to what moves. Second are
// the numbers of the movers, how many, and how many pixels reflect.
Sums HitsOf(ivec2 pixel, bool is_wide, float eye) {
    // The ray of a wide lobe is its cell's, so that the pixels of a block ask four cells.
    ivec2 asked = is_wide ? (pixel & ~1) + 2 * (pixel & 1) : pixel;
    uvec2 told = imageLoad(ends_image, min(asked, history.size - 1)).xy;
    float away = eye >= 0.0 && history.has_ends != 0 ? uintBitsToFloat(told.x) * history.unit : 0.0;
    int mover = MoverOf(told.y);
    vec2 one = away > 0.0 ? vec2(1.0 / (eye + away), 1.0) : vec2(0.0);
    vec4 hits = mover < 0 ? vec4(one, 0.0, 0.0) : vec4(0.0, 0.0, one);
    return Sums(hits, vec4(mover < 0 ? vec2(0.0) : vec2(float(mover), 1.0), eye >= 0.0 ? 1.0 : 0.0, 0.0));
}

Ends EndsAround(Sums hits, float eye) {
    bool moves = hits.first.w > hits.first.y;
    vec2 counted = moves ? hits.first.zw : hits.first.xy;
    int mover = moves ? int(hits.second.x / max(hits.second.y, 1.0) + 0.5) : -1;
    return Ends(counted.y > 0.5 ? counted.y / counted.x - eye : 0.0, mover);
}

// Frames that may be averaged, with this one, which does not lag, so that a measure of the lag is at most `most`.
float FramesWithin(float lag, float most) {
    return lag > most ? min(lag / (lag - most), history.most) : history.most;
}

// The history of what a pixel shows and reflects in this frame's view space. `known`: the reflected point is, and `mover` the
// thing that it is on.
Found Search(ivec2 pixel, Sought sought, bool known, int mover) {
    vec3 end = sought.end;
    int own = MoverOf(TriangleAt(pixel));
    sought.surface = Before(sought.surface, 1.0, own);
    if (MOTION && own < 0)
        sought.surface = Moved(vec2(pixel) + 0.5, pixel, sought.surface);
    sought.normal = Before(sought.normal, 0.0, own);
    sought.end = Before(end, 1.0, mover);
    if (MOTION && known && mover < 0)
        sought.end = MovedEnd(end, sought.end);
    float eye = ORTHOGRAPHIC ? 0.0 : length(sought.surface);
    sought.inverse = known ? 1.0 / (eye + distance(sought.surface, sought.end)) : 0.0;
    // On the surface itself, where nothing is known of what it reflects, or the mirror agrees less.
    vec2 place = Position(sought.surface);
    if (known) {
        vec2 in_mirror = InMirror(place, InPlane(sought.surface, sought.normal, sought), sought);
        place = AgreesAt(in_mirror, sought) >= AgreesAt(place, sought) ? in_mirror : place;
    }
    return At(place, sought);
}

// A pixel, which may stand beyond the border of the image with others of its block.
Averaged Average(ivec2 pixel) {
    ivec2 inside = min(pixel, history.size - 1);
    float depth = texelFetch(depth_buffer, inside, 0).r;
    vec2 material = imageLoad(material_buffer, inside).rg;
    vec3 normal = imageLoad(normal_buffer, inside).xyz;
    float squared = dot(normal, normal);
    bool reflects = depth > 0.0 && material.r > REFLECTS_ABOVE && material.g > 0.0 && squared > NO_NORMAL;
    normal *= inversesqrt(max(squared, 1e-30));
    vec3 point = Unproject(history.clip_to_view, vec2(pixel) + 0.5, depth);
    float eye = ORTHOGRAPHIC ? 0.0 : length(point);
    Sums hits = OverBlock(pixel, HitsOf(pixel, material.g > WIDE_ABOVE, reflects ? eye : -1.0));
    Ends ends = EndsAround(hits, reflects ? eye : -1.0);
    float count = max(hits.second.z, 1.0);
    bool known = ends.away > 0.0;
    float inverse = known ? 1.0 / (eye + ends.away) : 0.0;
    vec3 mirrored = MirrorDirection(Sight(point), normal);
    SetAside(Sums(vec4(normal, depth), vec4(mirrored, inverse)));
    Sought sought = Sought(point, normal, point + ends.away * mirrored, 0.0, LobePower(material.g));
    Found found;
    uvec4 kept; // the pixel's own guide of the frame before
    if (SEARCH) {
        found = Search(inside, sought, known, ends.mover);
        kept = imageLoad(guide_before, inside);
    } else {
        kept = imageLoad(guide_before, inside);
        found = AtRest(inside, Unpack(kept), sought);
    }
    Sums own_values = TakenBack(); // normal and depth; mirrored direction and inverse
    // What the pixels of the block show.
    vec4 alone = imageLoad(reflection_buffer, inside);
    vec4 now = Linear(alone);
    vec4 own_sum = reflects ? now : vec4(0.0);
    Sums shows = OverBlock(pixel, Sums(own_sum, own_sum * own_sum));
    uint print = Alone(alone);
    bool stays = history.repeats != 0 && kept.z != 0u && (kept.w & ~255u) == print;
    // What changed by itself is not what it was.
    bool is_new = history.begins != 0 || (history.repeats != 0 && !SEARCH);
    float age = is_new ? 0.0 : found.age * found.agreement;
    vec4 mean = shows.first / count;
    float most = history.deviations * (!known || history.repeats != 0 ? 1.0 : history.rests != 0 ? AT_REST : AGREED);
    vec4 reach = most * sqrt(max(shows.second / count - mean * mean, vec4(0.0)));
    // What the pixel itself shows is as good as what is around it: so what stays as it is is not blurred.
    vec4 before = clamp(found.color, min(mean - reach, now), max(mean + reach, now));
    float within = min(FramesWithin(length(found.lag.mean), MOST_LAG), FramesWithin(found.lag.square, MOST_SQUARE));
    age = min(age + 1.0, within);
    // What is whole stays so while rays turn again for what a thing uncovered before it came to rest.
    bool is_whole = !SEARCH && history.rests > 1 && !is_new && found.age > history.frames - 0.5;
    float part = is_whole ? 0.0 : 1.0 / age, left = 1.0 - part;
    vec4 mixed = FromLinear(mix(before, now, part));
    vec4 shown = stays ? imageLoad(color_before, inside) : age > 1.0 ? mixed : alone;
    Averaged averaged;
    averaged.reflection = reflects ? shown : alone;
    vec3 lag = found.lag.mean;
    vec2 across = left * (SEARCH ? lag * mat3(history.view_to_view_before) * Tangents(own_values.second.xyz) : lag.xy);
    Guide guide = Guide(own_values.first.w, own_values.first.xyz, age, own_values.second.w, across, left * found.lag.square);
    averaged.guide = !reflects ? uvec4(0u) : stays ? kept : Pack(guide, print);
    averaged.color = vec4(0.0);
    if (COMPOSITE) {
        vec3 lit = imageLoad(color_buffer, inside).rgb;
        vec3 added = min(lit + material.r * averaged.reflection.a * averaged.reflection.rgb, vec3(GREATEST_HALF));
        averaged.color = vec4(material.r > REFLECTS_ABOVE ? added : lit, 1.0);
    }
    return averaged;
}

#endif
