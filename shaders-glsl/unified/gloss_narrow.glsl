// A ray a pixel for narrow lobes: nine directions. (One for two pixels, over a chequerboard, takes 0.7 of
// the time; the error is 1.5 times as large, and a third more changes under a moving camera.) Needs parameters.glsl.

#include "unified/gloss_trace.glsl"
#include "unified/gloss_record.glsl"

layout(location = 0) out uvec4 out_record;

// The pattern covers the inner part of the lobe; each ray's footprint reaches into the rest.
#define PART 0.5
// Footprints to a lobe, of the nine rays: each reaches into its neighbours', for steadiness under a moving camera.
#define FOOTPRINTS 4.5

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    out_record = NO_RECORD;
    vec2 material = imageLoad(material_buffer, pixel).rg;
    float depth = imageLoad(pyramid, PixelTexel(pixel)).r;
    vec3 normal = Normal(pixel);
    bool narrow = Reflects(material) && ListOf(material) == NARROW_LIST;
    if (!narrow || !(depth > 0.0) || !(dot(normal, normal) > 0.0))
        return;
    vec3 point = ViewPoint(vec2(pixel) + 0.5, depth);
    Lobe lobe = LobeOf(point, normal, material.g);
    vec2 u = LatticePoint(pixel, 3, 2, vec2(0.5));
    Hit hit;
    Seen seen = Look(pixel, depth, point, lobe, vec2(u.x * PART, u.y), FOOTPRINTS, 1.0, hit);
    float root = sqrt(lobe.power);
    out_record = Pack(Record(lobe.mirror, seen.density > 0.0 ? root : -root, seen.color));
}
