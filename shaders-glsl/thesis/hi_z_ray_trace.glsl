// Hi-Z ray tracing (thesis 4.2.7: Eq. 4.3, 4.4, Alg. 4 and its listing). Needs parameters.glsl and
// hiZBuffer (nearest sampling: "otherwise the depth values for our cells will be interpolated").

// Eq. 4.3. 'z' must be in the interval [0, 1].
vec3 Ray(vec3 rayOrigin, vec3 rayDirection, float z) {
    return rayOrigin + rayDirection * z;
}

// Returns the number of cells for the specified texture size and MIP level.
vec2 GetCellCount(vec2 size, float level) {
    // Departure: at least one cell a side, as Vulkan's mip levels have; the listing's count is 0
    // where one side is used up before the other.
    return max(floor(size / (level > 0.0 ? exp2(level) : 1.0)), vec2(1.0));
}

// Converts the ray position to a cell index.
vec2 GetCell(vec2 ray, vec2 cellCount) {
    return floor(ray * cellCount);
}

// Check if cell index A is equal to cell index B.
bool CrossedCellBoundary(vec2 cellIndexA, vec2 cellIndexB) {
    return (cellIndexA.x != cellIndexB.x) || (cellIndexA.y != cellIndexB.y);
}

// The new ray position where the ray intersects with the specified cell's boundary.
vec3 IntersectCellBoundary(
    vec3 rayOrigin, vec3 rayDirection,
    vec2 cellIndex, vec2 cellCount,
    vec2 crossStep, vec2 crossOffset)
{
    // The cell index refers to the left-top corner of a cell: "crossStep" (1 for positive
    // direction, 0 for negative) goes to the side that the ray leaves by, "crossOffset" past it.
    vec2 cell = cellIndex + crossStep;
    cell /= cellCount;
    cell += crossOffset;

    // Interpolation factor "t" with this cell position and the ray origin. Erratum, kept: a
    // direction of 0 divides by zero here.
    vec2 delta = cell - rayOrigin.xy;
    delta /= rayDirection.xy;

    float t = min(delta.x, delta.y);
    return Ray(rayOrigin, rayDirection, t);
}

float GetCellMinimumDepthPlane(vec2 ray, float level) {
    return textureLod(hiZBuffer, ray, level).r;
}

// Alg. 4. P_ss: the pixel in screen space; V_ss: the reflection vector, V_ss.z > 0. `exhausted`
// says that the bound of iterations ended the loop; the ray is then returned where it stands.
vec3 HiZRayTrace(vec3 P_ss, vec3 V_ss, out bool exhausted) {
    vec2 crossStep = vec2(V_ss.x >= 0.0 ? 1.0 : -1.0, V_ss.y >= 0.0 ? 1.0 : -1.0);
    vec2 crossOffset = crossStep * (thesis.cross_offset / thesis.resolution);
    crossStep = clamp(crossStep, 0.0, 1.0);

    // Eq. 4.4: direction with z = 1, origin on the near clipping plane.
    vec3 rayDirection = V_ss / V_ss.z;
    vec3 rayOrigin = P_ss + rayDirection * -P_ss.z;

    // Leave the first cell, or the ray would hit its own surface (not printed; author's program).
    float level = float(thesis.start_level);
    vec2 cellCount = GetCellCount(thesis.resolution, level);
    vec3 ray = IntersectCellBoundary(
        rayOrigin, rayDirection, GetCell(P_ss.xy, cellCount), cellCount, crossStep, crossOffset);

    exhausted = false;
    int i = 0;
    while (level >= 0.0) {
        // Departure: Alg. 4 has no bound.
        if (i++ >= thesis.iterations) {
            exhausted = true;
            break;
        }
        cellCount = GetCellCount(thesis.resolution, level);
        vec2 cellIndex = GetCell(ray.xy, cellCount);

        // Intersect the minimum depth plane of the cell
        float minimumPlane = GetCellMinimumDepthPlane(ray.xy, level);
        vec3 planeRay = Ray(rayOrigin, rayDirection, max(ray.z, minimumPlane));

        if (CrossedCellBoundary(cellIndex, GetCell(planeRay.xy, cellCount))) {
            // The boundary is closer: go there, and up a level
            ray = IntersectCellBoundary(rayOrigin, rayDirection, cellIndex, cellCount, crossStep, crossOffset);
            level = min(float(thesis.max_level), level + 1.0);
        } else {
            // The minimum depth plane is closer: go there, and down a level
            ray = planeRay;
            level -= 1.0;
        }
        if (LeftScreen(ray.xy))
            return INVALID_RAY;
    }
    return ray; // Return intersection ray position
}
