// Billboard reflections: Schmidt 2013, section 5.3, listings 2 and 3. See ERRATA.md, "Billboards".
// Whoever includes this defines the two functions that the listings lack:
//   float BillboardLod(int i, vec3 wsPosition, float t)   the level that a pixel's footprint asks for
//   bool Occluded(vec3 wsPosition, vec3 wsReflectVec, float t)

#include "common/constants.glsl"

layout(constant_id = 0) const bool GLOW = false; // light spreads beyond the edges of billboards

struct ImpostorData {
    mat4 ModelMatrix; // the standard quad, 1 x 1 in x and z, to world space
};

layout(std140, binding = 1) uniform BillboardBlock {
    ImpostorData Impostor[MAX_IMPOSTORS];
    int billboardCount;
    int order;      // ORDER_…
    int occlusion;  // 1: Occlusion::Depth
    int blur;       // BLUR_…
    int premultiplied; // 1: the images' colours are multiplied by their alpha already
    float glow;        // beside an edge, as a share of the image's colour there
    float glowWidth;   // how far it reaches beyond an edge, metres
};

layout(binding = 2) uniform sampler2D ImpostorTex[MAX_IMPOSTORS];

// textureLod(ImpostorTex[i], uv, lod). Erratum B4: an index that is no constant needs a feature that not
// every device has, and texture() has no derivatives where neighbours left the loop.
vec4 Texel(int i, vec2 uv, float lod)
{
#define CASE(n) case n: return textureLod(ImpostorTex[n], uv, lod);
    switch (i)
    {
        CASE(0) CASE(1) CASE(2) CASE(3) CASE(4) CASE(5) CASE(6) CASE(7)
        CASE(8) CASE(9) CASE(10) CASE(11) CASE(12) CASE(13) CASE(14) CASE(15)
    }
#undef CASE
    return vec4(0.0);
}

// Width and height of an image.
vec2 TexelCount(int i)
{
#define CASE(n) case n: return vec2(textureSize(ImpostorTex[n], 0));
    switch (i)
    {
        CASE(0) CASE(1) CASE(2) CASE(3) CASE(4) CASE(5) CASE(6) CASE(7)
        CASE(8) CASE(9) CASE(10) CASE(11) CASE(12) CASE(13) CASE(14) CASE(15)
    }
#undef CASE
    return vec2(1.0);
}

float BillboardLod(int i, vec3 wsPosition, float t);
bool Occluded(vec3 wsPosition, vec3 wsReflectVec, float t);

// Print: listing 3.
// 1-4: Intersect a triangle with a given ray
vec3 IntersectTriangle(in vec3 rayOrigin, in vec3 rayDirect, in vec3 vert0, in vec3 vert1, in vec3 vert2)
{
    // 5-14: (u, v) are the barycentric coordinates, t is the distance
    float t, u, v;
    vec3 edge0, edge1;
    float det, inv_det;

    // 16-18: Calculate edges
    edge0 = vert1 - vert0;
    edge1 = vert2 - vert0;

    // 20, 21: Calculate p vector (P = D x E_2)
    vec3 pvec = cross(rayDirect, edge1);

    // 23-26: Calculate determinant and inverse of determinant
    // Erratum B8, kept: 0 for a ray along the plane.
    det = dot(edge0, pvec);
    inv_det = 1.0 / det;

    // 28-31: Calculate t vector (T = O - V_0), and the u parameter
    vec3 tvec = rayOrigin - vert0;
    u = dot(tvec, pvec) * inv_det;

    // 33-36: Calculate q vector (Q = T x E_0), and the v parameter
    vec3 qvec = cross(tvec, edge0);
    v = dot(rayDirect, qvec) * inv_det;

    // 38, 39: Calculate distance
    t = dot(edge1, qvec) * inv_det;

    // 41-43: Return results
    return vec3(u, v, t);
}

// What shows of the billboards on a ray: how far away, and how much it hides of what is behind it.
float shownDistance = 1e30;
float shownAlpha = 0.0;

// Print: listing 2.
// 11-20: Initial billboard (triangle is sufficient); build reflected ray
vec3 IntersectBillboard(in int i, in vec3 rayOrigin, in vec3 rayDirect)
{
    vec3 vert0 = vec3( 0.5, 0.0,  0.5);
    vec3 vert1 = vec3(-0.5, 0.0, -0.5);
    vec3 vert2 = vec3(-0.5, 0.0,  0.5);

    // 22-27: Transform billboard to world space
    vert0 = (Impostor[i].ModelMatrix * vec4(vert0, 1.0)).xyz;
    vert1 = (Impostor[i].ModelMatrix * vec4(vert1, 1.0)).xyz;
    vert2 = (Impostor[i].ModelMatrix * vec4(vert2, 1.0)).xyz;

    // 29-32: Intersect the billboard and get texture coordinates
    return IntersectTriangle(rayOrigin, rayDirect, vert2, vert0, vert1);
}

