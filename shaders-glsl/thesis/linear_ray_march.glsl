// Linear ray march (thesis 4.2.2): with a constant stride, as the first listing (UniformRayMarch), and with a growing one
// and a binary search, as the second (LinearRayMarch, BinarySearch). Both are called LinearRayMarch in print.
// Needs parameters.glsl and hiZBuffer, whose level 0 is the listings' depthBuffer.

// Print: §4.2.2, second listing.
// 1: LINEAR_MARCH_COUNT 100
layout(constant_id = 20) const int LINEAR_MARCH_COUNT = 100;
// 2: LINEAR_MARCH_INCREASE 1.5
layout(constant_id = 21) const float LINEAR_MARCH_INCREASE = 1.5;
// 3: BINARY_SEARCH_COUNT 32
layout(constant_id = 22) const int BINARY_SEARCH_COUNT = 32;
// 4: BINARY_SEARCH_DECREASE 0.5
layout(constant_id = 23) const float BINARY_SEARCH_DECREASE = 0.5;
// 5: DEPTH_DELTA_EPSILON 0.01
layout(constant_id = 24) const float DEPTH_DELTA_EPSILON = 0.01;
// 6: INVALID_RAY
#define INVALID_RAY vec3(-1.0)

bool LeftScreen(vec2 ray) {
    return any(lessThan(ray, vec2(0.0))) || any(greaterThan(ray, vec2(1.0)));
}

// Print: §4.2.2, first listing.
// 1, 2: LINEAR_MARCH_COUNT 100, INVALID_RAY
// Departure: both are declared above, as the second listing begins with the same lines.

// 4, 5: for LINEAR_MARCH_COUNT steps
vec3 UniformRayMarch(vec3 ray, vec3 dir, float stride) {
    for (int i = 0; i < LINEAR_MARCH_COUNT; ++i) {
        // Departure: leaving the screen ends the march, as the text says of practice.
        if (LeftScreen(ray.xy))
            break;

        // 6, 7: Sample depth value at current ray position
        // Erratum: the listing lacks ".r".
        float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;

        // 9-11: Check if ray steps through the depth buffer
        if (ray.z > depth)
            return ray; // Return final intersection

        // 13-15: Step to the next sample position
        ray += dir * stride;
    }
    // 16, 17: No intersection found
    return INVALID_RAY;
}

// Print: §4.2.2, second listing.
// 32, 33: for BINARY_SEARCH_COUNT steps
vec3 BinarySearch(vec3 ray, vec3 dir) {
    for (int i = 0; i < BINARY_SEARCH_COUNT; ++i) {
        // Departure: a search that leaves the screen has nothing left to refine (author's program).
        if (LeftScreen(ray.xy))
            break;

        // 34, 35: Sample depth value at current ray position
        // Erratum: the listing lacks ".r".
        float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;

        // 37-40: Check if the 'depth delta' is smaller than our epsilon
        float depthDelta = depth - ray.z;
        if (abs(depthDelta) < DEPTH_DELTA_EPSILON)
            break; // Final intersection found -> break iteration

        // 42-47: Move ray forwards if we are in front of geometry, and backwards if we are behind geometry
        if (depthDelta > 0.0)
            ray += dir;
        else
            ray -= dir;

        // 49-51: Decrease direction vector for further refinement
        dir *= BINARY_SEARCH_DECREASE;
    }
    // 53, 54: Intersection already found, but we could not refine it to the minimum
    return ray;
}

// 8, 9: prevRay
vec3 LinearRayMarch(vec3 ray, vec3 dir, float stride) {
    vec3 prevRay = ray;
    int edgeHits = 0;

    // 11: for LINEAR_MARCH_COUNT steps
    for (int i = 0; i < LINEAR_MARCH_COUNT; ++i) {
        // 12, 13: Sample depth value at current ray position
        // Erratum: the listing lacks ".r".
        float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;

        // 15-19: Check if ray steps through the depth buffer; intersection found -> now do a binary search
        // Departure: a factor on the search's first step, which is 1 as published (--search-first).
        if (ray.z > depth)
            return BinarySearch((prevRay + ray) * 0.5, dir * (stride * thesis.binary_search_first));

        // 21-23: Store previous position and step to the next sample position
        prevRay = ray;
        ray += dir * stride;

        // Departure: "In practice, we also check if the ray left the screen boundary, in which case we set the ray back to
        // its previous position and reduce the step size". The listing omits it. The author's program halves the step, at
        // most three times in a row.
        if (LeftScreen(ray.xy)) {
            if (edgeHits >= 3)
                break;
            ++edgeHits;
            ray = prevRay;
            stride *= 0.5;
            continue;
        }
        edgeHits = 0;

        // 25-27: Increase stride to accelerate ray marching
        stride *= LINEAR_MARCH_INCREASE;
    }
    // 29, 30: No intersection found
    return INVALID_RAY;
}
