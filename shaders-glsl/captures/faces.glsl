// Follows a ray in a capture, from face to face of the cube, by the same traversal as on the screen.
//
// A face is an image like the screen, with a field of view of 90 degrees, reversed depth and an exact pyramid
// (`unified` here is the uniform block of a face). A ray is a straight line in a face, and is followed until it is
// behind the front of a block. There it hits the block if it comes from in front, and else it is lost.

#ifndef CAPTURES_FACES_GLSL
#define CAPTURES_FACES_GLSL

#include "captures/captures.glsl"

int face_layer; // the face that is walked over: 6 capture + face

#include "unified/trace/traverse.glsl"

// Projects a point in the view space of a face to continuous pixel coordinates, and finds the pixel that it lies in.
vec2 FacePosition(vec3 face_point, out ivec2 pixel) {
    float side = float(unified.size.x);
    precise vec2 ndc = face_point.xy / face_point.z;
    precise vec2 position = (ndc * vec2(0.5, -0.5) + 0.5) * side;
    position = clamp(position, vec2(0.0), vec2(side));
    pixel = min(ivec2(position), unified.size - 1);
    return position;
}

// The reversed depth of a point at view-space z, in metres, in a face.
float FaceDepth(float z) {
    precise float depth = captures.face_unit / z - unified.depth_offset;
    return depth;
}

// Whether a capture sees a point, which is given relative to the capture's place. The point must lie beyond the near
// plane, and not behind the back of the block that the capture shows in its direction.
bool CaptureSees(int capture, vec3 point) {
    int face = CubeFace(point);
    vec3 face_point = ToFace(point, face);
    face_layer = 6 * capture + face;
    face_point.z = max(face_point.z, 1e-6);
    float depth = FaceDepth(face_point.z);
    ivec2 pixel;
    FacePosition(face_point, pixel);
    vec2 block = BLOCK_AT(PixelTexel(pixel));
    return depth < 1.0 && (block.x < block.y || depth >= block.y);
}

// How a ray ended in a capture or in one of its faces.
#define FOLLOW_HIT 0  // the ray hit something from in front
#define FOLLOW_SKY 1  // the ray left the scene
#define FOLLOW_LOST 2 // the ray went behind something, or too near to the capture's place
#define FOLLOW_ON 3   // the ray left a face by a side, and goes on in the next face

struct CaptureTrace {
    int how;    // FOLLOW_*
    vec3 place; // relative to the capture's place, world axes: where the hit is, or where the ray was lost
};

// The point of a ray at its parameter s, in the face's view space.
vec3 FacePoint(Ray ray, float s) {
    precise float depth = ray.depth + s * ray.rate.z;
    precise vec2 position = ray.start + s * ray.rate.xy;
    precise float z = captures.face_unit / max(depth + unified.depth_offset, 1e-12);
    precise vec3 point = ViewRay(position) * z;
    return point;
}

