// Linear ray march (thesis 4.2.2): with a constant stride, as the first listing, and with a growing one
// and binary search, as the second.
// Needs parameters.glsl and hiZBuffer, whose level 0 is the listing's depthBuffer.

#define INVALID_RAY vec3(-1.0)

bool LeftScreen(vec2 ray) {
    return any(lessThan(ray, vec2(0.0))) || any(greaterThan(ray, vec2(1.0)));
}

// First listing. Departure: leaving the screen ends the march, as the text says of practice.
vec3 UniformRayMarch(vec3 ray, vec3 dir, float stride, int count) {
    for (int i = 0; i < count; ++i) {
        if (LeftScreen(ray.xy))
            break;

        // Sample depth value at current ray position. Erratum: the listing lacks ".r".
        float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;

        // Check if ray steps through the depth buffer
        if (ray.z > depth)
            return ray; // Return final intersection

        // Step to the next sample position
        ray += dir * stride;
    }
    return INVALID_RAY; // No intersection found
}

vec3 BinarySearch(vec3 ray, vec3 dir) {
    for (int i = 0; i < thesis.binary_search_count; ++i) {
        // A search that leaves the screen has nothing left to refine (author's program).
        if (LeftScreen(ray.xy))
            break;

        // Sample depth value at current ray position. Erratum: the listing lacks ".r".
        float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;

        // Check if the 'depth delta' is smaller than our epsilon
        float depthDelta = depth - ray.z;
        if (abs(depthDelta) < thesis.depth_delta_epsilon)
            break; // Final intersection found -> break iteration

        // Move ray forwards if we are in front of geometry,
        // and move ray backwards if we are behind geometry.
        if (depthDelta > 0.0)
            ray += dir;
        else
            ray -= dir;

        // Decrease direction vector for further refinement
        dir *= thesis.binary_search_decrease;
    }
    return ray; // Intersection already found, but we could not refine it to the minimum
}

// Second listing.
vec3 LinearRayMarch(vec3 ray, vec3 dir, float stride) {
    vec3 prevRay = ray;
    int edgeHits = 0;

    for (int i = 0; i < thesis.linear_march_count; ++i) {
        // Sample depth value at current ray position. Erratum: the listing lacks ".r".
        float depth = textureLod(hiZBuffer, ray.xy, 0.0).r;

        // Check if ray steps through the depth buffer
        if (ray.z > depth) {
            // Intersection found -> now do a binary search
            return BinarySearch((prevRay + ray) * 0.5, dir * (stride * thesis.binary_search_first));
        }

        // Store previous position and step to the next sample position
        prevRay = ray;
        ray += dir * stride;

        // "In practice, we also check if the ray left the screen boundary, in which case we set
        // the ray back to its previous position and reduce the step size" (omitted in the listing;
        // halved, at most three times in a row, in the author's program).
        if (LeftScreen(ray.xy)) {
            if (edgeHits >= 3)
                break;
            ++edgeHits;
            ray = prevRay;
            stride *= 0.5;
            continue;
        }
        edgeHits = 0;

        // Increase stride to accelerate ray marching
        stride *= thesis.linear_march_increase;
    }
    return INVALID_RAY; // No intersection found
}
