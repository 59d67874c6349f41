// Where the frame before showed what a pixel reflects, and what it showed there. The stage says by SEARCH_LOOP whether loops over
// four pixels are unrolled.

#ifndef COMMON_HISTORY_SEARCH_GLSL
#define COMMON_HISTORY_SEARCH_GLSL

#include "common/history_guide.glsl"
#include "common/lobe.glsl"
#include "common/sight.glsl"
#include "common/sound.glsl"

// A point of an earlier frame is the same surface if its normal is turned by less than this cosine, and it lies off the
// plane by less than this share of its depth.
#define SAME_NORMAL 0.9
#define SAME_PLANE 0.02
// Least weight that pixels of the same surface must have among the four pixels around a place.
#define LEAST_SHARE 0.05
// What is reflected is as far away as it was, within this share.
#define SAME_DISTANCE 0.2
// How a mirror is curved is asked of the pixels so far away along each axis. They count if the way at the place between them is, within
// this share, what they say of it, and if the product of how much of each pixel the way becomes shorter by along both axes is above that.
#define BESIDE 2
#define UNEVEN 0.25
#define LEAST_SHORTENING 0.25

float Luminance(vec3 color) {
    return dot(color, vec3(0.2126, 0.7152, 0.0722));
}

// A reflection in a form of which means may be taken: its colour, black for a miss, and in a the luminance that is left
// of it after its fade.
vec4 Linear(vec4 reflection) {
    vec3 color = Sound(reflection.rgb);
    return vec4(color, Luminance(color) * reflection.a);
}

vec4 FromLinear(vec4 mean) {
    float whole = Luminance(mean.rgb);
    return vec4(Sound(mean.rgb), whole > 0.0 ? clamp(mean.a / whole, 0.0, 1.0) : 0.0);
}

// A pixel's surface and what it reflects, in the view space of the frame before.
struct Sought {
    vec3 surface;
    vec3 normal;
    vec3 end;      // the reflected point itself
    float inverse; // that of Guide which it should have; 0 if it is not known
    float power;   // of its lobe
};

// Whether a pixel of the frame before, whose point is `there`, showed the surface that is sought.
bool ShowsSurface(ivec2 pixel, Guide guide, vec3 there, Sought sought) {
    float off = abs(dot(there - sought.surface, sought.normal));
    bool same_plane = off < SAME_PLANE * Reach(there.z, history.clip_to_view_before);
    float facing = dot(guide.normal, sought.normal), squared = dot(guide.normal, guide.normal);
    bool same_normal = facing * abs(facing) > SAME_NORMAL * SAME_NORMAL * squared;
    return guide.age > 0.0 && same_plane && same_normal && IsOn(pixel);
}

// How much of what a pixel of the frame before showed is what is sought, and how far its average points past that.
float Agrees(ivec2 pixel, Guide guide, Sought sought, out Lag lag) {
    vec3 there = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    float agrees = ShowsSurface(pixel, guide, there, sought) ? 1.0 : 0.0;
    vec3 to = sought.end - there;
    vec3 mirrored = MirrorDirection(Sight(there), guide.normal);
    vec3 beside = to * inversesqrt(max(dot(to, to), 1e-30)) - mirrored;
    // Nothing is added where nothing moved. If every averaged frame that pointed past by v now points past by v + more, the mean of the
    // square v * v becomes that of v * v + 2 v * more + more * more.
    vec3 more = (sought.inverse > 0.0 ? sqrt(sought.power) : 0.0) * beside;
    vec3 before = Tangents(mirrored) * guide.lag;
    lag = Lag(before + more, max(guide.square + dot(2.0 * before + more, more), 0.0));
    float outside = 0.5 * sought.power * dot(beside, beside);
    // How far away what it reflected was.
    float nearer = (guide.inverse / max(sought.inverse, 1e-12) - 1.0) / SAME_DISTANCE;
    nearer *= nearer;
    float known = 1.0 / ((1.0 + outside + outside * outside) * (1.0 + nearer * nearer));
    return sought.inverse > 0.0 ? agrees * known : agrees;
}

float AgreesAt(vec2 position, Sought sought) {
    ivec2 pixel = ivec2(floor(position));
    Lag lag;
    return Agrees(pixel, GuideAt(pixel), sought, lag);
}

// A history that was found.
struct Found {
    vec4 color; // Linear
    float age;
    float agreement; // the part of it that agrees; 0 for none
    Lag lag;
};

const Found NOTHING = Found(vec4(0.0), 0.0, 0.0, Lag(vec3(0.0), 0.0));

