// The walk of a ray through the tree of a scene's triangles, and the test of one triangle. CPU twin:
// reference::triangles.
//
// The nodes are the compressed wide nodes of Ylitie, Karras and Laine (HPG 2017), as the crate obvhs lays them out. The
// walk pushes at most one group of nodes for each level below the root. The host refuses trees with more levels than
// the stack has room for, so that the stack cannot overflow. Each turn of the walk's loops clears a bit of a mask, so
// that no walk runs for ever, not even that of a ray with NaN, which meets no box.
//
// Moving things have a small tree of their own in the same buffer. Its root lies at the bottom of the stack, so that
// the walk visits it last.

#ifndef TRIANGLES_WALK_GLSL
#define TRIANGLES_WALK_GLSL

#include "triangles/scene.glsl"

// The hit of a ray on a triangle.
struct TriangleHit {
    float t;     // metres along a unit direction
    uint id;     // number of the triangle, with ASKS_MATERIAL; NO_TRIANGLE for none
    vec2 weight; // weights of the second and third corner
    float side;  // cosine between the ray and the triangle's normal; above 0 for a ray that comes from in front
};

// A ray in the coordinates of the tree. The ray meets only triangles whose plane lies off its start, and whose hit
// comes after the hit `after`: farther away, or equally far with a greater number.
struct TreeRay {
    vec3 origin;
    vec3 direction;     // unit
    uint own_triangle;  // the triangle that it begins on, as records number it, which it cannot meet; or NO_TRIANGLE
    float least_offset; // metres by which a triangle's plane must lie off the start for the triangle to be met
    TriangleHit after;
};

const TriangleHit NO_HIT = TriangleHit(NEVER, NO_TRIANGLE, vec2(0.0), 1.0);

// Makes a ray whose start may be off by up to `error` metres, and which begins before all hits.
TreeRay MakeTreeRay(vec3 origin, vec3 direction, uint own_triangle, float error) {
    TriangleHit before_all = TriangleHit(0.0, NO_TRIANGLE, vec2(0.0), 1.0);
    return TreeRay(origin, direction, own_triangle, error + 12.0 * ROUNDING * triangles.extent, before_all);
}

