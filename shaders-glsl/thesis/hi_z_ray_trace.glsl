// Hi-Z ray tracing (thesis 4.2.7: Eq. 4.3, 4.4, Alg. 4 and its listing). Needs parameters.glsl and
// hiZBuffer (nearest sampling: "otherwise the depth values for our cells will be interpolated").

// Print: §4.2.7, listing.
// 1-4: Parameterized ray-tracing procedure (Eq. 4.3). 'z' must be in the interval [0, 1]
vec3 Ray(vec3 rayOrigin, vec3 rayDirection, float z) {
    return rayOrigin + rayDirection * z;
}

// 6-9: Returns the number of cells for the specified texture size and MIP level
// Departure: at least one cell a side, as Vulkan's mip levels have; the listing's count is 0 where one side is used up
// before the other.
vec2 GetCellCount(vec2 size, float level) {
    return max(floor(size / (level > 0.0 ? exp2(level) : 1.0)), vec2(1.0));
}

// 11-14: Converts the ray position to a cell index
vec2 GetCell(vec2 ray, vec2 cellCount) {
    return floor(ray * cellCount);
}

// 16-21: Check if cell index A is equal to cell index B
bool CrossedCellBoundary(vec2 cellIndexA, vec2 cellIndexB) {
    return (cellIndexA.x != cellIndexB.x) || (cellIndexA.y != cellIndexB.y);
}

// 23-29: Computes the new ray position where the ray intersects with the specified cell's boundary
vec3 IntersectCellBoundary(
    vec3 rayOrigin, vec3 rayDirection,
    vec2 cellIndex, vec2 cellCount,
    vec2 crossStep, vec2 crossOffset)
{
    // 30-38: The cell index refers to the left-top corner: add "crossStep" (1 for positive direction, 0 for negative), and
    // then "crossOffset"
    vec2 cell = cellIndex + crossStep;
    cell /= cellCount;
    cell += crossOffset;

    // 40-45: Interpolation factor "t" with this cell position and the ray origin
    // Erratum, kept: a direction of 0 divides by zero here.
    vec2 delta = cell - rayOrigin.xy;
    delta /= rayDirection.xy;
    float t = min(delta.x, delta.y);

    // 47-49: Return final ray position
    return Ray(rayOrigin, rayDirection, t);
}

// The least standard depth of the cell in which a place lies.
float GetCellMinimumDepthPlane(vec2 ray, float level) {
    return textureLod(hiZBuffer, ray, level).r;
}

// The depth at which the ray crosses a cell's boundary: the z of a ray is its parameter (Eq. 4.4).
float GetCellBoundaryDepthPlane(
    vec3 rayOrigin, vec3 rayDirection,
    vec2 cellIndex, vec2 cellCount,
    vec2 crossStep, vec2 crossOffset)
{
    return IntersectCellBoundary(rayOrigin, rayDirection, cellIndex, cellCount, crossStep, crossOffset).z;
}

// Print: §4.2.7, Alg. 4.
// 1: HiZRayTrace(R)
// Departure: R is made here, of the pixel P_ss and the reflection vector V_ss, whose z is above 0. `exhausted` says that the
// bound of iterations ended the loop; the ray is then returned where it stands.
vec3 HiZRayTrace(vec3 P_ss, vec3 V_ss, out bool exhausted) {
    vec2 crossStep = vec2(V_ss.x >= 0.0 ? 1.0 : -1.0, V_ss.y >= 0.0 ? 1.0 : -1.0);
    vec2 crossOffset = crossStep * (thesis.cross_offset / thesis.resolution);
    crossStep = clamp(crossStep, 0.0, 1.0);

    // Print: §4.2.7, Eq. 4.4.
    // 1: R_direction := V_SS / V_SS_z, so that its z is 1
    vec3 rayDirection = V_ss / V_ss.z;
    // 2: R_origin := P_SS + R_direction * -P_SS_z, on the near clipping plane
    vec3 rayOrigin = P_ss + rayDirection * -P_ss.z;

    // Print: §4.2.7, Alg. 4.
    // 2: level <- 0
    float level = float(thesis.start_level);

    // Departure: first the ray leaves its cell, or it would hit its own surface (not printed; author's program).
    vec2 cellCount = GetCellCount(thesis.resolution, level);
    vec2 cellIndex = GetCell(P_ss.xy, cellCount);
    vec3 ray = IntersectCellBoundary(rayOrigin, rayDirection, cellIndex, cellCount, crossStep, crossOffset);

    // 3: while level >= 0 do
    // Departure: Alg. 4 has no bound.
    exhausted = false;
    int i = 0;
    while (level >= 0.0) {
        if (i++ >= thesis.iterations) {
            exhausted = true;
            break;
        }
        cellCount = GetCellCount(thesis.resolution, level);
        cellIndex = GetCell(ray.xy, cellCount);

        // 4: minimumPlane <- GetCellMinimumDepthPlane(...)
        // Departure: a plane in front of the ray would send it back; it stays where it is (author's program).
        float minimumPlane = max(ray.z, GetCellMinimumDepthPlane(ray.xy, level));

        // 5, 6: boundaryPlane <- GetCellBoundaryDepthPlane(...); closestPlane <- min{minimumPlane, boundaryPlane}
        // Departure: the boundary is the closer plane if the ray at the minimum plane lies in another cell. It is computed
        // only then.
        vec2 temporaryRay = Ray(rayOrigin, rayDirection, minimumPlane).xy;
        bool intersectedBoundary = CrossedCellBoundary(cellIndex, GetCell(temporaryRay, cellCount));
        float closestPlane = minimumPlane;
        if (intersectedBoundary) {
            float boundaryPlane = GetCellBoundaryDepthPlane(
                rayOrigin, rayDirection, cellIndex, cellCount, crossStep, crossOffset);
            closestPlane = boundaryPlane;
        }

        // 7: ray <- Ray(R, closestPlane); Intersect the closest plane
        ray = Ray(rayOrigin, rayDirection, closestPlane);

        // 8, 9: if IntersectedMinimumDepthPlane(...) then level <- level - 1; Go down a level
        if (!intersectedBoundary)
            level -= 1.0;
        // 10, 11: if IntersectedBoundaryDepthPlane(...) then level <- level + 1; Go up a level
        // Departure: not above the coarsest level, which is one cell.
        else
            level = min(float(thesis.max_level), level + 1.0);

        // Departure: a ray that leaves the screen is a miss; Alg. 4 lets it go on along the clamped border.
        if (LeftScreen(ray.xy))
            return INVALID_RAY;
    }
    // 12: return ray; Return intersection ray position
    return ray;
}