// What the frame before showed of what is sought, around a position in pixels.
Found At(vec2 position, Sought sought) {
    position -= 0.5;
    vec2 first = floor(position), part = position - first;
    Found found = NOTHING;
    // Colours are loaded once nothing else is needed of the guides.
    vec4 weights = vec4(0.0);
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        ivec2 next = ivec2(i & 1, i >> 1);
        ivec2 pixel = ivec2(first) + next;
        vec2 near = mix(1.0 - part, part, vec2(next));
        Guide guide = GuideAt(pixel);
        Lag lag;
        float weight = near.x * near.y * Agrees(pixel, guide, sought, lag);
        found.age += weight * guide.age;
        found.agreement += weight;
        found.lag.mean += weight * lag.mean;
        found.lag.square += weight * lag.square;
        weights = mix(weights, vec4(weight), equal(ivec4(i), ivec4(0, 1, 2, 3)));
    }
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        ivec2 pixel = ivec2(first) + ivec2(i & 1, i >> 1);
        vec2 of_row = i < 2 ? weights.xy : weights.zw;
        vec4 color = imageLoad(color_before, clamp(pixel, ivec2(0), history.size - 1));
        found.color += ((i & 1) == 0 ? of_row.x : of_row.y) * Linear(color);
    }
    float whole = found.agreement;
    Lag lag = Lag(found.lag.mean / whole, found.lag.square / whole);
    return whole > LEAST_SHARE ? Found(found.color / whole, found.age / whole, whole, lag) : NOTHING;
}

// What a pixel itself showed, where nothing moved. Its lag stays that along its own two Tangents.
Found AtRest(ivec2 pixel, Guide guide, Sought sought) {
    vec3 there = Unproject(history.clip_to_view_before, vec2(pixel) + 0.5, guide.depth);
    Found found = Found(Linear(imageLoad(color_before, pixel)), guide.age, 1.0, Lag(vec3(guide.lag, 0.0), guide.square));
    return ShowsSurface(pixel, guide, there, sought) ? found : NOTHING;
}

// Where a plane mirror with a point and a normal, of any length, shows what is sought.
vec2 InPlane(vec3 point, vec3 normal, Sought sought) {
    float before_plane = dot(sought.end - point, normal) / max(dot(normal, normal), 1e-30);
    return Position(sought.end - 2.0 * before_plane * normal);
}

// From a pixel of the frame before to where the plane that touches the surface there would have mirrored what is sought. False where
// the pixel showed another surface.
bool WayFrom(ivec2 pixel, Sought sought, out vec2 way) {
    Guide guide = GuideAt(pixel);
    vec2 middle = vec2(pixel) + 0.5;
    vec3 there = Unproject(history.clip_to_view_before, middle, guide.depth);
    way = InPlane(there, guide.normal, sought) - middle;
    return ShowsSurface(pixel, guide, there, sought);
}

// Where a mirror showed what is sought, curved or not: at the place whose own plane leads back to it. From `on_surface`, the plane
// there leads to `in_plane`. How this way changes from pixel to pixel says how the mirror is curved, and one step of Newton's method
// ends where no way is left. Where the pixels around tell of no such change, as where a map turns the normals, it is `in_plane`.
vec2 InMirror(vec2 on_surface, vec2 in_plane, Sought sought) {
    vec2 way = in_plane - on_surface;
    ivec2 pixel = ivec2(floor(on_surface));
    vec4 sums = vec4(0.0), differences = vec4(0.0); // of the ways from both pixels along x, and along y
    bool same = true;
    SEARCH_LOOP for (int i = 0; i < 4; ++i) {
        bool is_along_y = i > 1, is_behind = (i & 1) == 1;
        int offset = is_behind ? BESIDE : -BESIDE;
        vec2 from;
        bool shows = WayFrom(pixel + (is_along_y ? ivec2(0, offset) : ivec2(offset, 0)), sought, from);
        same = same && shows;
        vec4 own = is_along_y ? vec4(0.0, 0.0, from) : vec4(from, 0.0, 0.0);
        sums += own;
        differences += is_behind ? own : -own;
    }
    mat2 change = mat2(differences / float(2 * BESIDE)); // of the way, for each pixel along x and along y
    // Where the way changes evenly, both pairs say what it is here.
    vec2 more = change * (on_surface - vec2(pixel) - 0.5);
    float off = max(distance(0.5 * sums.xy + more, way), distance(0.5 * sums.zw + more, way));
    float shortens = determinant(change);
    bool is_even = same && off < UNEVEN * max(length(way), 1.0) && shortens > LEAST_SHORTENING;
    vec2 solved = vec2(change[1].x * way.y - change[1].y * way.x, change[0].y * way.x - change[0].x * way.y);
    return is_even ? on_surface + solved / shortens : in_plane;
}

#endif
