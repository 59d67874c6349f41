// The share of a reflection lobe that a light with an extent fills: analytic highlights of spheres, capsules,
// cylinders, rectangles and cuboids with roughness. (In thesis 3.1.1, a ray that meets the light gets all of it; else
// the nearest distance counts, attenuated by the roughness.)
//
// The lobe is cos^a around the mirror direction r (docs/definitions.md, "Surfaces"), and p = a + 1 is its power. Within
// the angle x of r the lobe holds the share 1 - cos^p x, as a Gaussian does within G(x) = sqrt(-2 p ln cos x) standard
// deviations. So angles are measured by G, and a light between two edges at the signed angles x0 and x1 fills
// Phi(G(x1)) - Phi(G(x0)). Like the representative point (Karis 2013), this method looks only at the place where the
// light is nearest, but it also takes the light's extent from there. So the highlight keeps its energy: it tends to the
// light's radiance as the lobe narrows, and to the light's solid angle times the lobe as the light shrinks.
// tests/suite/area_light.rs states the error.

// Returns -2 ln cos x, computed as -ln(1 - sin^2 x). For a small x a series replaces the logarithm, which would lose
// digits there.
float MinusTwoLogCos(float x) {
    float sin_squared = sin(x) * sin(x);
    return sin_squared < 0.01 ? sin_squared * (1.0 + sin_squared * (0.5 + sin_squared / 3.0))
                              : -log(max(1.0 - sin_squared, 1e-6));
}

// The greatest power. A mirror counts as a lobe of 0.02 degrees, so that its highlights have smooth edges and no
// stairs.
#define MIRROR_POWER 1e7

// The power of a roughness, which is ln xi / ln cos(roughness / 2), at most MIRROR_POWER. The share 1 - xi of the lobe
// then lies within half the roughness of r. xi is 0.244, and -ln xi is 1.4105871.
float BoundedLobePower(float roughness) {
    return min(2.0 * 1.4105871 / max(MinusTwoLogCos(0.5 * roughness), 1e-12), MIRROR_POWER);
}

// The angle x in standard deviations of the Gaussian that stands for the lobe (G above), with the sign of x. The angle
// stops just below 90 degrees, where the logarithm has no value.
float LobeDeviations(float x, float power) {
    float deviations = sqrt(power * MinusTwoLogCos(min(abs(x), 1.5607)));
    return x < 0.0 ? -deviations : deviations;
}

// The distribution function of the standard normal distribution, with an error of at most 1.5e-4 (Bowling et al. 2009).
float Phi(float x) {
    x = clamp(x, -8.0, 8.0);
    return 1.0 / (1.0 + exp(-(1.5976 * x + 0.07056 * x * x * x)));
}

// The angle between two vectors of any length, in radians.
float Angle(vec3 a, vec3 b) {
    return atan(length(cross(a, b)), dot(a, b));
}

// The share of the lobe between two signed angles from its middle, in radians, measured along one axis.
float ShareBetween(float from, float to, float power) {
    return max(Phi(LobeDeviations(to, power)) - Phi(LobeDeviations(from, power)), 0.0);
}

// The part (0 to 1) of a light that lies above the plane of the surface, weighted by the lobe along the elevation. The
// light reaches from the elevation `lowest` to `highest`, in radians. Directions below the surface carry no light.
float AboveHorizon(vec3 r, vec3 n, float lowest, float highest, float power) {
    if (lowest >= 0.0)
        return 1.0;
    if (highest <= 0.0)
        return 0.0;
    float mirror_elevation = asin(clamp(dot(r, n), -1.0, 1.0));
    float whole = ShareBetween(lowest - mirror_elevation, highest - mirror_elevation, power);
    return whole > 1e-3 ? ShareBetween(-mirror_elevation, highest - mirror_elevation, power) / whole
                        : highest / (highest - lowest);
}

// The angle between the direction to p and the plane with the unit normal n, in radians; below 0 behind the plane.
float Elevation(vec3 p, vec3 n) {
    return asin(clamp(dot(normalize(p), n), -1.0, 1.0));
}

// Half the angle, in radians, that a ball fills as seen from the origin.
float HalfAngle(vec3 centre, float radius) {
    return asin(min(radius / max(length(centre), 1e-6), 1.0));
}

