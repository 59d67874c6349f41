// The faces of a cube of images.

#ifndef CAPTURES_CUBE_GLSL
#define CAPTURES_CUBE_GLSL

// Turns a vector of world axes into the view space of a face; FromFace turns it back. Faces have Vulkan's order +x -x
// +y -y +z -z.
vec3 ToFace(vec3 v, int face) {
    return face == 0 ? vec3(-v.z, v.y, v.x)
         : face == 1 ? vec3(v.z, v.y, -v.x)
         : face == 2 ? vec3(v.x, -v.z, v.y)
         : face == 3 ? vec3(v.x, v.z, -v.y)
         : face == 4 ? v
         : vec3(-v.x, v.y, -v.z);
}

vec3 FromFace(vec3 v, int face) {
    return face == 0 ? vec3(v.z, v.y, -v.x)
         : face == 1 ? vec3(-v.z, v.y, v.x)
         : face == 2 ? vec3(v.x, v.z, -v.y)
         : face == 3 ? vec3(v.x, -v.z, v.y)
         : face == 4 ? v
         : vec3(-v.x, v.y, -v.z);
}

// The face, 0 to 5, in which a direction lies: that of the direction's greatest component.
int CubeFace(vec3 v) {
    vec3 a = abs(v);
    return a.x >= a.y && a.x >= a.z ? (v.x >= 0.0 ? 0 : 1)
         : a.y >= a.z               ? (v.y >= 0.0 ? 2 : 3)
                                    : (v.z >= 0.0 ? 4 : 5);
}

// Where a direction of world axes meets a cube map: texture coordinates in xy, and the face in z.
vec3 CubeFaceUv(vec3 v) {
    int face = CubeFace(v);
    vec3 q = ToFace(v, face);
    return vec3(q.xy / q.z * vec2(0.5, -0.5) + 0.5, float(face));
}

#endif