// The dot product, added up in the order of the CPU twin.
float DotInOrder(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// The cross product. Swapping a and b negates the result, to the bit.
vec3 CrossInOrder(vec3 a, vec3 b) {
    precise vec3 cross = a.yzx * b.zxy - a.zxy * b.yzx;
    return cross;
}

// Whether a hit comes after the hit `other`: farther away, or equally far with a greater number.
bool IsFarther(float t, uint id, TriangleHit other) {
    return t > other.t || (t == other.t && id > other.id);
}

// Whether a ray meets the triangle of a slot, from either side, and where. The sign of each edge function depends on
// nothing but the edge's corners and the ray, and swapping the corners negates the function, to the bit. So a ray
// between two triangles meets at least one of them (as in Woop, Benthin and Wald, "Watertight Ray/Triangle
// Intersection", JCGT 2013). A triangle without area in the ray's direction is not met. Nor is a triangle whose plane
// cannot be told, because of rounding, from the plane that the ray begins on: such a triangle lies beside the one that
// the ray begins on, or over it. The distance to a plane is the mean of three products of four roundings each, of
// lengths up to the scene's extent. So it errs by up to a dozen half units in the last place of this extent.
bool IntersectTriangle(TreeRay ray, int slot, out TriangleHit hit) {
    int corner = triangles.corners + 3 * slot;
    uvec4 first = Geometry(corner);
    precise vec3 a = uintBitsToFloat(first.xyz) - ray.origin;
    uvec4 second = Geometry(corner + 1);
    precise vec3 b = uintBitsToFloat(second.xyz) - ray.origin;
    precise vec3 c = uintBitsToFloat(Geometry(corner + 2).xyz) - ray.origin;
    float u = DotInOrder(ray.direction, CrossInOrder(c, b));
    float v = DotInOrder(ray.direction, CrossInOrder(a, c));
    float w = DotInOrder(ray.direction, CrossInOrder(b, a));
    precise float area = u + v + w;
    precise float inverse = 1.0 / area;
    precise vec2 weight = vec2(v, w) * inverse;
    precise float reach = u * DotInOrder(ray.direction, a) + v * DotInOrder(ray.direction, b)
                        + w * DotInOrder(ray.direction, c);
    precise float t = reach * inverse;
    // `scaled_distance / double_area` is the distance of the triangle's plane from the start.
    float double_area = uintBitsToFloat(second.w);
    float scaled_distance = area < 0.0 ? -reach : reach;
    bool inside = (min(min(u, v), w) >= 0.0 || max(max(u, v), w) <= 0.0) && area != 0.0
               && scaled_distance > ray.least_offset * double_area && first.w != ray.own_triangle;
    hit = TriangleHit(t, first.w, weight, area / double_area);
    return inside && (!ASKS || IsFarther(t, first.w, ray.after));
}

// Whether a hit comes before another one, given by its t and id: nearer, or equally near with a smaller number.
bool IsNearer(TriangleHit hit, float other_t, uint other_id) {
    return hit.t < other_t || (hit.t == other_t && hit.id < other_id);
}

// Replaces the best hit so far by the hit on the triangle of a slot, if the ray meets this triangle earlier.
void UpdateNearestHit(TreeRay ray, int slot, inout TriangleHit best) {
    TriangleHit hit;
    if (IntersectTriangle(ray, slot, hit) && IsNearer(hit, best.t, best.id))
        best = hit;
}

#if !defined(CONFIRMED) && !defined(RAY_QUERY)

// Byte i of a word; byte 0 is the lowest.
uint Byte(uint word, int i) {
    return word >> (8 * i) & 0xffu;
}

// Tests four children of a node, each of which is a byte of `meta`. The result has bits for the children that the ray
// meets before `nearest`; the walk visits them from the highest bit down. The upper three bits of a byte have one set
// bit for each triangle of a leaf, or one for an inner node. The lower five bits say where these bits stand in the
// result: from 24 on for an inner node, whose slot `octant` permutes so that nearer nodes come first.
uint IntersectChildren(uint meta, uvec3 low, uvec3 high, vec3 step, vec3 base, uint octant, float nearest) {
    uint inner = ((meta & meta << 1 & 0x10101010u) >> 4) * 0xffu;
    uint places = (meta ^ octant & inner) & 0x1f1f1f1fu;
    uint bits = meta >> 5 & 0x07070707u;
    uint hits = 0u;
    for (int i = 0; i < 4; ++i) {
        vec3 near = fma(vec3(Byte(low.x, i), Byte(low.y, i), Byte(low.z, i)), step, base);
        vec3 far = fma(vec3(Byte(high.x, i), Byte(high.y, i), Byte(high.z, i)), step, base);
        float entry = max(max(near.x, near.y), max(near.z, 0.0));
        float exit = min(min(far.x, far.y), min(far.z, nearest));
        hits |= entry <= exit ? Byte(bits, i) << Byte(places, i) : 0u;
    }
    return hits;
}

// The stacks of all threads of a workgroup, with the same entry of all stacks side by side. If each thread had an array
// of its own, registers would hold it, and leave room for few threads at a time.
const int WALKERS = int(gl_WorkGroupSize.x * gl_WorkGroupSize.y);
shared uvec2 stacks[WALK_ROOM * WALKERS];

// The nearest triangle that the ray meets after the hit `ray.after`.
TriangleHit TraverseTree(TreeRay ray) {
    // The nearest hit so far. Its weights on the triangle are computed again at the end, so that the walk need not hold
    // them.
    float nearest = NEVER;
    uint nearest_id = NO_TRIANGLE;
    int nearest_slot = 0;
    // No branch depends on a uniform block alone, since lavapipe of Mesa 22 compiles such a program at each dispatch
    // (docs/devices.md).
    int bottom = int(gl_LocalInvocationIndex), top = bottom + (triangles.moving > 0 ? WALKERS : 0);
    stacks[bottom] = uvec2(uint(triangles.moving), 0x80000000u);
    // Components of the direction that are nearly 0 get a tiny value instead, which changes no test of a box.
    vec3 direction = mix(ray.direction, vec3(1e-20), lessThan(abs(ray.direction), vec3(1e-20)));
    vec3 inverse = 1.0 / direction;
    bvec3 is_negative = lessThan(direction, vec3(0.0));
    uint octant = (is_negative.x ? 0u : 0x04040404u) | (is_negative.y ? 0u : 0x02020202u)
                | (is_negative.z ? 0u : 0x01010101u);
    // A group of nodes with one parent: the number of the first one, and a word. The word's upper eight bits are the
    // nodes that are still to be visited, and its lower eight bits the children of the parent that are inner nodes.
    uvec2 group = uvec2(0u, triangles.nodes > 0 ? 0x80000000u : 0u);
    while (true) {
        uvec2 leaves = uvec2(0u);
        if ((group.y & 0xff000000u) != 0u) {
            uint bits = group.y;
            int bit = findMSB(bits);
            group.y &= ~(1u << bit);
            if ((group.y & 0xff000000u) != 0u) {
                stacks[top] = group;
                top += WALKERS;
            }
            uint child = uint(bit - 24) ^ octant & 0xffu;
            int node = 5 * int(group.x + uint(bitCount(bits & ~(0xffffffffu << child))));
            uvec4 head = Geometry(node), kinds = Geometry(node + 1);
            uvec4 x = Geometry(node + 2), y = Geometry(node + 3), z = Geometry(node + 4);
            vec3 scale = uintBitsToFloat(uvec3(Byte(head.w, 0), Byte(head.w, 1), Byte(head.w, 2)) << 23);
            vec3 step = scale * inverse, base = (uintBitsToFloat(head.xyz) - ray.origin) * inverse;
            // Each axis has the low sides of children 0 to 3 and 4 to 7, then the high sides. They are swapped so that
            // the sides that the ray meets first come first.
            x = is_negative.x ? x.zwxy : x;
            y = is_negative.y ? y.zwxy : y;
            z = is_negative.z ? z.zwxy : z;
            uint hits = IntersectChildren(kinds.z, uvec3(x.x, y.x, z.x), uvec3(x.z, y.z, z.z), step, base, octant, nearest)
                      | IntersectChildren(kinds.w, uvec3(x.y, y.y, z.y), uvec3(x.w, y.w, z.w), step, base, octant, nearest);
            group = uvec2(kinds.x, hits & 0xff000000u | head.w >> 24);
            leaves = uvec2(kinds.y, hits & 0x00ffffffu);
        }
        // A thread whose node has no triangle tests one in vain, since most threads in step with it have one to test.
        // The condition stands at the loop's end, where lavapipe adds no turn (unified/pyramid.comp).
        do {
            bool is_leaf = leaves.y != 0u;
            int bit = is_leaf ? findMSB(leaves.y) : 0;
            leaves.y &= ~(1u << bit);
            int slot = is_leaf ? int(leaves.x) + bit : 0;
            TriangleHit hit;
            if (IntersectTriangle(ray, slot, hit) && is_leaf && IsNearer(hit, nearest, nearest_id)) {
                nearest = hit.t;
                nearest_id = hit.id;
                nearest_slot = slot;
            }
        } while (leaves.y != 0u);
        if ((group.y & 0xff000000u) == 0u) {
            if (top == bottom)
                break;
            top -= WALKERS;
            group = stacks[top];
        }
    }
    TriangleHit best = NO_HIT;
    if (nearest_id != NO_TRIANGLE)
        UpdateNearestHit(ray, nearest_slot, best);
    return best;
}

#endif

#endif