// Follows a ray over one face, from the point `begin` along a direction, both in the face's view space. `exit_side`
// becomes the unit vector, in this space, towards the side by which the ray leaves the face. `border_thickness` is the
// thickness of the block at the border of the face before, and becomes that of the block where the ray leaves this
// face. A surface across a border is taken to be as thick as the blocks on both sides together. `exhausted` is set if
// the walk runs out of steps, which cannot happen.
CaptureTrace TraceFace(vec3 begin, vec3 direction, inout bool exhausted, inout float border_thickness,
                       out vec3 exit_side) {
    ivec2 pixel;
    vec2 start = FacePosition(begin, pixel);
    float depth = FaceDepth(begin.z);
    precise vec2 ndc = vec2(2.0, -2.0) * (start / float(unified.size.x) - 0.5);
    precise vec2 change = direction.xy - ndc * direction.z;
    precise float change_z = -((depth + unified.depth_offset) * direction.z);
    // A ray straight towards the capture's place, or away from it, stays in its pixel. It gets a tiny change, too small
    // to leave the pixel, since MakeRay needs one.
    if (change == vec2(0.0))
        change.x = 1e-20;
    Ray ray = MakeRay(start, pixel, depth, direction, vec3(change, change_z));
    exit_side = vec3(0.0);
    if (!(depth < 1.0))
        return CaptureTrace(FOLLOW_LOST, begin);
    ivec2 ahead = Ahead(ray);
    // Most rays enter a face in free space, so that the walk begins at a coarse level.
    Walk walk = Walk(pixel, min(FACE_LEVEL, unified.top_level), 0.0, depth, 0);
    bool passes = false;
    int how = FOLLOW_ON;
    float end_s = ray.end;
    while (how == FOLLOW_ON) {
        Advance(ray, ahead, passes, walk);
        if (walk.level >= 0)
            break;
        // The ray is behind the front of a block. If it runs away from the block's surface and is still inside the
        // block, it leaves this surface, and passes. It hits any other block if it comes from in front, or over the
        // joint from a block of the same surface.
        vec2 block = BLOCK_AT(PixelTexel(walk.pixel));
        vec3 normal = NORMAL_AT(walk.pixel);
        float along_normal = Dot(direction, normal);
        bool in_front = walk.entry_depth >= block.x;
        passes = along_normal > 0.0 && walk.entry_depth >= block.y;
        if (!passes) {
            bool is_lost = along_normal > 0.0;
            precise float joint_back = block.y - border_thickness;
            if (!in_front && along_normal <= 0.0)
                is_lost = walk.entry > 0.0 ? IsBehind(ray, walk.entry_depth, walk.pixel, block, normal, ahead)
                                           : walk.entry_depth < joint_back;
            end_s = is_lost ? walk.entry : FrontCrossing(ray, walk, ahead, block.x);
            how = is_lost ? FOLLOW_LOST : FOLLOW_HIT;
        }
        walk.level = 0;
    }
    if (how == FOLLOW_ON) {
        exhausted = exhausted || walk.entry < ray.end;
        ivec2 far_corner = ahead * unified.size;
        precise vec2 sides = (vec2(far_corner) - ray.start) * ray.inverse;
        bool leaves_by_side = ray.end == min(sides.x, sides.y);
        precise vec2 at_side = ray.start + ray.end * ray.rate.xy;
        vec2 block = BLOCK_AT(PixelTexel(clamp(ivec2(at_side), ivec2(0), unified.size - 1)));
        border_thickness = max(block.x - block.y, 0.0);
        how = leaves_by_side ? FOLLOW_ON : ray.rate.z < 0.0 ? FOLLOW_SKY : FOLLOW_LOST;
        // Image y runs down.
        exit_side = sides.x <= sides.y ? vec3(ray.inverse.x > 0.0 ? 1.0 : -1.0, 0.0, 0.0)
                                       : vec3(0.0, ray.inverse.y > 0.0 ? -1.0 : 1.0, 0.0);
    }
    return CaptureTrace(how, FacePoint(ray, end_s));
}

// Follows a ray through a capture along a unit direction, from the point `begin`, which the capture sees. Point and
// direction have world axes, and `begin` is relative to the capture's place.
CaptureTrace TraceCapture(int capture, vec3 begin, vec3 direction, inout bool exhausted) {
    int face = CubeFace(begin);
    CaptureTrace result = CaptureTrace(FOLLOW_LOST, begin);
    float border_thickness = 0.0;
    // A line crosses each of the six planes between faces at most once, so that it visits seven faces at most.
    for (int i = 0; i < 7; ++i) {
        face_layer = 6 * capture + face;
        vec3 exit_side;
        result = TraceFace(ToFace(result.place, face), ToFace(direction, face), exhausted, border_thickness, exit_side);
        result.place = FromFace(result.place, face);
        if (result.how != FOLLOW_ON)
            return result;
        face = CubeFace(FromFace(exit_side, face));
    }
    return CaptureTrace(FOLLOW_LOST, result.place);
}

#endif
