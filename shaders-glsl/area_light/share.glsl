// The share of a reflection lobe that a light with an extent fills: analytic highlights of spheres, capsules,
// cylinders, rectangles and cuboids with roughness. (In thesis 3.1.1, a ray that meets the light gets all of it; else
// the nearest distance counts, attenuated by the roughness.)
//
// The lobe is cos^a around the mirror direction r (docs/definitions.md, "Surfaces"), and m = a + 1. Within the angle x
// of r the lobe holds the share 1 - cos^m x, as a Gaussian does within G(x) = sqrt(-2 m ln cos x) standard deviations.
// So angles are measured by G, and a light between two edges at the signed distances x0 and x1 fills Phi(G(x1)) -
// Phi(G(x0)). Like the representative point (Karis 2013), this method looks only at the place where the light is
// nearest, but it also takes the light's extent from there. So the highlight keeps its energy: it tends to the light's
// radiance as the lobe narrows, and to the light's solid angle times the lobe as the light shrinks.
// tests/suite/area_light.rs states the error.

// Returns -2 ln cos x, computed as -ln(1 - sin^2 x). For a small x a series replaces the logarithm, which would lose
// digits there.
float MinusTwoLogCos(float x) {
    float q = sin(x) * sin(x);
    return q < 0.01 ? q * (1.0 + q * (0.5 + q / 3.0)) : -log(max(1.0 - q, 1e-6));
}

// A mirror counts as a lobe of 0.02 degrees, so that its highlights have smooth edges and no stairs.
#define MIRROR_M 1e7

// The m of a roughness, which is ln xi / ln cos(roughness / 2). The share 1 - xi of the lobe then lies within half the
// roughness of r. xi is 0.244, and -ln xi is 1.4105871.
float LobeExponent(float roughness) {
    return min(2.0 * 1.4105871 / max(MinusTwoLogCos(0.5 * roughness), 1e-12), MIRROR_M);
}