// Each function below whose name ends in Share returns the share of the lobe that a light fills. The point that is lit
// is the origin; r is the unit mirror direction, n the unit normal, and `power` that of the lobe.

float SphereShare(vec3 r, vec3 n, vec3 centre, float radius, float power) {
    if (dot(centre, centre) <= radius * radius)
        return 1.0;
    float half_angle = HalfAngle(centre, radius);
    float from_mirror = Angle(r, centre);
    // If the lobe aims at the sphere's middle, the share is 1 - exp(-deviations^2 / 2). Divided by the share of a band
    // as wide as the sphere, it gives a factor for the other axis, across the band.
    float deviations = LobeDeviations(half_angle, power);
    float across_band = (1.0 - exp(-0.5 * deviations * deviations)) / max(2.0 * Phi(deviations) - 1.0, 1e-6);
    float elevation = Elevation(centre, n);
    return ShareBetween(from_mirror - half_angle, from_mirror + half_angle, power) * across_band
        * AboveHorizon(r, n, elevation - half_angle, elevation + half_angle, power);
}

// The angle from one vector to another around an axis that is perpendicular to both.
float AngleAround(vec3 from, vec3 to, vec3 axis) {
    return atan(dot(cross(from, to), axis), dot(from, to));
}

// The share of a capsule whose axis goes from a to b, or with `flat_ends` of a cylinder with this axis.
float TubeShare(vec3 r, vec3 n, vec3 a, vec3 b, float radius, bool flat_ends, float power) {
    vec3 pole = cross(a, b); // of the great circle through both ends
    if (dot(pole, pole) < 1e-10 * dot(a, a) * dot(b, b))
        return SphereShare(r, n, dot(a, a) < dot(b, b) ? a : b, radius, power);
    pole = normalize(pole);
    // The angles of a and b along the great circle through both, measured from the circle's direction nearest to r.
    vec3 zero = r - dot(r, pole) * pole;
    zero = length(zero) > 1e-6 ? normalize(zero) : normalize(a + b);
    float angle_a = AngleAround(zero, a, pole), angle_b = AngleAround(zero, b, pole);
    if (angle_b < angle_a) { // the segment passes the direction opposite to `zero`
        float arc = Angle(a, b);
        if (abs(angle_a) < abs(angle_b))
            angle_b = angle_a + arc;
        else
            angle_a = angle_b - arc;
    }
    // `nearest_place` is the place on the axis, from a (0) to b (1), that is nearest to r in angle.
    float nearest_place = abs(angle_a) < abs(angle_b) ? 0.0 : 1.0;
    if (angle_a <= 0.0 && angle_b >= 0.0) {
        vec3 along = b - a;
        float denominator = dot(cross(along, zero), pole);
        nearest_place = abs(denominator) > 1e-12 ? clamp(-dot(cross(a, zero), pole) / denominator, 0.0, 1.0) : 0.5;
    }
    // Half the tube's angular width at that place, and the angle between r and the great circle.
    float half_width = HalfAngle(mix(a, b, nearest_place), radius);
    float off_circle = asin(min(abs(dot(r, pole)), 1.0));
    // Half the widths of the round ends along the circle. For a mirror this is the width where the ray passes an end,
    // and for a wide lobe the mean width of the end.
    float half_angle_a = HalfAngle(a, radius), half_angle_b = HalfAngle(b, radius);
    vec2 end_widths = vec2(half_angle_a, half_angle_b);
    vec2 sharpness = end_widths * end_widths * power / (1.0 + end_widths * end_widths * power);
    end_widths = mix(0.25 * 3.14159265 * end_widths,
                     sqrt(max(end_widths * end_widths - off_circle * off_circle, 0.0)), sharpness);
    float from = angle_a - end_widths.x, to = angle_b + end_widths.y;
    if (flat_ends) {
        // A flat end is seen as an ellipse; `reach` has its extent along the great circle, on either side of its
        // middle.
        vec3 rim = radius * normalize(cross(pole, b - a));
        vec4 reach = vec4(AngleAround(a, a - rim, pole), AngleAround(a, a + rim, pole),
                          AngleAround(b, b - rim, pole), AngleAround(b, b + rim, pole));
        vec2 middles = vec2(angle_a, angle_b), half_angles = vec2(half_angle_a, half_angle_b);
        // The nearer end may cover the other one, and where the ray passes an end, the width of that end counts.
        vec2 off_middle = middles / max(0.5 * abs(reach.yw - reach.xz), 1e-6);
        vec2 end_half_widths = half_angles * sqrt(max(1.0 - off_middle * off_middle, 0.0));
        half_width = max(half_width, max(end_half_widths.x, end_half_widths.y));
        vec4 rims = middles.xxyy + reach * (end_widths / max(half_angles, 1e-9)).xxyy;
        from = min(min(rims.x, rims.y), min(rims.z, rims.w));
        to = max(max(rims.x, rims.y), max(rims.z, rims.w));
    }
    float elevation_a = Elevation(a, n), elevation_b = Elevation(b, n);
    return ShareBetween(off_circle - half_width, off_circle + half_width, power) * ShareBetween(from, to, power)
        * AboveHorizon(r, n, min(elevation_a - half_angle_a, elevation_b - half_angle_b),
                       max(elevation_a + half_angle_a, elevation_b + half_angle_b), power);
}

