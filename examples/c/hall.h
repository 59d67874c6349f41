// The G-buffer of a hall at dusk, ray-traced on the CPU: a polished floor between two rows of columns, three spheres,
// and a round window behind which the sun sets. The hall stands for the scene of your own renderer; this file does
// nothing for reflections.

#ifndef HALL_H
#define HALL_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

enum { WIDTH = 800, HEIGHT = 450 };

// The images in the layout in which they are copied to the device; a uint16_t is a 16-bit float. Depth is reversed, 1
// at the near plane. Normals are in view space. The material has reflectivity and roughness in its first two channels.
// The colour is linear light without reflections.
typedef struct {
    float depth[WIDTH * HEIGHT];
    uint16_t normal[WIDTH * HEIGHT * 4], material[WIDTH * HEIGHT * 4], color[WIDTH * HEIGHT * 4];
} Hall;

typedef struct {
    float x, y, z;
} Vec;

// `f0` is the reflectivity at normal incidence; a material with f0 = 0 does not reflect.
typedef struct {
    Vec albedo, emission;
    float f0, roughness;
} Material;

// The nearest hit of a ray: `t` is its distance in metres, `number` that of the column or sphere.
typedef struct {
    float t;
    Vec normal;
    enum { FLOOR, CEILING, SIDE, END, COLUMN, SPHERE } kind;
    int number;
} Hit;

// AMBIENT_RAYS is the number of rays of the ambient light at a point.
enum { COLUMNS = 12, SPHERES = 3, SUN_SAMPLES = 64, LAMP_SAMPLES = 12, AMBIENT_RAYS = 16 };

// Lengths are in metres, PITCH in radians. The end wall lies at z = END_Z; SUN is the centre of its round window.
static const float NEAR = 0.1f, FAR = 100.0f, PI = 3.14159265f, PITCH = 0.05f;
static const Vec EYE = {0.35f, 1.75f, 4.6f};
static const float HALF_WIDTH = 7.5f, TOP = 7.6f, END_Z = -24.0f, COLUMN_RADIUS = 0.48f;
static const Vec SUN = {0, 4.1f, -23.9f};
static const float SUN_RADIUS = 3.3f;
static const struct {
    Vec center;
    float radius;
    Material material;
} BALLS[SPHERES] = {
    {{-1.75f, 0.95f, -4.6f}, 0.95f, {{0.62f, 0.11f, 0.07f}, {0, 0, 0}, 0.05f, 0.05f}},
    {{1.9f, 0.7f, -3.0f}, 0.7f, {{0.04f, 0.30f, 0.34f}, {0, 0, 0}, 0.05f, 0.05f}},
    {{0.55f, 0.42f, -1.3f}, 0.42f, {{0.9f, 0.8f, 0.6f}, {2.6f, 1.25f, 0.34f}, 0.0f, 1.0f}},
};
enum { LAMP = 2 }; // the number of the sphere that shines