// The angle x in standard deviations of the Gaussian that stands for the lobe (G above), with the sign of x. The angle
// stops just below 90 degrees, where the logarithm has no value.
float LobeDeviations(float x, float m) {
    float g = sqrt(m * MinusTwoLogCos(min(abs(x), 1.5607)));
    return x < 0.0 ? -g : g;
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
float ShareBetween(float from, float to, float m) {
    return max(Phi(LobeDeviations(to, m)) - Phi(LobeDeviations(from, m)), 0.0);
}

// The part (0 to 1) of a light that lies above the plane of the surface, weighted by the lobe along the elevation. The
// light reaches from elevation e0 to e1, in radians. Directions below the surface carry no light.
float AboveHorizon(vec3 r, vec3 n, float e0, float e1, float m) {
    if (e0 >= 0.0)
        return 1.0;
    if (e1 <= 0.0)
        return 0.0;
    float e = asin(clamp(dot(r, n), -1.0, 1.0));
    float all = ShareBetween(e0 - e, e1 - e, m);
    return all > 1e-3 ? ShareBetween(-e, e1 - e, m) / all : e1 / (e1 - e0);
}

// The angle between the direction to p and the plane with the unit normal n, in radians; below 0 behind the plane.
float Elevation(vec3 p, vec3 n) {
    return asin(clamp(dot(normalize(p), n), -1.0, 1.0));
}

// Half the angle, in radians, that a ball fills as seen from the origin.
float HalfAngle(vec3 centre, float radius) {
    return asin(min(radius / max(length(centre), 1e-6), 1.0));
}

// Each function below that is named Share returns the share of the lobe that a light fills. The point that is lit is
// the origin; r is the unit mirror direction, n the unit normal, and m is alpha + 1.

float SphereShare(vec3 r, vec3 n, vec3 centre, float radius, float m) {
    if (dot(centre, centre) <= radius * radius)
        return 1.0;
    float s = HalfAngle(centre, radius);
    float x = Angle(r, centre);
    // If the lobe aims at the sphere's middle, the share is 1 - exp(-g^2 / 2). Divided by the share of a band as wide
    // as the sphere, it gives a factor for the other axis, across the band.
    float g = LobeDeviations(s, m);
    float across = (1.0 - exp(-0.5 * g * g)) / max(2.0 * Phi(g) - 1.0, 1e-6);
    float e = Elevation(centre, n);
    return ShareBetween(x - s, x + s, m) * across * AboveHorizon(r, n, e - s, e + s, m);
}

// The angle from one vector to another around an axis that is perpendicular to both.
float AngleAround(vec3 from, vec3 to, vec3 axis) {
    return atan(dot(cross(from, to), axis), dot(from, to));
}

// The share of a capsule whose axis goes from a to b, or with `flat_ends` of a cylinder with this axis.
float TubeShare(vec3 r, vec3 n, vec3 a, vec3 b, float radius, bool flat_ends, float m) {
    vec3 normal = cross(a, b);
    if (dot(normal, normal) < 1e-10 * dot(a, a) * dot(b, b))
        return SphereShare(r, n, dot(a, a) < dot(b, b) ? a : b, radius, m);
    normal = normalize(normal);
    // The angles of a and b along the great circle through both, measured from the circle's direction nearest to r.
    vec3 nearest = r - dot(r, normal) * normal;
    nearest = length(nearest) > 1e-6 ? normalize(nearest) : normalize(a + b);
    float to_a = AngleAround(nearest, a, normal), to_b = AngleAround(nearest, b, normal);
    if (to_b < to_a) { // the segment passes the direction opposite to `nearest`
        float arc = Angle(a, b);
        if (abs(to_a) < abs(to_b))
            to_b = to_a + arc;
        else
            to_a = to_b - arc;
    }
    // `t` is the place on the axis, from a (0) to b (1), that is nearest to r in angle.
    float t = abs(to_a) < abs(to_b) ? 0.0 : 1.0;
    if (to_a <= 0.0 && to_b >= 0.0) {
        vec3 along = b - a;
        float d = dot(cross(along, nearest), normal);
        t = abs(d) > 1e-12 ? clamp(-dot(cross(a, nearest), normal) / d, 0.0, 1.0) : 0.5;
    }
    // Half the tube's angular width at that place, and the angle between r and the great circle.
    float s = HalfAngle(mix(a, b, t), radius);
    float x = asin(min(abs(dot(r, normal)), 1.0));
    // Half the widths of the round ends along the circle. For a mirror this is the width where the ray passes an end,
    // and for a wide lobe the mean width of the end.
    float s_a = HalfAngle(a, radius), s_b = HalfAngle(b, radius);
    vec2 ends = vec2(s_a, s_b);
    vec2 sharp = ends * ends * m / (1.0 + ends * ends * m);
    ends = mix(0.25 * 3.14159265 * ends, sqrt(max(ends * ends - x * x, 0.0)), sharp);
    float from = to_a - ends.x, to = to_b + ends.y;
    if (flat_ends) {
        // A flat end is seen as an ellipse; `reach` is how far it reaches along the great circle, on either side of its
        // middle.
        vec3 rim = radius * normalize(cross(normal, b - a));
        vec4 reach = vec4(AngleAround(a, a - rim, normal), AngleAround(a, a + rim, normal),
                          AngleAround(b, b - rim, normal), AngleAround(b, b + rim, normal));
        vec2 middles = vec2(to_a, to_b), half_angles = vec2(s_a, s_b);
        // The nearer end may cover the other one, and where the ray passes an end, the width of that end counts.
        vec2 off = middles / max(0.5 * abs(reach.yw - reach.xz), 1e-6);
        vec2 wide = half_angles * sqrt(max(1.0 - off * off, 0.0));
        s = max(s, max(wide.x, wide.y));
        vec4 rims = middles.xxyy + reach * (ends / max(half_angles, 1e-9)).xxyy;
        from = min(min(rims.x, rims.y), min(rims.z, rims.w));
        to = max(max(rims.x, rims.y), max(rims.z, rims.w));
    }
    float e_a = Elevation(a, n), e_b = Elevation(b, n);
    return ShareBetween(x - s, x + s, m) * ShareBetween(from, to, m)
        * AboveHorizon(r, n, min(e_a - s_a, e_b - s_b), max(e_a + s_a, e_b + s_b), m);
}

// The share of the lobe on the light's side of an edge: Phi of the signed angle between r and the great circle through
// `from` and `to`, which is positive on the side of the light's `centre`.
float EdgeShare(vec3 r, vec3 from, vec3 to, vec3 centre, float m) {
    vec3 normal = normalize(cross(from, to));
    if (dot(normal, centre) < 0.0)
        normal = -normal;
    return Phi(LobeDeviations(asin(clamp(dot(r, normal), -1.0, 1.0)), m));
}

// The share of a rectangle, which shines in the direction half_u x half_v.
float RectangleShare(vec3 r, vec3 n, vec3 centre, vec3 half_u, vec3 half_v, float m) {
    if (dot(cross(half_u, half_v), centre) >= 0.0)
        return 0.0; // a rectangle is dark from behind
    vec3 p0 = centre - half_u - half_v, p1 = centre + half_u - half_v;
    vec3 p2 = centre + half_u + half_v, p3 = centre - half_u + half_v;
    // The shares of the strips between opposite edges, along u and along v.
    float u = EdgeShare(r, p1, p2, centre, m) + EdgeShare(r, p3, p0, centre, m) - 1.0;
    float v = EdgeShare(r, p0, p1, centre, m) + EdgeShare(r, p2, p3, centre, m) - 1.0;
    vec4 e = vec4(Elevation(p0, n), Elevation(p1, n), Elevation(p2, n), Elevation(p3, n));
    float lowest = min(min(e.x, e.y), min(e.z, e.w)), highest = max(max(e.x, e.y), max(e.z, e.w));
    return max(u, 0.0) * max(v, 0.0) * AboveHorizon(r, n, lowest, highest, m);
}

// The share of a cuboid: the sum of the shares of the faces that the point sees, at most three.
float CuboidShare(vec3 r, vec3 n, vec3 centre, vec3 half_u, vec3 half_v, float half_w, float m) {
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
        sum += RectangleShare(r, n, centre + side * outward, u, dot(cross(u, v), side * outward) > 0.0 ? v : -v, m);
    }
    return is_inside ? 1.0 : min(sum, 1.0);
}