// The share of the lobe on the light's side of an edge: Phi of the signed angle between r and the great circle through
// `from` and `to`, which is positive on the side of the light's `centre`.
float EdgeShare(vec3 r, vec3 from, vec3 to, vec3 centre, float power) {
    vec3 edge_normal = normalize(cross(from, to));
    if (dot(edge_normal, centre) < 0.0)
        edge_normal = -edge_normal;
    return Phi(LobeDeviations(asin(clamp(dot(r, edge_normal), -1.0, 1.0)), power));
}

// The share of a rectangle, which shines in the direction half_u x half_v.
float RectangleShare(vec3 r, vec3 n, vec3 centre, vec3 half_u, vec3 half_v, float power) {
    if (dot(cross(half_u, half_v), centre) >= 0.0)
        return 0.0; // a rectangle is dark from behind
    vec3 p0 = centre - half_u - half_v, p1 = centre + half_u - half_v;
    vec3 p2 = centre + half_u + half_v, p3 = centre - half_u + half_v;
    // The shares of the strips between opposite edges, along u and along v.
    float share_u = EdgeShare(r, p1, p2, centre, power) + EdgeShare(r, p3, p0, centre, power) - 1.0;
    float share_v = EdgeShare(r, p0, p1, centre, power) + EdgeShare(r, p2, p3, centre, power) - 1.0;
    vec4 elevations = vec4(Elevation(p0, n), Elevation(p1, n), Elevation(p2, n), Elevation(p3, n));
    float lowest = min(min(elevations.x, elevations.y), min(elevations.z, elevations.w));
    float highest = max(max(elevations.x, elevations.y), max(elevations.z, elevations.w));
    return max(share_u, 0.0) * max(share_v, 0.0) * AboveHorizon(r, n, lowest, highest, power);
}

// The share of a cuboid: the sum of the shares of the faces that the point sees, at most three.
float CuboidShare(vec3 r, vec3 n, vec3 centre, vec3 half_u, vec3 half_v, float half_w, float power) {
    vec3 halves[3] = vec3[3](half_u, half_v, half_w * normalize(cross(half_u, half_v)));
    float sum = 0.0;
    bool is_inside = true;
    for (int i = 0; i < 3; ++i) {
        vec3 outward = halves[i];
        // The face that looks towards the point that is lit.
        float side = dot(centre, outward) < 0.0 ? 1.0 : -1.0;
        if (abs(dot(centre, outward)) <= dot(outward, outward))
            continue; // the point lies between two faces, and neither shows its front
        is_inside = false;
        // A rectangle shines in the direction half_u x half_v.
        vec3 u = halves[(i + 1) % 3], v = halves[(i + 2) % 3];
        sum += RectangleShare(r, n, centre + side * outward, u, dot(cross(u, v), side * outward) > 0.0 ? v : -v, power);
    }
    return is_inside ? 1.0 : min(sum, 1.0);
}