static inline Vec vec(float x, float y, float z) { return (Vec){x, y, z}; }
static inline Vec add(Vec a, Vec b) { return vec(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Vec sub(Vec a, Vec b) { return vec(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Vec mul(Vec a, Vec b) { return vec(a.x * b.x, a.y * b.y, a.z * b.z); }
static inline Vec times(Vec a, float s) { return vec(a.x * s, a.y * s, a.z * s); }
static inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Vec unit(Vec a) { return times(a, 1 / sqrtf(dot(a, a))); }
static inline Vec cross(Vec a, Vec b) {
    return vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float clamp(float v, float low, float high) { return v < low ? low : v > high ? high : v; }
static inline Vec mix(Vec a, Vec b, float s) { return add(times(a, 1 - s), times(b, s)); }

// Rounds to the nearest 16-bit float; larger numbers become the largest finite one, 65504.
static inline uint16_t half_of_float(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    const uint16_t sign = (uint16_t)(bits >> 16 & 0x8000);
    bits &= 0x7fffffff;
    if (bits < 0x38800000) return (uint16_t)(sign | (uint16_t)lrintf(fabsf(value) * 16777216.0f));
    bits += 0xfff + (bits >> 13 & 1);
    return (uint16_t)(sign | (bits > 0x477fffff ? 0x7bff : (bits - 0x38000000) >> 13));
}

// The value of a 16-bit float.
static inline float float_of_half(uint16_t half) {
    const int exponent = half >> 10 & 31, mantissa = half & 1023;
    const float size = exponent == 0    ? ldexpf((float)mantissa, -24)
                       : exponent == 31 ? (mantissa ? NAN : INFINITY)
                                        : ldexpf((float)(mantissa + 1024), exponent - 25);
    return half & 0x8000 ? -size : size;
}

// Maps linear light to a byte of a picture by Narkowicz's tone curve and a gamma of 2.2.
static inline unsigned char display_byte(float light) {
    const float v = 0.85f * (light > 0 ? light : 0);
    const float curve = clamp(v * (2.51f * v + 0.03f) / (v * (2.43f * v + 0.59f) + 0.14f), 0, 1);
    return (unsigned char)lrintf(255 * powf(curve, 1 / 2.2f));
}

// Writes the camera's matrices, column by column. View space is right-handed, with y up, and the camera looks along -z.
// In Vulkan's viewport y points down, so that the projection negates y.
static inline void hall_camera(float view_to_clip[16], float world_to_view[16]) {
    const float f = 1 / tanf(0.5f * 52 * PI / 180), s = sinf(PITCH), c = cosf(PITCH);
    const float clip[16] = {
        f * HEIGHT / WIDTH, 0, 0, 0, 0, -f, 0, 0, 0, 0, NEAR / (FAR - NEAR), -1, 0, 0, NEAR * FAR / (FAR - NEAR), 0};
    const float view[16] = {1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, -EYE.x, -c * EYE.y + s * EYE.z, -s * EYE.y - c * EYE.z, 1};
    memcpy(view_to_clip, clip, sizeof clip);
    memcpy(world_to_view, view, sizeof view);
}

// Rotates a direction of the world into view space by the matrix `m`.
static inline Vec to_view(const float m[16], Vec v) {
    return vec(m[0] * v.x + m[4] * v.y + m[8] * v.z, m[1] * v.x + m[5] * v.y + m[9] * v.z,
               m[2] * v.x + m[6] * v.y + m[10] * v.z);
}

// The centre of the foot of column i.
static inline Vec column(int i) { return vec(i % 2 ? 4.3f : -4.3f, 0, -0.5f - 4 * (float)(i / 2)); }

// Replaces the hit if the one at distance t lies before it.
static inline void nearer(Hit *hit, float t, Vec normal, int kind, int number) {
    if (t > 1e-3f && t < hit->t) {
        hit->t = t;
        hit->normal = normal;
        hit->kind = kind;
        hit->number = number;
    }
}

// Finds the first surface on a ray within the distance `most`. Returns false, and leaves hit->t at `most`, if there is
// none.
static inline bool follow(Vec from, Vec along, float most, Hit *hit) {
    *hit = (Hit){.t = most};
    nearer(hit, -from.y / along.y, vec(0, 1, 0), FLOOR, 0);
    nearer(hit, (TOP - from.y) / along.y, vec(0, -1, 0), CEILING, 0);
    nearer(hit, (END_Z - from.z) / along.z, vec(0, 0, 1), END, 0);
    const float side = along.x < 0 ? -1 : 1;
    nearer(hit, (side * HALF_WIDTH - from.x) / along.x, vec(-side, 0, 0), SIDE, 0);
    for (int i = 0; i < SPHERES; i++) {
        const Vec to = sub(from, BALLS[i].center);
        const float b = dot(to, along), under = b * b - dot(to, to) + BALLS[i].radius * BALLS[i].radius;
        if (under < 0) continue;
        const float t = -b - sqrtf(under);
        nearer(hit, t, times(add(to, times(along, t)), 1 / BALLS[i].radius), SPHERE, i);
    }
    const float flat = along.x * along.x + along.z * along.z;
    for (int i = 0; i < COLUMNS; i++) {
        const Vec to = sub(from, column(i));
        // A column has three cylinders: a wide foot, the shaft, and a wide head.
        for (int part = 0; part < 3; part++) {
            const float radius = part == 1 ? COLUMN_RADIUS : 1.35f * COLUMN_RADIUS;
            const float low = part == 2 ? TOP - 0.5f : 0, high = part == 0 ? 0.35f : TOP;
            const float b = to.x * along.x + to.z * along.z;
            const float under = b * b - flat * (to.x * to.x + to.z * to.z - radius * radius);
            if (under < 0) continue;
            const float t = (-b - sqrtf(under)) / flat, y = from.y + t * along.y;
            const Vec normal = vec((to.x + t * along.x) / radius, 0, (to.z + t * along.z) / radius);
            if (y >= low && y <= high) nearer(hit, t, normal, COLUMN, i);
            const float lid = ((part == 0 ? high : low) - from.y) / along.y;
            const float x = to.x + lid * along.x, z = to.z + lid * along.z;
            if (part != 1 && x * x + z * z <= radius * radius)
                nearer(hit, lid, vec(0, part == 0 ? 1 : -1, 0), COLUMN, i);
        }
    }
    return hit->t < most;
}

// The light of the sky at a point of the window, in metres from the window's centre. Slats cover the lower half, and
// get wider towards its bottom.
static inline Vec dusk(float x, float y) {
    const float up = clamp(0.5f + 0.5f * y / SUN_RADIUS, 0, 1);
    const float slat = fmodf(y / SUN_RADIUS + 2, 0.22f) / 0.22f;
    if (y < 0.05f && slat < 0.12f + 0.45f * (0.5f - up)) return vec(0.03f, 0.015f, 0.03f);
    const float glow = expf(-(x * x + (y + 1.1f) * (y + 1.1f)) / 4);
    Vec sky = mix(vec(1.9f, 0.36f, 0.14f), vec(0.42f, 0.10f, 0.55f), up * up * (3 - 2 * up));
    return add(sky, times(vec(1.5f, 0.75f, 0.12f), glow));
}

// The light of the ring around column i.
static inline Vec ring(int i) { return i / 2 % 2 ? vec(0.1f, 1.3f, 1.9f) : vec(2.0f, 0.16f, 1.1f); }

// The material of the surface at a hit, whose place in the world is `position`.
static inline Material material_at(const Hit *hit, Vec position) {
    const Vec none = vec(0, 0, 0);
    switch (hit->kind) {
    case FLOOR: {
        const float u = position.x / 1.2f + 100.5f, v = position.z / 1.2f + 100, joint = 0.018f;
        const float fu = u - floorf(u), fv = v - floorf(v);
        if (fu < joint || fv < joint || fu > 1 - joint || fv > 1 - joint)
            return (Material){vec(0.015f, 0.015f, 0.02f), none, 0.03f, 0.5f};
        if (((int)u + (int)v) % 2) return (Material){vec(0.020f, 0.022f, 0.032f), none, 0.42f, 0.0f};
        return (Material){vec(0.075f, 0.070f, 0.078f), none, 0.26f, 0.09f};
    }
    case CEILING:
        return (Material){vec(0.10f, 0.085f, 0.11f), none, 0.02f, 0.8f};
    case SIDE: {
        const float panel = fabsf(fmodf(position.z + 100.5f, 4) - 2);
        return (Material){panel > 1.72f ? vec(0.05f, 0.04f, 0.06f) : vec(0.17f, 0.13f, 0.20f), none, 0.03f, 0.6f};
    }
    case END: {
        const Vec from = sub(position, SUN);
        const float r = sqrtf(from.x * from.x + from.y * from.y) / SUN_RADIUS;
        if (r < 1) return (Material){none, dusk(from.x, from.y), 0, 1};
        return (Material){r < 1.09f ? vec(0.30f, 0.24f, 0.20f) : vec(0.14f, 0.11f, 0.16f), none, 0.03f, 0.6f};
    }
    case COLUMN: {
        const bool shines = position.y > 2.55f && position.y < 2.66f;
        const float flute = 0.85f + 0.15f * cosf(20 * atan2f(hit->normal.x, hit->normal.z));
        return (Material){times(vec(0.50f, 0.45f, 0.44f), flute), shines ? ring(hit->number) : none, 0.04f, 0.3f};
    }
    default:
        return BALLS[hit->number].material;
    }
}

// Maps two numbers from 0 to 1 to a direction around a normal, with a density proportional to the cosine.
static inline Vec around(Vec normal, float a, float b) {
    const Vec side = unit(cross(fabsf(normal.y) < 0.9f ? vec(0, 1, 0) : vec(1, 0, 0), normal));
    const float r = sqrtf(a), angle = 2 * PI * b;
    const Vec flat = add(times(side, r * cosf(angle)), times(cross(normal, side), r * sinf(angle)));
    return unit(add(flat, times(normal, sqrtf(1 - a))));
}

// Returns the share of a lamp point's light that arrives at a surface, per area of the lamp and without shadows.
// `facing` is the lamp's normal at its point. Writes the distance and the direction to the point.
static inline float arrives(Vec position, Vec normal, Vec lamp, Vec facing, float *distance, Vec *along) {
    const Vec to = sub(lamp, position);
    *distance = sqrtf(dot(to, to));
    *along = times(to, 1 / *distance);
    const float cosines = clamp(dot(normal, *along), 0, 1) * clamp(-dot(facing, *along), 0, 1);
    return cosines / (PI * *distance * *distance);
}

// The light that reaches a surface: from the window, the lamp, the rings and all around. `turn` is the number of turns,
// from 0 to 1, by which the sample points of each light are rotated.
static inline Vec lit(Vec position, Vec normal, float turn) {
    Vec sum = vec(0, 0, 0), along;
    Hit hit;
    float distance;
    for (int i = 0; i < SUN_SAMPLES; i++) {
        const float r = SUN_RADIUS * sqrtf(((float)i + 0.5f) / SUN_SAMPLES), angle = 2.39996f * (float)i + 2 * PI * turn;
        const Vec from = vec(r * cosf(angle), r * sinf(angle), 0);
        const float share = arrives(position, normal, add(SUN, from), vec(0, 0, 1), &distance, &along);
        if (share > 0 && !follow(position, along, 0.995f * distance, &hit))
            sum = add(sum, times(dusk(from.x, from.y), 3.0f * share * PI * SUN_RADIUS * SUN_RADIUS / SUN_SAMPLES));
    }
    const float radius = BALLS[LAMP].radius;
    for (int i = 0; i < LAMP_SAMPLES; i++) {
        const float z = 1 - 2 * ((float)i + 0.5f) / LAMP_SAMPLES, angle = 2.39996f * (float)i + 2 * PI * turn;
        const Vec facing = vec(sqrtf(1 - z * z) * cosf(angle), z, sqrtf(1 - z * z) * sinf(angle));
        const Vec lamp = add(BALLS[LAMP].center, times(facing, radius));
        const float share = arrives(position, normal, lamp, facing, &distance, &along);
        if (share > 0 && !follow(position, along, 0.98f * distance, &hit))
            sum = add(sum, times(BALLS[LAMP].material.emission, 2.5f * share * 4 * PI * radius * radius / LAMP_SAMPLES));
    }
    for (int i = 0; i < COLUMNS; i++) {
        const Vec to = sub(add(column(i), vec(0, 2.6f, 0)), position);
        const float square = dot(to, to);
        const float facing = clamp(0.4f + 0.6f * dot(normal, to) / sqrtf(square), 0, 1);
        sum = add(sum, times(ring(i), 0.3f * facing / (square + 0.25f)));
    }
    float open = 0;
    for (int i = 0; i < AMBIENT_RAYS; i++) {
        const float a = ((float)i + 0.5f) / AMBIENT_RAYS, b = 0.61803f * (float)i + turn;
        open += follow(position, around(normal, a, b - floorf(b)), 2.5f, &hit) ? hit.t / 2.5f : 1;
    }
    return add(sum, times(vec(0.13f, 0.10f, 0.16f), open / AMBIENT_RAYS));
}

// Stores four channels of a texel as 16-bit floats.
static inline void put(uint16_t texel[4], float r, float g, float b, float a) {
    const float values[4] = {r, g, b, a};
    for (int i = 0; i < 4; i++) texel[i] = half_of_float(values[i]);
}

// Fills all images of the hall by one ray for each pixel.
static inline void draw_hall(Hall *hall) {
    float clip[16], view[16];
    hall_camera(clip, view);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const float x = ((float)(i % WIDTH) + 0.5f) / WIDTH * 2 - 1, y = ((float)(i / WIDTH) + 0.5f) / HEIGHT * 2 - 1;
        const Vec seen = vec(x / clip[0], y / clip[5], -1);
        // The rows of a rotation are the columns of its inverse.
        const Vec along = unit(vec(view[0] * seen.x + view[1] * seen.y + view[2] * seen.z,
                                   view[4] * seen.x + view[5] * seen.y + view[6] * seen.z,
                                   view[8] * seen.x + view[9] * seen.y + view[10] * seen.z));
        Hit hit;
        follow(EYE, along, FAR, &hit);
        const Vec position = add(EYE, times(along, hit.t));
        const float deep = -hit.t * to_view(view, along).z;
        hall->depth[i] = clip[14] / deep - clip[10];
        const Material m = material_at(&hit, position);
        const Vec normal = to_view(view, hit.normal);
        put(&hall->normal[4 * i], normal.x, normal.y, normal.z, 0);
        const float grazing = 1 - clamp(-dot(along, hit.normal), 0, 1);
        const float fresnel = m.f0 > 0 ? m.f0 + (1 - m.f0) * powf(grazing, 5) * (1 - m.roughness) : 0;
        put(&hall->material[4 * i], fresnel, m.roughness, 0, 0);
        // A hash of the pixel rotates its samples, so that the error of few samples looks like grain and not like
        // bands.
        const uint32_t hash = ((uint32_t)i * 2654435761u ^ (uint32_t)(i / WIDTH) * 2246822519u) * 3266489917u;
        const float turn = (float)(hash >> 8) / 16777216.0f;
        const Vec light = add(m.emission, mul(m.albedo, lit(position, hit.normal, turn)));
        put(&hall->color[4 * i], light.x, light.y, light.z, 1);
    }
}

#endif