// 1-5: Billboard reflections
vec4 BillboardReflections(in vec3 wsPosition, in vec3 wsReflectVec)
{
    vec4 reflectedColor = vec4(0.0);

    // 7-10: For every Billboard in the scene
    for (int i = 0; i < billboardCount; i++)
    {
        vec3 uvt = IntersectBillboard(i, wsPosition, wsReflectVec);

        // 34-37: Break, if the distance is lower than 0.001
        // Erratum B1, kept: one billboard behind the pixel hides all that follow in the list. The order "unbroken" goes on.
        if (uvt.z <= 0.001 && order == ORDER_PRINTED)
            break;
        if (uvt.z <= 0.001)
            continue;

        // 39-44: Check if texture coordinates are valid between 0.0 and 1.0
        // Departure, off by default: what hides the billboard, which the conclusion asks for.
        if (uvt.x > 0.0 && uvt.x < 1.0 &&
            uvt.y > 0.0 && uvt.y < 1.0)
        {
            if (Occluded(wsPosition, wsReflectVec, uvt.z))
                continue;

            // 45-48: Check alpha channel of billboard texture; get texture for billboard and do alpha blending
            // Errata B2, B3, kept: the last in the list wins, not the nearest, and where it is transparent it blackens what
            // an earlier one gave; the image is read twice.
            float lod = BillboardLod(i, wsPosition, uvt.z);
            float alpha = Texel(i, uvt.xy, lod).a;
            reflectedColor.rgb = Texel(i, uvt.xy, lod).rgb * alpha;

            // Erratum B5: printed, a stays 0 and says of no pixel that it was hit.
            reflectedColor.a = alpha > 0.0 ? 1.0 : 0.0;
            if (GLOW) {
                shownDistance = uvt.z;
                shownAlpha = alpha;
            }
        }
    }

    // 49-53: return reflectedColor
    return reflectedColor;
}

// Departure: what the listing is after. From the nearest billboard on, each blended under those
// before it, until nothing shines through. Its back shows nothing: a window set back behind the face of
// its house would reflect that face.
vec4 NearestBillboardReflections(in vec3 wsPosition, in vec3 wsReflectVec)
{
    vec4 reflectedColor = vec4(0.0); // premultiplied
    float passed = 0.001;

    for (int n = 0; n < billboardCount && reflectedColor.a < 0.996; n++)
    {
        vec3 found = vec3(0.0);
        int which = -1;
        for (int i = 0; i < billboardCount; i++)
        {
            vec3 uvt = IntersectBillboard(i, wsPosition, wsReflectVec);
            bool faced = dot(wsReflectVec, Impostor[i].ModelMatrix[1].xyz) < 0.0;
            if (faced && uvt.z > passed && (which < 0 || uvt.z < found.z) &&
                uvt.x > 0.0 && uvt.x < 1.0 &&
                uvt.y > 0.0 && uvt.y < 1.0)
            {
                found = uvt;
                which = i;
            }
        }
        // What hides a billboard hides those behind it.
        if (which < 0 || Occluded(wsPosition, wsReflectVec, found.z))
            break;
        float lod = BillboardLod(which, wsPosition, found.z);
        vec4 texel = Texel(which, found.xy, lod);
        vec3 color = premultiplied == 1 ? texel.rgb : texel.rgb * texel.a;
        reflectedColor += (1.0 - reflectedColor.a) * vec4(color, texel.a);
        passed = found.z;
        if (GLOW) {
            shownDistance = n == 0 ? found.z : shownDistance;
            shownAlpha = reflectedColor.a;
        }
    }

    return vec4(reflectedColor.rgb, reflectedColor.a > 0.0 ? 1.0 : 0.0);
}

// Departure, off by default: the glow that the conclusion asks for. The light spreads beyond the edges of a billboard, towards
// its front, over what is behind it. It has the colour of the image where it is nearest, from the level whose texels are as wide
// as the light has spread, and it falls with the square of the way. Billboards in front of it, the image itself included, leave
// it the part that they do not cover.
vec3 BillboardGlow(in vec3 wsPosition, in vec3 wsReflectVec)
{
    vec3 light = vec3(0.0);

    for (int i = 0; i < billboardCount; i++)
    {
        vec3 uvt = IntersectBillboard(i, wsPosition, wsReflectVec);
        mat4 m = Impostor[i].ModelMatrix;
        vec2 sides = vec2(length(m[0].xyz), length(m[2].xyz));
        vec2 nearest = clamp(uvt.xy, 0.0, 1.0);
        float off = length((uvt.xy - nearest) * sides);
        if (!(uvt.z > 0.001 && off < glowWidth && dot(wsReflectVec, m[1].xyz) < 0.0))
            continue;
        // Billboards in one plane do not hide each other.
        float left = uvt.z >= 0.9999 * shownDistance ? 1.0 - shownAlpha : 1.0;
        if (left <= 0.0 || Occluded(wsPosition, wsReflectVec, uvt.z))
            continue;
        vec2 texels = TexelCount(i) / sides;
        float spread = max(off, 0.5 * glowWidth) * max(texels.x, texels.y);
        vec4 texel = Texel(i, nearest, max(log2(max(spread, 1.0)), BillboardLod(i, wsPosition, uvt.z)));
        float reach = 1.0 - off / glowWidth;
        light += left * reach * reach * (premultiplied == 1 ? texel.rgb : texel.rgb * texel.a);
    }

    return glow * light;
}
